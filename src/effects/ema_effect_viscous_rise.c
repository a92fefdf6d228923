/* More viscous damping, as in cold grease. */
#include "effects/ema_effect_sites.h"

void ema_effect_viscous_rise_adjust(const ema_effect_viscous_rise_t* effect, ema_params_t* params)
{
    params->viscous_Nm_s_per_rad *= EMA_R(1.0) + effect->rise;
}
