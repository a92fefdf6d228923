/* Apart from ema_session.c so that firmware which does without it links none of it. */
#include <stddef.h>

#include "base/ema_copy.h"
#include "ema/ema_session.h"

uint32_t ema_session_check(const ema_session_config_t* config)
{
    if ((config == NULL) || (config->actuator == NULL)) {
        return 0U;
    }
    const ema_params_t* const params = &config->actuator->params;
    ema_annealer_config_t annealer;
    ema_copy(&annealer, &config->annealer, sizeof annealer);
    annealer.dimension =
        (config->identified_count < EMA_IDENTIFIED_MAX) ? config->identified_count : EMA_IDENTIFIED_MAX;
    for (uint32_t i = 0; config->start_at_healthy && (i < annealer.dimension); ++i) {
        const ema_identified_t* const identified = &config->identified[i];
        ema_real healthy = EMA_R(0.0);
        (void)ema_actuator_get(config->actuator, identified->id, &healthy);
        annealer.start[i] = (healthy - identified->lower) / (identified->upper - identified->lower);
    }
    /* with other signals in it the objective's noise is not known here */
    bool alone = config->weight[EMA_CHANNEL_POSITION] > EMA_R(0.0);
    for (uint32_t channel = 0; channel < (uint32_t)EMA_CHANNEL_COUNT; ++channel) {
        alone = alone && ((channel == (uint32_t)EMA_CHANNEL_POSITION) || (config->weight[channel] == EMA_R(0.0)));
    }
    const ema_real period_s = params->step_s * (ema_real)config->actuator->options.record_every_steps;
    const ema_real noise_mm = params->position_noise_mm;
    const ema_real resolution =
        alone ? (config->weight[EMA_CHANNEL_POSITION] * noise_mm * noise_mm * period_s) : EMA_R(0.0);
    return ema_annealer_check(&annealer, resolution);
}
