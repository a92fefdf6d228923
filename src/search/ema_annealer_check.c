/* Apart from ema_annealer.c so that firmware which does without it links none of it. */
#include "ema/detail/ema_annealer_check.h"

#include "base/ema_math.h"

#include <stddef.h>

/* The limits of the rules, chosen on a design of settings and counted on another: docs/ROBUSTNESS.md. */

/* Evaluations that one dimension needs. */
#define EMA_FEWEST_PER_DIMENSION 30U

/* Times the resolution, at the most: the last temperature, and the tolerance. */
#define EMA_LAST_OVER_RESOLUTION EMA_R(30.0)
#define EMA_TOLERANCE_OVER_RESOLUTION EMA_R(100.0)

/* Times the tolerance, at the least: the first temperature. */
#define EMA_FIRST_OVER_TOLERANCE EMA_R(1.0e-3)

/* Accepted candidates between two reannealings at the least. */
#define EMA_REANNEAL_LEAST 10U

static bool ema_start_outside(const ema_annealer_config_t* config)
{
    bool outside = false;
    for (uint32_t i = 0; (i < config->dimension) && (i < EMA_ANNEALER_DIMENSION_MAX); ++i) {
        outside = outside || !((config->start[i] >= EMA_R(0.0)) && (config->start[i] <= EMA_R(1.0)));
    }
    return outside;
}

static uint32_t ema_warning_if(bool holds, uint32_t warning)
{
    return holds ? warning : 0U;
}

uint32_t ema_annealer_check(const ema_annealer_config_t* config, ema_real resolution)
{
    if (config == NULL) {
        return 0U;
    }
    uint32_t warnings = ema_warning_if(ema_start_outside(config), (uint32_t)EMA_WARNING_START);
    warnings |= ema_warning_if(config->evaluation_budget < (EMA_FEWEST_PER_DIMENSION * config->dimension),
                               (uint32_t)EMA_WARNING_FEW);
    warnings |= ema_warning_if((config->reanneal_interval > 0U) && (config->reanneal_interval < EMA_REANNEAL_LEAST),
                               (uint32_t)EMA_WARNING_REANNEALED);
    const bool known = (resolution > EMA_R(0.0)) && ema_is_finite(resolution);
    const ema_real first = config->initial_temperature;
    const ema_real tolerance = config->function_tolerance;
    warnings |= ema_warning_if(known && (tolerance > (EMA_TOLERANCE_OVER_RESOLUTION * resolution)),
                               (uint32_t)EMA_WARNING_TOLERANCE);
    warnings |= ema_warning_if(first < (EMA_FIRST_OVER_TOLERANCE * tolerance), (uint32_t)EMA_WARNING_COLD);
    const ema_real cold = EMA_LAST_OVER_RESOLUTION * (known ? resolution : tolerance);
    const bool falls = (first > cold) && (cold > EMA_R(0.0)) && ema_is_finite(first) && (config->cooling > EMA_R(0.0))
                       && (config->cooling < EMA_R(1.0));
    if (falls) {
        /* evaluations until the temperature is down */
        const ema_real fall = (ema_log(first) - ema_log(cold)) / -ema_log(config->cooling);
        warnings |= ema_warning_if(fall > (ema_real)config->evaluation_budget, (uint32_t)EMA_WARNING_HOT);
    }
    return warnings;
}

const char* ema_annealer_warning_text(uint32_t warning)
{
    const char* text;
    switch (warning) {
#define EMA_WARNING_CASE(name, bit, message)                                                                           \
    case (uint32_t)(name):                                                                                             \
        text = (message);                                                                                              \
        break;
        EMA_ANNEALER_WARNING_LIST(EMA_WARNING_CASE)
#undef EMA_WARNING_CASE
    default:
        text = "unknown warning";
        break;
    }
    return text;
}
