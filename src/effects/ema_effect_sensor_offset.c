/* Zero shift of the rod sensor. */
#include "effects/ema_effect_sites.h"

void ema_effect_sensor_offset_adjust(const ema_effect_sensor_offset_t* effect, ema_params_t* params)
{
    params->rod_offset_mm += effect->offset_mm;
}
