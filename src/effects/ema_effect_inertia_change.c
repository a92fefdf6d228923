/* Added or removed mass. */
#include "effects/ema_effect_sites.h"

void ema_effect_inertia_change_adjust(const ema_effect_inertia_change_t* effect, ema_params_t* params)
{
    params->inertia_kgm2 *= EMA_R(1.0) + effect->change;
}
