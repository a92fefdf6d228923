#include "session/ema_session_search.h"

#include "base/ema_bounds.h"
#include "base/ema_compiler.h"
#include "base/ema_copy.h"
#include "base/ema_math.h"
#include "ident/ema_record_row.h"
#include "ident/ema_residual.h"
#include "ident/ema_run_begin.h"
#include "session/ema_verdict.h"

/* Temperature at a start that is known to be near, over the objective at the healthy values: from there the search
 * still leaves a start that is wrong. */
#define EMA_START_WARMTH EMA_R(0.001)

/* Damping of the least squares: sensitivities that are nearly alike make no wild step. */
#define EMA_DESCENT_DAMPING EMA_R(1.0e-4)

/* A step by which the cost did not fall is shortened to this share, which keeps the second share of its promise; so
 * many such steps in a row are the most. */
#define EMA_DESCENT_SHORTER EMA_R(0.25)
#define EMA_DESCENT_SHORTER_KEEPS EMA_R(0.4375)
#define EMA_DESCENT_FAILED_MAX 3U

/* Promised fall of the cost, over that of one standard error, below which a descent has ended, as it has below the
 * tolerance of the search; and below which it ends where a step fails, by rounding. */
#define EMA_DESCENT_FALL_LEAST EMA_R(1.0e-2)
#define EMA_DESCENT_FALL_ROUNDED EMA_R(2.0)

/* How far from the end of the first descent the second starts, as a share of the healthy value. */
#define EMA_DESCENT_AWAY EMA_R(0.5)

/* Two descents end alike when their costs differ by no more than this share. */
#define EMA_DESCENT_ALIKE EMA_R(1.0e-4)

/* An estimate this close to a bound, as a share of the search range, lies on it. */
#define EMA_BOUND_SHARE EMA_R(5.0e-4)

/* Step of the sensitivities, as a share of the healthy value: large against rounding, small against the parameter. */
#define EMA_DELTA_SHARE EMA_R(0.01)

/* Plain steps that a decision with so many values counts as. Measured on the target: docs/BUDGETS.md. */
#define EMA_DECISION_WORK(count) (20U + (3U * (count) * (count) * (count)))

bool ema_at_bound(ema_real x)
{
    return (x < EMA_BOUND_SHARE) || (x > (EMA_R(1.0) - EMA_BOUND_SHARE));
}

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

/* The run of the session's actuator is next, and those beside it with `count` values moved; given up above `limit`. For
 * a configuration that was changed since the session began against its contract, the session ends. */
static ema_status_t ema_runs_begin(ema_session_t* session, uint32_t count, ema_real limit)
{
    const ema_status_t status = ema_sensitivity_begin(&session->sensitivity, &session->actuator, &session->record,
                                                      session->config->weight, count);
    if (status != EMA_OK) {
        session->assessed = false;
        session->phase = EMA_PHASE_DONE;
    } else if (session->config->abandon) {
        session->sensitivity.limit = ema_min(limit, EMA_COST_MAX);
    } else {
        /* every run to its end */
    }
    return status;
}

/* Makes the next of their models. */
static ema_status_t ema_runs_model(ema_session_t* session)
{
    const ema_session_config_t* const config = session->config;
    ema_sensitivity_t* const sensitivity = &session->sensitivity;
    const ema_real start_mm = ema_session_search_start_mm(session);
    const uint32_t made = sensitivity->prepared;
    ema_status_t status;
    if (made == 0U) {
        status = ema_sensitivity_model(sensitivity, &session->actuator, start_mm);
    } else {
        const ema_identified_t* const identified = &config->identified[made - 1U];
        const ema_real value = ema_value_of(&session->actuator, identified->id);
        ema_real delta = EMA_DELTA_SHARE * ema_abs(ema_value_of(config->actuator, identified->id));
        if ((value + delta) > identified->upper) {
            delta = -delta;
        }
        status = ema_sensitivity_moved(sensitivity, &session->actuator, identified->id, delta, start_mm);
    }
    if ((status == EMA_OK) && (made == sensitivity->parameters)) {
        /* tables are read where the configuration lies, so that a copy of the session does not depend on its original
         */
        ema_sensitivity_learned(sensitivity, config->actuator);
    }
    return status;
}

/* The annealer's candidate is next. */
static void ema_search_try(ema_session_t* session)
{
    ema_session_search_move(session, ema_annealer_candidate(&session->annealer));
    (void)ema_runs_begin(session, 0U, ema_annealer_limit(&session->annealer));
}

/* The annealer's start is known to be near. */
static void ema_search_cool(ema_session_t* session)
{
    ema_annealer_t* const annealer = &session->annealer;
    const ema_real warm = ema_max(EMA_START_WARMTH * session->healthy_cost, annealer->config.function_tolerance);
    annealer->temperature = ema_min(warm, annealer->config.initial_temperature);
}

/* A model run of the annealer has ended: its cost decides. */
static EMA_NOINLINE void ema_search_decide(ema_session_t* session, ema_real cost)
{
    ema_annealer_t* const annealer = &session->annealer;
    ema_annealer_tell(annealer, cost);
    if (ema_annealer_outcome(annealer) == EMA_OUTCOME_ACTIVE) {
        ema_search_try(session);
    } else {
        session->phase = EMA_PHASE_ASSESSING;
        session->assessed = true;
        ema_session_search_move(session, annealer->best.x);
        (void)ema_runs_begin(session, session->config->identified_count, EMA_COST_MAX);
    }
}

/* What the annealer keeps of its points is the least squares' as long as these search: the point that is tried is its
 * candidate, the point of the descent its present one.
 *
 * The annealer goes on from the best point, with the evaluations that are left. */
static void ema_descent_leave(ema_session_t* session)
{
    ema_annealer_t* const annealer = &session->annealer;
    const uint32_t budget = annealer->config.evaluation_budget;
    session->stage = EMA_STAGE_ANNEALER;
    annealer->config.evaluation_budget = (budget > session->evaluations) ? (budget - session->evaluations) : 1U;
    ema_copy(&annealer->candidate, &annealer->best, sizeof annealer->candidate);
    annealer->current.cost = annealer->limit;
    ema_search_cool(session);
    ema_search_try(session);
}

/* Tries the candidate, or leaves it to the annealer where the evaluations do not suffice. */
static void ema_descent_try(ema_session_t* session)
{
    ema_annealer_t* const annealer = &session->annealer;
    const uint32_t count = session->config->identified_count;
    if ((session->evaluations + 1U + count) >= annealer->config.evaluation_budget) {
        ema_descent_leave(session);
    } else {
        ema_session_search_move(session, annealer->candidate.x);
        (void)ema_runs_begin(session, count, annealer->current.cost);
    }
}

/* A descent has ended at its present point: that is the answer, or it is doubtful, and another descent from another
 * place has to end there too. */
static void ema_descent_ended(ema_session_t* session)
{
    const ema_session_config_t* const config = session->config;
    ema_annealer_t* const annealer = &session->annealer;
    const ema_sensitivity_t* const sensitivity = &session->sensitivity;
    const ema_real cost = annealer->current.cost;
    const ema_real apart = ema_abs(cost - session->ended_cost);
    bool settles = ema_residual_adequate(
        &config->actuator->params, ema_sqrt(sensitivity->residual.position_square / (ema_real)sensitivity->cursor.row),
        ema_residual_correlation(&sensitivity->residual));
    for (uint32_t i = 0; i < config->identified_count; ++i) {
        settles = settles && !ema_at_bound(annealer->current.x[i]);
    }
    if (settles || (session->second_start && (apart <= (EMA_DESCENT_ALIKE * session->ended_cost)))) {
        /* the sums are those of this point */
        ema_copy(&annealer->best, &annealer->current, sizeof annealer->best);
        annealer->outcome = EMA_OUTCOME_TOLERANCE;
        session->assessed = true;
        session->phase = EMA_PHASE_DONE;
    } else if (session->second_start) {
        ema_descent_leave(session);
    } else {
        session->second_start = true;
        session->settled = false;
        session->ended_cost = cost;
        for (uint32_t i = 0; i < config->identified_count; ++i) {
            const ema_identified_t* const identified = &config->identified[i];
            const ema_real away = (EMA_DESCENT_AWAY * ema_abs(ema_value_of(config->actuator, identified->id)))
                                  / (identified->upper - identified->lower);
            const ema_real x = annealer->current.x[i];
            annealer->candidate.x[i] =
                ema_clamp(((x + away) <= EMA_R(1.0)) ? (x + away) : (x - away), EMA_R(0.0), EMA_R(1.0));
        }
        annealer->current.cost = annealer->limit;
        ema_descent_try(session);
    }
}

/* The next step from the present point, whose sums the runs have left. */
static void ema_descent_propose(ema_session_t* session)
{
    const ema_session_config_t* const config = session->config;
    ema_annealer_t* const annealer = &session->annealer;
    const ema_sensitivity_t* const sensitivity = &session->sensitivity;
    const uint32_t count = config->identified_count;
    const ema_real freedom = ((ema_real)sensitivity->cursor.row * (ema_real)sensitivity->channels) - (ema_real)count;
    const ema_real variance = annealer->current.cost / freedom;
    ema_real step[EMA_IDENTIFIED_MAX];
    uint32_t held = 0U;
    for (uint32_t i = 0; i < count; ++i) {
        const ema_real x = annealer->current.x[i];
        const ema_real rises = sensitivity->gradient[i];
        const bool out = ((x <= EMA_R(0.0)) && (rises < EMA_R(0.0))) || ((x >= EMA_R(1.0)) && (rises > EMA_R(0.0)));
        held |= out ? ((uint32_t)1U << i) : 0U;
    }
    const ema_real fall = ema_sensitivity_step(sensitivity, EMA_DESCENT_DAMPING, held, step) * sensitivity->period_s;
    if (fall < EMA_R(0.0)) {
        ema_descent_leave(session);
    } else if (session->settled
               || (fall <= ema_max(EMA_DESCENT_FALL_LEAST * variance, annealer->config.function_tolerance))) {
        ema_descent_ended(session);
    } else {
        session->promised = fall / variance;
        for (uint32_t i = 0; i < count; ++i) {
            const ema_identified_t* const identified = &config->identified[i];
            annealer->candidate.x[i] = ema_clamp(
                annealer->current.x[i] + (step[i] / (identified->upper - identified->lower)), EMA_R(0.0), EMA_R(1.0));
        }
        ema_descent_try(session);
    }
}

/* The runs at the candidate have ended with this cost: where it fell, the descent goes on from there; where it did not,
 * by a shorter step, or it ends. */
static EMA_NOINLINE void ema_descent_decide(ema_session_t* session, ema_real cost)
{
    ema_annealer_t* const annealer = &session->annealer;
    const bool known = (annealer->current.cost < EMA_COST_MAX) && !session->settled;
    annealer->candidate.cost = cost;
    if (cost < annealer->best.cost) {
        ema_copy(&annealer->best, &annealer->candidate, sizeof annealer->best);
    }
    if ((cost < annealer->current.cost) || (session->settled && (cost < EMA_COST_MAX))) {
        session->failed_steps = 0U;
        ema_copy(&annealer->current, &annealer->candidate, sizeof annealer->current);
        ema_descent_propose(session);
    } else if (known && (session->promised <= EMA_DESCENT_FALL_ROUNDED)) {
        session->settled = true;
        ema_copy(&annealer->candidate, &annealer->current, sizeof annealer->candidate);
        ema_descent_try(session);
    } else if (known && (session->failed_steps < EMA_DESCENT_FAILED_MAX)) {
        ++session->failed_steps;
        session->promised *= EMA_DESCENT_SHORTER_KEEPS;
        for (uint32_t i = 0; i < session->config->identified_count; ++i) {
            const ema_real x = annealer->current.x[i];
            annealer->candidate.x[i] = x + (EMA_DESCENT_SHORTER * (annealer->candidate.x[i] - x));
        }
        ema_descent_try(session);
    } else {
        ema_descent_leave(session);
    }
}

/* The healthy actuator is next, for its cost, and those beside it with `count` values moved. */
static ema_status_t ema_search_begin(ema_session_t* session, uint32_t count)
{
    ema_copy(&session->actuator, session->config->actuator, sizeof session->actuator);
    return ema_runs_begin(session, count, EMA_COST_MAX);
}

/* The runs have ended, or a model of them could not be made: bounds can hold values that are too stiff for instance,
 * which cost the most, and the search goes on. */
static void ema_runs_ended(ema_session_t* session, bool made)
{
    const uint32_t beside = session->sensitivity.parameters;
    const ema_real cost =
        (made && (session->sensitivity.cost < EMA_COST_MAX)) ? session->sensitivity.cost : EMA_COST_MAX;
    const bool first = !session->healthy_done;
    if (first && !made) {
        /* beside the healthy actuator, which the annealer does not need */
        session->stage = EMA_STAGE_ANNEALER;
        (void)ema_search_begin(session, 0U);
        return;
    }
    session->evaluations += 1U + beside;
    if (first) {
        session->healthy_done = true;
        session->healthy_cost = cost;
    }
    if (beside > 0U) {
        ema_descent_decide(session, cost);
    } else if (!first || session->starts_healthy) {
        ema_search_decide(session, cost);
    } else if (session->stage == EMA_STAGE_LEAST_SQUARES) {
        ema_descent_try(session);
    } else {
        if (session->starts_cool) {
            ema_search_cool(session);
        }
        ema_search_try(session);
    }
}

ema_status_t ema_session_search_open(ema_session_t* session)
{
    const uint32_t count = session->config->identified_count;
    const bool both = (session->config->search == EMA_SEARCH_TWO_STAGES)
                      && (session->annealer.config.evaluation_budget > (1U + count));
    session->stage = both ? EMA_STAGE_LEAST_SQUARES : EMA_STAGE_ANNEALER;
    session->phase = EMA_PHASE_SEARCHING;
    return ema_search_begin(session, (both && session->starts_healthy) ? count : 0U);
}

uint32_t ema_session_part_work(const ema_session_t* session)
{
    const ema_sensitivity_t* const sensitivity = &session->sensitivity;
    uint32_t work = 0U;
    if (sensitivity->prepared <= sensitivity->parameters) {
        work = EMA_MODEL_WORK;
    } else if (ema_sensitivity_done(sensitivity)) {
        work = EMA_DECISION_WORK(session->config->identified_count);
    } else {
        /* is divided as one likes */
    }
    return work;
}

ema_status_t ema_session_part(ema_session_t* session)
{
    const bool model = session->sensitivity.prepared <= session->sensitivity.parameters;
    const ema_status_t status = model ? ema_runs_model(session) : EMA_OK;
    const bool made = status == EMA_OK;
    if (!made && !session->healthy_done && (session->sensitivity.prepared == 1U)) {
        /* of the healthy actuator no model can be made */
        return status;
    }
    if (model && made) {
        /* the next part */
    } else if (session->phase == EMA_PHASE_ASSESSING) {
        /* without a model beside the estimate it is left without standard errors */
        session->evaluations += made ? (1U + session->sensitivity.parameters) : 0U;
        session->assessed = made;
        session->phase = EMA_PHASE_DONE;
    } else {
        ema_runs_ended(session, made);
    }
    return EMA_OK;
}
