/* Apart from ema_runs.c so that the lists of values take no stack from the search. */
#include "ema_assess.h"

#include "ema_bounds.h"
#include "ema_copy.h"
#include "ema_math.h"
#include "ema_runs.h"

/* Step of the sensitivities, as a share of the healthy value: large against rounding, small against the parameter. */
#define EMA_DELTA_SHARE EMA_R(0.01)

void ema_assess_start(ema_session_t* session)
{
    const ema_session_config_t* const config = session->config;
    ema_runs_move(session, session->annealer.best.x);
    ema_value_id_t ids[EMA_IDENTIFIED_MAX];
    ema_real delta[EMA_IDENTIFIED_MAX];
    ema_clear(ids, sizeof ids);
    ema_clear(delta, sizeof delta);
    for (uint32_t i = 0; i < config->identified_count; ++i) {
        const ema_identified_t* const identified = &config->identified[i];
        const ema_real value = ema_identified_at(identified, session->annealer.best.x[i]);
        ids[i] = identified->id;
        delta[i] = EMA_DELTA_SHARE * ema_abs(ema_value_of(config->actuator, identified->id));
        if ((value + delta[i]) > identified->upper) {
            delta[i] = -delta[i];
        }
    }
    const ema_status_t status =
        ema_sensitivity_start(&session->sensitivity, &session->actuator, &session->record, config->weight, ids, delta,
                              config->identified_count, session->start_mm);
    session->assessed = status == EMA_OK;
    if (session->assessed) {
        ema_sensitivity_learned(&session->sensitivity, config->actuator);
    }
    session->phase = session->assessed ? EMA_PHASE_ASSESSING : EMA_PHASE_DONE;
}
