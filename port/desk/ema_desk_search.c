/* The module's annealer for costs of the caller's own, so that it can be held against other searches on the same
 * objective; and its check of a search's settings. */
#include "ema_desk.h"

#include "ema/ema.h"

_Static_assert(EMA_DESK_DIMENSION_MAX == EMA_ANNEALER_DIMENSION_MAX, "the desk's arrays hold the annealer's");

int32_t ema_desk_anneal(const ema_desk_annealer_t* settings, ema_desk_cost_t cost, void* context,
                        ema_desk_annealed_t* annealed)
{
    if ((settings == NULL) || (cost == NULL) || (annealed == NULL)) {
        return (int32_t)EMA_ERR_NULL;
    }
    if ((settings->dimension < 1) || (settings->dimension > EMA_DESK_DIMENSION_MAX) || (settings->stall_evaluations < 1)
        || (settings->reanneal_interval < 0) || (settings->evaluation_budget < 1)) {
        return (int32_t)EMA_ERR_RANGE;
    }
    ema_annealer_config_t config = {.dimension = (uint32_t)settings->dimension,
                                    .first_step = (ema_real)settings->first_step,
                                    .initial_temperature = (ema_real)settings->initial_temperature,
                                    .cooling = (ema_real)settings->cooling,
                                    .function_tolerance = (ema_real)settings->function_tolerance,
                                    .stall_evaluations = (uint32_t)settings->stall_evaluations,
                                    .reanneal_interval = (uint32_t)settings->reanneal_interval,
                                    .evaluation_budget = (uint32_t)settings->evaluation_budget,
                                    .seed = (uint64_t)settings->seed};
    for (uint32_t i = 0; i < config.dimension; ++i) {
        config.start[i] = (ema_real)settings->start[i];
    }
    ema_annealer_t annealer;
    const ema_status_t status = ema_annealer_init(&annealer, &config);
    bool stopped = status != EMA_OK;
    while (!stopped && (ema_annealer_outcome(&annealer) == EMA_OUTCOME_ACTIVE)) {
        double x[EMA_DESK_DIMENSION_MAX];
        for (uint32_t i = 0; i < config.dimension; ++i) {
            x[i] = (double)ema_annealer_candidate(&annealer)[i];
        }
        double found = 0.0;
        stopped = cost(x, (double)ema_annealer_limit(&annealer), &found, context) != 0;
        if (!stopped) {
            ema_annealer_tell(&annealer, (ema_real)found);
        }
    }
    if (status == EMA_OK) {
        const ema_desk_annealed_t fresh = {.cost = (double)annealer.best.cost,
                                           .evaluations = (int32_t)annealer.info.evaluations,
                                           .outcome = (int32_t)ema_annealer_outcome(&annealer)};
        *annealed = fresh;
        for (uint32_t i = 0; i < config.dimension; ++i) {
            annealed->x[i] = (double)annealer.best.x[i];
        }
    }
    return (int32_t)status;
}

const char* ema_desk_warning_text(int32_t index, int32_t* bit)
{
    static const int32_t bits[] = {
#define EMA_WARNING_BIT(name, value, text) (int32_t)(name),
        EMA_ANNEALER_WARNING_LIST(EMA_WARNING_BIT)
#undef EMA_WARNING_BIT
    };
    if ((bit == NULL) || (index < 0) || (index >= (int32_t)(sizeof bits / sizeof bits[0]))) {
        return NULL;
    }
    *bit = bits[index];
    return ema_annealer_warning_text((uint32_t)bits[index]);
}
