/* The position gain of the control law has drifted, in either structure. */
#include "effects/ema_effect_sites.h"

void ema_effect_gain_drift_adjust(const ema_effect_gain_drift_t* effect, ema_params_t* params)
{
    params->kp_per_m *= EMA_R(1.0) + effect->drift;
    params->position_gain_per_s *= EMA_R(1.0) + effect->drift;
}
