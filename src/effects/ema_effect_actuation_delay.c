/* The motor sees the controller's output later. */
#include "effects/ema_effect_sites.h"

void ema_effect_actuation_delay_adjust(const ema_effect_actuation_delay_t* effect, ema_params_t* params)
{
    params->output_delay_s += effect->delay_s;
}
