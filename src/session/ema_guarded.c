#include "ema_guarded_place.h"

#include <stddef.h>

#include "ema_math.h"
#include "ema_runs.h"

/* Temperature at a start that the table gave, over the objective at the healthy values: from there the search still
 * leaves a start that is wrong. */
#define EMA_START_WARMTH EMA_R(0.001)

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

ema_status_t ema_guarded_init(ema_guarded_t* guarded, const ema_session_config_t* config,
                              const ema_signatures_t* signatures)
{
    if ((guarded == NULL) || (config == NULL)) {
        return EMA_ERR_NULL;
    }
    ema_status_t status = EMA_OK;
    for (uint32_t i = 0; (signatures != NULL) && (i < config->identified_count) && (i < EMA_IDENTIFIED_MAX); ++i) {
        const ema_value_id_t id = config->identified[i].id;
        status = ((id == EMA_VALUE_ID(csj_Nm)) || (id == EMA_VALUE_ID(blk_mm))) ? status : EMA_ERR_RANGE;
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
        guarded->model_steps = 0U;
        guarded->evaluations = 0U;
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

/* Begins the run at the healthy values; without a table the session begins at once. */
static ema_status_t ema_guarded_begin(ema_guarded_t* guarded)
{
    ema_session_t* const session = &guarded->session;
    if (session->record.count < EMA_ROWS_MIN) {
        return EMA_ERR_SHORT;
    }
    if (guarded->signatures == NULL) {
        guarded->phase = EMA_GUARDED_SESSION;
        return EMA_OK;
    }
    const ema_status_t status =
        ema_onboard_start(&session->scoring, guarded->signatures, guarded->session.config->actuator, &session->record,
                          ema_runs_start_mm(session));
    if (status == EMA_OK) {
        ema_model_learned(&session->scoring.model, guarded->session.config->actuator);
        guarded->phase = EMA_GUARDED_STARTING;
    }
    return status;
}

/* The first run has ended. */
static void ema_guarded_started(ema_guarded_t* guarded)
{
    (void)ema_onboard_result(&guarded->session.scoring, &guarded->finding);
    if (guarded->finding.kind != EMA_FINDING_NONE) {
        ema_guarded_place(guarded);
    }
    guarded->phase = EMA_GUARDED_SESSION;
}

/* Steps of a slice that end with the run at the healthy values: what follows it hangs on its cost. */
static uint32_t ema_guarded_slice(const ema_guarded_t* guarded, uint32_t steps)
{
    const ema_session_t* const session = &guarded->session;
    uint32_t slice = steps;
    if ((guarded->finding.kind != EMA_FINDING_NONE) && !session->healthy_done) {
        const uint32_t total = session->record.count * (uint32_t)session->config->actuator->options.record_every_steps;
        const uint32_t made = (session->phase == EMA_PHASE_FEEDING) ? 0U : session->run.model.state.step;
        const uint32_t left = (made < total) ? (total - made) : 1U;
        slice = (steps < left) ? steps : left;
    }
    return slice;
}

/* The search begins as cool as the objective at the healthy values says, before the annealer has been told anything. */
static void ema_guarded_cool(ema_guarded_t* guarded)
{
    ema_annealer_t* const annealer = &guarded->session.annealer;
    if ((guarded->finding.kind != EMA_FINDING_NONE) && (annealer->info.evaluations == 0U)
        && guarded->session.healthy_done) {
        const ema_real warm =
            ema_max(EMA_START_WARMTH * guarded->session.healthy_cost, annealer->config.function_tolerance);
        annealer->temperature = ema_min(warm, annealer->config.initial_temperature);
    }
}

/* The session has ended: its result is kept, and the run at its estimate takes the place of its runs. */
static void ema_guarded_ended(ema_guarded_t* guarded)
{
    ema_session_t* const session = &guarded->session;
    (void)ema_session_result(session, &guarded->result);
    guarded->phase = EMA_GUARDED_DONE;
    if ((guarded->signatures != NULL) && (guarded->finding.kind != EMA_FINDING_NONE)) {
        for (uint32_t i = 0; i < guarded->session.config->identified_count; ++i) {
            (void)ema_actuator_set(&session->actuator, guarded->session.config->identified[i].id,
                                   guarded->result.identified[i].estimate);
        }
        guarded->finding = ema_no_finding;
        if (ema_onboard_start(&session->scoring, guarded->signatures, &session->actuator, &session->record,
                              session->start_mm)
            == EMA_OK) {
            ema_model_learned(&session->scoring.model, guarded->session.config->actuator);
            guarded->phase = EMA_GUARDED_LOOKING;
        }
    }
}

/* Makes at most `steps` model steps beside the table. */
static void ema_guarded_score(ema_guarded_t* guarded, uint32_t steps)
{
    ema_onboard_t* const scoring = &guarded->session.scoring;
    /* a copy reads its own record */
    scoring->record = &guarded->session.record;
    const uint32_t made = ema_onboard_run(scoring, steps);
    guarded->model_steps += made;
    if (ema_onboard_done(scoring)) {
        ++guarded->evaluations;
        if (guarded->phase == EMA_GUARDED_STARTING) {
            ema_guarded_started(guarded);
        } else {
            (void)ema_onboard_result(scoring, &guarded->finding);
            guarded->phase = EMA_GUARDED_DONE;
        }
    }
}

ema_status_t ema_guarded_run(ema_guarded_t* guarded, uint32_t steps)
{
    if (guarded == NULL) {
        return EMA_ERR_NULL;
    }
    ema_status_t status = (guarded->phase == EMA_GUARDED_FEEDING) ? ema_guarded_begin(guarded) : EMA_OK;
    if (status == EMA_OK) {
        if ((guarded->phase == EMA_GUARDED_STARTING) || (guarded->phase == EMA_GUARDED_LOOKING)) {
            ema_guarded_score(guarded, steps);
        } else if (guarded->phase == EMA_GUARDED_SESSION) {
            status = ema_session_run(&guarded->session, ema_guarded_slice(guarded, steps));
            ema_guarded_cool(guarded);
            if ((status == EMA_OK) && (ema_session_phase(&guarded->session) == EMA_PHASE_DONE)) {
                ema_guarded_ended(guarded);
            }
        } else {
            /* done */
        }
    }
    return status;
}

ema_guarded_phase_t ema_guarded_phase(const ema_guarded_t* guarded)
{
    return guarded->phase;
}

ema_status_t ema_guarded_result(const ema_guarded_t* guarded, ema_result_t* result, ema_finding_t* finding)
{
    if ((guarded == NULL) || (result == NULL)) {
        return EMA_ERR_NULL;
    }
    const bool ended = (guarded->phase == EMA_GUARDED_LOOKING) || (guarded->phase == EMA_GUARDED_DONE);
    ema_status_t status = EMA_OK;
    if (ended) {
        *result = guarded->result;
    } else {
        status = ema_session_result(&guarded->session, result);
    }
    if (status == EMA_OK) {
        result->evaluations += guarded->evaluations;
        result->model_steps += guarded->model_steps;
    }
    if ((status == EMA_OK) && (guarded->signatures != NULL) && ended) {
        const ema_finding_kind_t kind = guarded->finding.kind;
        if (guarded->phase == EMA_GUARDED_LOOKING) {
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
