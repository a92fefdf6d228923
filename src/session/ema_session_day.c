/* Apart from ema_session.c so that firmware which does without it links none of it. */
#include <stddef.h>

#include "ema/ema_session.h"

/* What temperature makes of the healthy value: copper by 0.4 % and grease by 3 % a degree, some 50 degrees either way.
 */
#define EMA_GREASE_LOWER EMA_R(0.3)
#define EMA_GREASE_UPPER EMA_R(3.0)
#define EMA_WINDING_LOWER EMA_R(0.8)
#define EMA_WINDING_UPPER EMA_R(1.25)

/* No shift is a fault. */
#define EMA_ANY_SHIFT_PERCENT EMA_R(1.0e6)

static void ema_day_add(ema_session_config_t* config, ema_value_id_t id, ema_real healthy, ema_real lower,
                        ema_real upper)
{
    if (healthy > EMA_R(0.0)) {
        const ema_identified_t added = {id, lower * healthy, upper * healthy, EMA_ANY_SHIFT_PERCENT};
        config->identified[config->identified_count] = added;
        ++config->identified_count;
    }
}

ema_status_t ema_session_config_day(ema_session_config_t* config)
{
    if ((config == NULL) || (config->actuator == NULL)) {
        return EMA_ERR_NULL;
    }
    const ema_params_t* const params = &config->actuator->params;
    if (config->actuator->options.day_values == 0) {
        return EMA_OK;
    }
    const uint32_t before = config->identified_count;
    if ((before < 1U) || ((before + 2U) > EMA_IDENTIFIED_MAX)) {
        return EMA_ERR_RANGE;
    }
    ema_day_add(config, EMA_VALUE_ID(viscous_Nm_s_per_rad), params->viscous_Nm_s_per_rad, EMA_GREASE_LOWER,
                EMA_GREASE_UPPER);
    ema_day_add(config, EMA_VALUE_ID(resistance_ohm), params->resistance_ohm, EMA_WINDING_LOWER, EMA_WINDING_UPPER);
    config->annealer.stall_evaluations = (config->annealer.stall_evaluations / before) * config->identified_count;
    return EMA_OK;
}
