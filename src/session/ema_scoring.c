/* Apart from ema_guarded.c so that the start takes no stack from the runs. */
#include "session/ema_scoring.h"

#include "base/ema_bounds.h"
#include "base/ema_copy.h"
#include "base/ema_math.h"
#include "ident/ema_onboard_begin.h"
#include "session/ema_session_search.h"

/* Temperature at a start that was placed, over the objective at the healthy values: from there the search still leaves
 * a start that is wrong. */
#define EMA_START_WARMTH EMA_R(0.001)

/* The table is linear in CSJ and BLK: farther than to half or twice the healthy value its shifts are not followed. */
#define EMA_START_LOWER EMA_R(0.5)
#define EMA_START_UPPER EMA_R(2.0)

ema_status_t ema_scoring_start(ema_session_t* session, const ema_signatures_t* table)
{
    if (session->record.count < EMA_ROWS_MIN) {
        return EMA_ERR_SHORT;
    }
    if (session->phase == EMA_PHASE_FEEDING) {
        ema_copy(&session->actuator, session->config->actuator, sizeof session->actuator);
    } else if (session->phase == EMA_PHASE_DONE) {
        ema_session_search_move(session, session->annealer.best.x);
    } else {
        return EMA_ERR_ORDER;
    }
    /* the table's checksum is of the actuator as it was exported: the run's own may have today's grease and winding */
    ema_status_t status = ema_onboard_check(table, session->config->actuator, &session->record);
    if (status == EMA_OK) {
        status = ema_onboard_begin(&session->scoring, table, &session->actuator, &session->record,
                                   ema_session_search_start_mm(session));
    }
    if (status == EMA_OK) {
        ema_model_learned(&session->scoring.model, session->config->actuator);
    }
    return status;
}

uint32_t ema_scoring_run(ema_session_t* session, uint32_t steps)
{
    /* a copy reads its own record */
    session->scoring.cursor.record = &session->record;
    return ema_onboard_run(&session->scoring, steps);
}

bool ema_scoring_ended(const ema_session_t* session, ema_finding_t* finding)
{
    return ema_onboard_result(&session->scoring, finding) == EMA_OK;
}

void ema_session_place_start(ema_session_t* session, const ema_real value[EMA_IDENTIFIED_MAX])
{
    ema_real start[EMA_IDENTIFIED_MAX];
    for (uint32_t i = 0; i < session->config->identified_count; ++i) {
        const ema_identified_t* const identified = &session->config->identified[i];
        start[i] =
            ema_clamp((value[i] - identified->lower) / (identified->upper - identified->lower), EMA_R(0.0), EMA_R(1.0));
    }
    (void)ema_annealer_restart(&session->annealer, start, session->annealer.config.initial_temperature);
    session->starts_healthy = false;
}

void ema_scoring_place(ema_session_t* session, const ema_finding_t* finding)
{
    const ema_session_config_t* const config = session->config;
    const ema_signatures_t* const table = session->scoring.scores.table;
    ema_real start[EMA_IDENTIFIED_MAX] = {0};
    for (uint32_t i = 0; i < config->identified_count; ++i) {
        const ema_real value = ema_value_of(config->actuator, config->identified[i].id);
        start[i] = value;
        for (uint32_t k = 0; k < table->faults; ++k) {
            if (table->fault[k].id == config->identified[i].id) {
                start[i] = ema_clamp(value + finding->moved[k], EMA_START_LOWER * value, EMA_START_UPPER * value);
            }
        }
    }
    ema_session_place_start(session, start);
}

ema_status_t ema_session_run_placed(ema_session_t* session, uint32_t steps)
{
    uint32_t slice = steps;
    if (!session->healthy_done) {
        const uint32_t total = session->record.count * (uint32_t)session->config->actuator->options.record_every_steps;
        const uint32_t made = (session->phase == EMA_PHASE_FEEDING) ? 0U : session->run.model.state.step;
        const uint32_t left = (made < total) ? (total - made) : 1U;
        slice = (steps < left) ? steps : left;
    }
    const ema_status_t status = ema_session_run(session, slice);
    ema_annealer_t* const annealer = &session->annealer;
    if (session->healthy_done && (annealer->info.evaluations == 0U)) {
        const ema_annealer_config_t* const config = &annealer->config;
        const ema_real warm = ema_max(EMA_START_WARMTH * session->healthy_cost, config->function_tolerance);
        (void)ema_annealer_restart(annealer, config->start, ema_min(warm, config->initial_temperature));
    }
    return status;
}
