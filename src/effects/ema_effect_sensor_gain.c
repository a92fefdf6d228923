/* Scale error of the rod sensor. */
#include "effects/ema_effect_sites.h"

void ema_effect_sensor_gain_adjust(const ema_effect_sensor_gain_t* effect, ema_params_t* params)
{
    params->rod_gain_error += effect->error;
}
