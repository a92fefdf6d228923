/* Apart from ema_session.c so that firmware which does without it links none of it. */
#include <stddef.h>

#include "ema/ema_session.h"

#include "base/ema_math.h"

/* Standard deviations on either side that hold 95 % of a normal distribution. */
#define EMA_WIDTH_95 EMA_R(1.96)

/* What is not seen is stated as three standard deviations, as a share of a share in %. */
#define EMA_UNSEEN_STDS EMA_R(3.0e4)

ema_status_t ema_session_half_95(const ema_session_config_t* config, const ema_result_t* result, uint32_t place,
                                 ema_real* half_95)
{
    if ((config == NULL) || (config->actuator == NULL) || (result == NULL) || (half_95 == NULL)) {
        return EMA_ERR_NULL;
    }
    if ((place >= config->identified_count) || (place >= result->identified_count) || (place >= EMA_IDENTIFIED_MAX)) {
        return EMA_ERR_RANGE;
    }
    const ema_identified_t* const identified = &config->identified[place];
    const ema_estimate_t* const estimate = &result->identified[place];
    const uint32_t open = (uint32_t)EMA_REASON_NOT_FINISHED | (uint32_t)EMA_REASON_NOT_SENSITIVE;
    if (((result->reasons & open) != 0U) && !(estimate->std > EMA_R(0.0))) {
        *half_95 = identified->upper - identified->lower;
        return EMA_OK;
    }
    ema_real healthy = EMA_R(0.0);
    (void)ema_actuator_get(config->actuator, identified->id, &healthy);
    const ema_real value = ema_max(ema_abs(estimate->estimate), ema_abs(healthy));
    const ema_real scatter = (estimate->scatter_percent / EMA_R(100.0)) * value;
    /* three standard deviations of it, of the healthy value, in ten thousandths */
    const ema_real unseen =
        ((config->actuator->params.unseen_percent * identified->min_shift_percent) / EMA_UNSEEN_STDS) * healthy;
    const ema_real square =
        ((estimate->std * estimate->std) + (estimate->bias * estimate->bias)) + (scatter * scatter) + (unseen * unseen);
    *half_95 = EMA_WIDTH_95 * ema_sqrt(square);
    return EMA_OK;
}
