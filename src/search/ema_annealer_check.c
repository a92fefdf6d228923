/* Apart from ema_annealer.c so that firmware which does without it links none of it. */
#include "ema/ema_annealer_check.h"

#include "ema_math.h"

#include <stddef.h>

/* The limits of the rules, chosen on a design of settings and counted on another: docs/ROBUSTNESS.md. */

/* Evaluations that one dimension needs, and of these the ones in which the temperature falls to the resolution. */
#define EMA_FEWEST_PER_DIMENSION 50U
#define EMA_FALL_PER_DIMENSION EMA_R(15.0)

/* Times the resolution: the last temperature and the tolerance at the most, the first temperature at the least. */
#define EMA_COARSE EMA_R(10.0)
#define EMA_FROZEN EMA_R(1.0e-3)

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
    const ema_real fine = known ? resolution : tolerance;
    warnings |= ema_warning_if(known && (tolerance > (EMA_COARSE * resolution)), (uint32_t)EMA_WARNING_TOLERANCE);
    const bool cold = (first <= tolerance) || (known && (first < (EMA_FROZEN * resolution)));
    warnings |= ema_warning_if(cold, (uint32_t)EMA_WARNING_COLD);
    const bool falls = (first > fine) && (fine > EMA_R(0.0)) && (config->cooling > EMA_R(0.0))
                       && (config->cooling < EMA_R(1.0)) && ema_is_finite(first);
    if (falls) {
        /* in evaluations: until the temperature is no more than the resolution, and than ten times that */
        const ema_real rate = -ema_log(config->cooling);
        const ema_real fall = (ema_log(first) - ema_log(fine)) / rate;
        const ema_real coarse = fall - (ema_log(EMA_COARSE) / rate);
        warnings |= ema_warning_if(fall < (EMA_FALL_PER_DIMENSION * (ema_real)config->dimension),
                                   (uint32_t)EMA_WARNING_QUENCHED);
        warnings |= ema_warning_if(coarse > (ema_real)config->evaluation_budget, (uint32_t)EMA_WARNING_HOT);
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
