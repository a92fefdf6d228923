/* A bus voltage below its nominal value. */
#include "effects/ema_effect_sites.h"

void ema_effect_supply_sag_adjust(const ema_effect_supply_sag_t* effect, ema_params_t* params)
{
    params->supply_V *= EMA_R(1.0) - effect->sag;
}
