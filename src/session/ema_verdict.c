#include "session/ema_verdict.h"

#include "base/ema_bounds.h"
#include "base/ema_compiler.h"
#include "base/ema_math.h"

/* A node of a learned table stands for half a distance between nodes on either side of it, a thirtieth of the range. */
#define EMA_OUTSIDE_MAX EMA_R(0.0334)

/* A healthy answer may not hide a shift of so many thresholds: it lies surely below, which is 95 % to one side. */
#define EMA_HIDES_NONE EMA_R(3.0)
#define EMA_SURELY_LESS EMA_R(1.645)

/* Reasons that one parameter's estimate gives; `fault` is set when it is surely beyond its threshold. */
static uint32_t ema_estimate_reasons(const ema_identified_t* identified, const ema_estimate_t* estimate,
                                     ema_real healthy, const ema_params_t* params, bool* fault)
{
    uint32_t reasons = estimate->at_bound ? (uint32_t)EMA_REASON_AT_BOUND : 0U;
    const ema_real per_value_percent = EMA_R(100.0) / ema_abs(healthy);
    const ema_real scatter_percent = params->confidence_std * estimate->std * per_value_percent;
    const ema_real threshold_percent = identified->min_shift_percent;
    /* a sound machine that scatters so reads farther off than its threshold, to either side */
    const ema_real sound_percent = ema_max(threshold_percent, params->confidence_std * estimate->scatter_percent);
    const ema_real doubt_percent = scatter_percent + (estimate->bias * per_value_percent)
                                   + ((params->unseen_percent / EMA_R(100.0)) * threshold_percent);
    const ema_real not_hidden_percent =
        (EMA_HIDES_NONE * threshold_percent) - (EMA_SURELY_LESS * estimate->scatter_percent);
    /* every comparison is written so that NaN never counts as healthy */
    if (!(scatter_percent <= EMA_R(100.0))) {
        reasons |= (uint32_t)EMA_REASON_NOT_SENSITIVE;
    } else if (estimate->shift_percent > (sound_percent + doubt_percent)) {
        *fault = true;
    } else if (estimate->shift_percent < -(sound_percent + doubt_percent)) {
        reasons |= (uint32_t)EMA_REASON_BELOW_HEALTHY;
    } else if (!(estimate->shift_percent <= ema_min(not_hidden_percent, threshold_percent - doubt_percent))
               || !(estimate->shift_percent >= (doubt_percent - sound_percent))) {
        reasons |= (uint32_t)EMA_REASON_NEAR_THRESHOLD;
    } else {
        /* surely inside the threshold */
    }
    return reasons;
}

EMA_NOINLINE bool ema_residual_adequate(const ema_params_t* params, ema_real rms_mm, ema_real correlation)
{
    /* what neighbouring rows share beyond what the sensor's noise does is none, however small it is beside it */
    const ema_real shared_mm = rms_mm * ema_sqrt(ema_max(correlation, EMA_R(0.0)));
    const ema_real structure_mm = params->structure_ratio * params->position_noise_mm;
    const ema_real allowed_mm =
        ema_sqrt((structure_mm * structure_mm) + (params->shared_noise_mm * params->shared_noise_mm));
    return (rms_mm <= (params->adequacy_ratio * params->position_noise_mm)) && (shared_mm <= allowed_mm);
}

void ema_verdict_judge(const ema_session_config_t* config, bool determined, ema_result_t* result)
{
    const ema_params_t* const params = &config->actuator->params;
    bool fault = false;
    uint32_t reasons = determined ? 0U : (uint32_t)EMA_REASON_NOT_SENSITIVE;
    uint32_t near_threshold = 0U;
    for (uint32_t i = 0; i < config->identified_count; ++i) {
        const ema_real healthy = ema_value_of(config->actuator, config->identified[i].id);
        const uint32_t found =
            ema_estimate_reasons(&config->identified[i], &result->identified[i], healthy, params, &fault);
        near_threshold |= found & (uint32_t)EMA_REASON_NEAR_THRESHOLD;
        reasons |= found & ~(uint32_t)EMA_REASON_NEAR_THRESHOLD;
    }
    /* next to a sure fault, another parameter's doubt changes nothing */
    reasons |= fault ? 0U : near_threshold;
    result->adequate = ema_residual_adequate(params, result->residual_rms_mm, result->residual_correlation);
    reasons |= result->adequate ? 0U : (uint32_t)EMA_REASON_INADEQUATE;
    reasons |= (result->outcome == EMA_OUTCOME_BUDGET) ? (uint32_t)EMA_REASON_NOT_CONVERGED : 0U;
    reasons |= (result->outside_ratio <= EMA_OUTSIDE_MAX) ? 0U : (uint32_t)EMA_REASON_LEARNED_RANGE;
    result->reasons = reasons;
    if (reasons != 0U) {
        result->verdict = EMA_VERDICT_UNDECIDED;
    } else {
        result->verdict = fault ? EMA_VERDICT_FAULT : EMA_VERDICT_HEALTHY;
    }
}
