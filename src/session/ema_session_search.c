#include "session/ema_session_search.h"

#include "base/ema_bounds.h"
#include "base/ema_compiler.h"
#include "base/ema_copy.h"
#include "base/ema_math.h"
#include "ident/ema_record_row.h"
#include "ident/ema_run_begin.h"

ema_real ema_identified_at(const ema_identified_t* identified, ema_real x)
{
    return identified->lower + (x * (identified->upper - identified->lower));
}

void ema_session_search_move(ema_session_t* session, const ema_real* x)
{
    for (uint32_t i = 0; i < session->config->identified_count; ++i) {
        const ema_identified_t* const identified = &session->config->identified[i];
        (void)ema_actuator_set(&session->actuator, identified->id, ema_identified_at(identified, x[i]));
    }
}

ema_real ema_session_search_start_mm(const ema_session_t* session)
{
    return ema_start_mm(&session->config->actuator->params, &session->record);
}

/* Starts the next model run of the search: first at the healthy values, then at the annealer's candidates. */
EMA_NOINLINE ema_status_t ema_session_search_begin(ema_session_t* session)
{
    const ema_session_config_t* const config = session->config;
    if (session->healthy_done) {
        ema_session_search_move(session, ema_annealer_candidate(&session->annealer));
    } else {
        ema_copy(&session->actuator, config->actuator, sizeof session->actuator);
    }
    const ema_real limit = (config->abandon && session->healthy_done)
                               ? ema_min(ema_annealer_limit(&session->annealer), EMA_COST_MAX)
                               : EMA_COST_MAX;
    ema_status_t status = ema_objective_start(&session->run, &session->actuator, &session->record, config->weight,
                                              ema_session_search_start_mm(session), limit);
    /* tables are read where the configuration lies, so that a copy of the session does not depend on its original */
    ema_model_learned(&session->run.model, config->actuator);
    if ((status != EMA_OK) && session->healthy_done) {
        /* bounds can hold values of which no model can be made, too stiff ones for instance: they cost the most, and
         * the search goes on */
        session->run.state = EMA_OBJECTIVE_DIVERGED;
        session->run.sum = EMA_COST_MAX;
        status = EMA_OK;
    }
    return status;
}

ema_status_t ema_session_search_next(ema_session_t* session)
{
    const ema_real cost = ema_objective_value(&session->run);
    ++session->evaluations;
    if (!session->healthy_done) {
        session->healthy_done = true;
        session->healthy_cost = cost;
        if (session->starts_healthy) {
            ema_annealer_tell(&session->annealer, cost);
        }
    } else {
        ema_annealer_tell(&session->annealer, cost);
    }
    ema_status_t status = EMA_OK;
    if (ema_annealer_outcome(&session->annealer) == EMA_OUTCOME_ACTIVE) {
        status = ema_session_search_begin(session);
    }
    return status;
}

/* Step of the sensitivities, as a share of the healthy value: large against rounding, small against the parameter. */
#define EMA_DELTA_SHARE EMA_R(0.01)

/* What has come of the part of the start so far: without a model beside the estimate the session ends. */
static void ema_assess_went(ema_session_t* session, ema_status_t status)
{
    session->assessed = status == EMA_OK;
    session->phase = session->assessed ? EMA_PHASE_ASSESSING : EMA_PHASE_DONE;
}

void ema_assess_start(ema_session_t* session)
{
    const ema_session_config_t* const config = session->config;
    ema_session_search_move(session, session->annealer.best.x);
    ema_assess_went(session, ema_sensitivity_begin(&session->sensitivity, &session->actuator, &session->record,
                                                   config->weight, config->identified_count));
}

void ema_assess_model(ema_session_t* session)
{
    const ema_session_config_t* const config = session->config;
    ema_sensitivity_t* const sensitivity = &session->sensitivity;
    const uint32_t made = sensitivity->prepared;
    if (made == 0U) {
        ema_assess_went(session,
                        ema_sensitivity_model(sensitivity, &session->actuator, ema_session_search_start_mm(session)));
    } else {
        const ema_identified_t* const identified = &config->identified[made - 1U];
        const ema_real value = ema_value_of(&session->actuator, identified->id);
        ema_real delta = EMA_DELTA_SHARE * ema_abs(ema_value_of(config->actuator, identified->id));
        if ((value + delta) > identified->upper) {
            delta = -delta;
        }
        ema_assess_went(session, ema_sensitivity_moved(sensitivity, &session->actuator, identified->id, delta,
                                                       ema_session_search_start_mm(session)));
    }
    if (session->assessed && (sensitivity->prepared > sensitivity->parameters)) {
        ema_sensitivity_learned(sensitivity, config->actuator);
    }
}
