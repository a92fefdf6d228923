#include "blocks/ema_encoder.h"

#include "blocks/ema_limits.h"

void ema_encoder_prepare(ema_encoder_t* encoder, const ema_params_t* params, const ema_options_t* options)
{
    encoder->at_rod = options->side == 1;
    encoder->rod_gain = EMA_R(1.0) + params->rod_gain_error;
    encoder->rod_offset_mm = params->rod_offset_mm;
#if EMA_ONLY_EXACT
    encoder->plain = true;
#else
    /* checked already: the bound says so where it is converted */
    const ema_real steps = ema_min(params->delay_s / params->step_s, EMA_DELAY_STEPS_MAX);
    encoder->resolution_mm = params->resolution_mm;
    encoder->steps_per_mm = (params->resolution_mm > EMA_R(0.0)) ? (EMA_R(1.0) / params->resolution_mm) : EMA_R(0.0);
    encoder->delay_steps = (uint16_t)steps;
    encoder->delay_part = steps - (ema_real)encoder->delay_steps;
    encoder->plain = !(params->delay_s > EMA_R(0.0)) && !(params->resolution_mm > EMA_R(0.0));
#endif
}

ema_real ema_encoder_general(const ema_encoder_t* encoder, ema_state_t* state, ema_real position_mm)
{
    const uint32_t mask = EMA_DELAY_SAMPLES - 1U;
    state->delay_mm[state->step & mask] = position_mm;
    const uint32_t at = state->step - encoder->delay_steps;
    const ema_real first = state->delay_mm[at & mask];
    ema_real value = first;
    if (encoder->delay_part > EMA_R(0.0)) {
        const ema_real f = encoder->delay_part;
        const ema_real second = state->delay_mm[(at - 1U) & mask];
        const ema_real third = state->delay_mm[(at - 2U) & mask];
        /* parabola through the three samples, written around the first so that a constant stays exact */
        value = first
                + (f
                   * (((EMA_R(2.0) * (second - first)) - (EMA_R(0.5) * (third - first)))
                      + (f * ((EMA_R(0.5) * (third - first)) - (second - first)))));
    }
    if (encoder->resolution_mm > EMA_R(0.0)) {
        value = ema_floor((value * encoder->steps_per_mm) + EMA_R(0.5)) * encoder->resolution_mm;
    }
    return value;
}
