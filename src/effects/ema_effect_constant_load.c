/* Constant torque against extension. */
#include "effects/ema_effect_sites.h"

void ema_effect_constant_load_adjust(const ema_effect_constant_load_t* effect, ema_params_t* params)
{
    params->load_torque_Nm += effect->torque_Nm;
}
