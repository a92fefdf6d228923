#include "ema/ema_guarded.h"

#include <stddef.h>

#include "base/ema_bounds.h"
#include "base/ema_compiler.h"
#include "base/ema_copy.h"
#include "base/ema_math.h"
#include "ident/ema_run_begin.h"
#include "session/ema_scoring.h"
#include "session/ema_session_search.h"

static const ema_finding_t ema_no_finding = {
    .kind = EMA_FINDING_NONE, .effect = EMA_EFFECT_COUNT, .runner_up = EMA_EFFECT_COUNT};

/* The table is refused before anything has changed. */
static ema_status_t ema_guarded_table_check(const ema_session_config_t* config, const ema_signatures_t* signatures)
{
    ema_record_t record;
    ema_status_t status = ema_actuator_check(config->actuator, NULL);
    if (status == EMA_OK) {
        status = ema_record_init(&record, &config->record);
    }
    return (status == EMA_OK) ? ema_onboard_check(signatures, config->actuator, &record) : status;
}

/* CSJ and BLK, and what differs from day to day: of everything else the table is not freed. */
static bool ema_guarded_searches(ema_value_id_t id)
{
    return (id == EMA_VALUE_ID(csj_Nm)) || (id == EMA_VALUE_ID(blk_mm)) || (id == EMA_VALUE_ID(viscous_Nm_s_per_rad))
           || (id == EMA_VALUE_ID(resistance_ohm));
}

ema_status_t ema_guarded_init(ema_guarded_t* guarded, const ema_session_config_t* config,
                              const ema_signatures_t* signatures)
{
    if ((guarded == NULL) || (config == NULL)) {
        return EMA_ERR_NULL;
    }
    ema_status_t status = EMA_OK;
    for (uint32_t i = 0; (signatures != NULL) && (i < config->identified_count) && (i < EMA_IDENTIFIED_MAX); ++i) {
        status = ema_guarded_searches(config->identified[i].id) ? status : EMA_ERR_RANGE;
    }
    if ((status == EMA_OK) && (signatures != NULL)) {
        status = ema_guarded_table_check(config, signatures);
    }
    if (status == EMA_OK) {
        status = ema_session_init(&guarded->session, config);
    }
    if (status == EMA_OK) {
        guarded->signatures = signatures;
        guarded->finding = ema_no_finding;
        guarded->phase = EMA_GUARDED_FEEDING;
    }
    return status;
}

ema_status_t ema_guarded_feed(ema_guarded_t* guarded, const ema_sample_t* sample)
{
    if (guarded == NULL) {
        return EMA_ERR_NULL;
    }
    return (guarded->phase == EMA_GUARDED_FEEDING) ? ema_session_feed(&guarded->session, sample) : EMA_ERR_ORDER;
}

/* Whether the table has said something, which has placed the start of the search. */
static bool ema_guarded_placed(const ema_guarded_t* guarded)
{
    return (guarded->signatures != NULL) && (guarded->finding.kind != EMA_FINDING_NONE);
}

/* The session has ended: its result is kept, and the run at its estimate takes the place of its runs. */
static void ema_guarded_ended(ema_guarded_t* guarded)
{
    (void)ema_session_result(&guarded->session, &guarded->result);
    guarded->phase = EMA_GUARDED_DONE;
    if (ema_guarded_placed(guarded)) {
        guarded->finding = ema_no_finding;
        if (ema_scoring_start(&guarded->session, guarded->signatures) == EMA_OK) {
            guarded->phase = EMA_PHASE_SCREENING;
        }
    }
}

/* Makes at most `steps` model steps beside the table: before the session, or after its result is kept. */
static void ema_guarded_score(ema_guarded_t* guarded, uint32_t steps)
{
    const bool looking = guarded->phase == EMA_PHASE_SCREENING;
    uint64_t* const model_steps = looking ? &guarded->result.model_steps : &guarded->session.model_steps;
    uint32_t* const evaluations = looking ? &guarded->result.evaluations : &guarded->session.evaluations;
    *model_steps += ema_scoring_run(&guarded->session, steps);
    if (ema_scoring_ended(&guarded->session, &guarded->finding)) {
        ++*evaluations;
        if (looking) {
            guarded->phase = EMA_GUARDED_DONE;
        } else {
            if (guarded->finding.kind != EMA_FINDING_NONE) {
                ema_scoring_place(&guarded->session, &guarded->finding);
            }
            guarded->phase = EMA_GUARDED_SESSION;
        }
    }
}

/* After a slice of the session's own runs. */
static void ema_guarded_searched(ema_guarded_t* guarded, ema_status_t status)
{
    if (status == EMA_OK) {
        guarded->phase = EMA_GUARDED_SESSION;
        if (ema_session_phase(&guarded->session) == EMA_PHASE_DONE) {
            ema_guarded_ended(guarded);
        }
    }
}

ema_status_t ema_guarded_run(ema_guarded_t* guarded, uint32_t steps)
{
    if (guarded == NULL) {
        return EMA_ERR_NULL;
    }
    ema_status_t status = (steps == 0U) ? EMA_ERR_RANGE : EMA_OK;
    uint32_t left = steps;
    if ((status == EMA_OK) && (guarded->phase == EMA_GUARDED_FEEDING) && (guarded->signatures != NULL)) {
        status = ema_scoring_start(&guarded->session, guarded->signatures);
        guarded->phase = (status == EMA_OK) ? EMA_GUARDED_STARTING : EMA_GUARDED_FEEDING;
        left = (steps > EMA_MODEL_WORK) ? (steps - EMA_MODEL_WORK) : 1U;
    }
    /* the start is placed for as many values as there were at init: another number would be written past the end */
    if ((status == EMA_OK) && (guarded->phase == EMA_GUARDED_STARTING)
        && (guarded->session.config->identified_count != guarded->session.annealer.config.dimension)) {
        status = EMA_ERR_RANGE;
    }
    if (status == EMA_OK) {
        if ((guarded->phase == EMA_GUARDED_STARTING) || (guarded->phase == EMA_PHASE_SCREENING)) {
            ema_guarded_score(guarded, left);
        } else if (guarded->phase != EMA_GUARDED_DONE) {
            /* the session's own runs, from here, where the stack is lowest */
            status = ema_session_run(&guarded->session, steps);
            ema_guarded_searched(guarded, status);
        } else {
            /* done */
        }
    }
    return status;
}

ema_guarded_phase_t ema_guarded_phase(const ema_guarded_t* guarded)
{
    return (guarded == NULL) ? EMA_GUARDED_FEEDING : guarded->phase;
}

ema_status_t ema_guarded_result(const ema_guarded_t* guarded, ema_result_t* result, ema_finding_t* finding)
{
    if ((guarded == NULL) || (result == NULL)) {
        return EMA_ERR_NULL;
    }
    const bool ended = (guarded->phase == EMA_PHASE_SCREENING) || (guarded->phase == EMA_GUARDED_DONE);
    ema_status_t status = EMA_OK;
    if (ended) {
        ema_copy(result, &guarded->result, sizeof *result);
    } else {
        status = ema_session_result(&guarded->session, result);
    }
    if ((status == EMA_OK) && (guarded->signatures != NULL) && ended) {
        const ema_finding_kind_t kind = guarded->finding.kind;
        if (guarded->phase == EMA_PHASE_SCREENING) {
            result->reasons |= (uint32_t)EMA_REASON_NOT_FINISHED;
        } else if (kind == EMA_FINDING_NONE) {
            result->reasons |= (uint32_t)EMA_REASON_OTHER_COMMAND;
        } else if (kind != EMA_FINDING_ADEQUATE) {
            result->reasons |= (uint32_t)EMA_REASON_EFFECT;
            result->adequate = false;
        } else {
            /* nothing is missing */
        }
        result->verdict = (result->reasons != 0U) ? EMA_VERDICT_UNDECIDED : result->verdict;
    }
    if ((status == EMA_OK) && (finding != NULL)) {
        *finding = (guarded->phase == EMA_GUARDED_DONE) ? guarded->finding : ema_no_finding;
    }
    return status;
}

ema_status_t ema_guarded_adopt(ema_guarded_t* guarded, uint32_t rows)
{
    if (guarded == NULL) {
        return EMA_ERR_NULL;
    }
    return (guarded->phase == EMA_GUARDED_FEEDING) ? ema_session_adopt(&guarded->session, rows) : EMA_ERR_ORDER;
}

ema_status_t ema_guarded_gap(ema_guarded_t* guarded)
{
    if (guarded == NULL) {
        return EMA_ERR_NULL;
    }
    return (guarded->phase == EMA_GUARDED_FEEDING) ? ema_session_gap(&guarded->session) : EMA_ERR_ORDER;
}

/* The table is linear in CSJ and BLK: farther than to half or twice the healthy value its shifts are not followed. */
#define EMA_START_LOWER EMA_R(0.5)
#define EMA_START_UPPER EMA_R(2.0)

EMA_NOINLINE ema_status_t ema_scoring_start(ema_session_t* session, const ema_signatures_t* table)
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

EMA_NOINLINE uint32_t ema_scoring_run(ema_session_t* session, uint32_t steps)
{
    /* a copy reads its own record */
    session->scoring.cursor.record = &session->record;
    return ema_onboard_run(&session->scoring, steps);
}

EMA_NOINLINE bool ema_scoring_ended(const ema_session_t* session, ema_finding_t* finding)
{
    return ema_onboard_result(&session->scoring, finding) == EMA_OK;
}

EMA_NOINLINE void ema_session_place_start(ema_session_t* session, const ema_real value[EMA_IDENTIFIED_MAX])
{
    ema_real start[EMA_IDENTIFIED_MAX];
    for (uint32_t i = 0; i < session->config->identified_count; ++i) {
        const ema_identified_t* const identified = &session->config->identified[i];
        start[i] =
            ema_clamp((value[i] - identified->lower) / (identified->upper - identified->lower), EMA_R(0.0), EMA_R(1.0));
    }
    (void)ema_annealer_restart(&session->annealer, start, session->annealer.config.initial_temperature);
    session->starts_healthy = false;
    session->starts_cool = true;
}

EMA_NOINLINE void ema_scoring_place(ema_session_t* session, const ema_finding_t* finding)
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
