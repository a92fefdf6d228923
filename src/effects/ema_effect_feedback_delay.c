/* The position loop sees an older position. */
#include "effects/ema_effect_sites.h"

void ema_effect_feedback_delay_adjust(const ema_effect_feedback_delay_t* effect, ema_params_t* params)
{
    params->delay_s += effect->delay_s;
}
