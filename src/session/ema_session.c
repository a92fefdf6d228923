#include "ema/ema_session.h"

#include <stddef.h>

#include "base/ema_bounds.h"
#include "base/ema_choice.h"
#include "base/ema_copy.h"
#include "base/ema_math.h"
#include "ident/ema_record_row.h"
#include "session/ema_session_search.h"
#include "session/ema_temperature_correction.h"
#include "session/ema_verdict.h"

/* Farther from the ground test's mean speed a command is another one: rounding, and a rest before or after, are less.
 */
#define EMA_COMMAND_APART EMA_R(0.05)

/* First step of the annealer's walk and length of its stall window per parameter. */
#define EMA_FIRST_STEP EMA_R(0.2)
#define EMA_STALL_PER_PARAMETER 20U

ema_status_t ema_session_config_default(ema_session_config_t* config, const ema_actuator_t* actuator,
                                        const ema_record_config_t* record)
{
    if ((config == NULL) || (actuator == NULL) || (record == NULL)) {
        return EMA_ERR_NULL;
    }
    const ema_params_t* const params = &actuator->params;
    ema_clear(config, sizeof *config);
    config->actuator = actuator;
    ema_copy(&config->record, record, sizeof *record);
    config->weight[EMA_CHANNEL_POSITION] = EMA_R(1.0);
    config->identified_count = 2U;
    ema_identified_t* const csj = &config->identified[0];
    csj->id = EMA_VALUE_ID(csj_Nm);
    csj->lower = params->csj_lower_Nm;
    csj->upper = params->csj_upper_Nm;
    csj->min_shift_percent = params->csj_min_shift_percent;
    ema_identified_t* const blk = &config->identified[1];
    blk->id = EMA_VALUE_ID(blk_mm);
    blk->lower = params->blk_lower_mm;
    blk->upper = params->blk_upper_mm;
    blk->min_shift_percent = params->blk_min_shift_percent;
    config->annealer.first_step = EMA_FIRST_STEP;
    config->annealer.initial_temperature = params->initial_temperature_mm2s;
    config->annealer.cooling = params->cooling;
    config->annealer.function_tolerance = params->function_tolerance_mm2s;
    config->annealer.stall_evaluations = EMA_STALL_PER_PARAMETER * config->identified_count;
    config->annealer.reanneal_interval = (uint32_t)actuator->options.reanneal_interval;
    config->annealer.evaluation_budget = (uint32_t)actuator->options.evaluation_budget;
    config->annealer.seed = (uint64_t)(uint32_t)actuator->options.seed;
    config->search = EMA_SEARCH_TWO_STAGES;
    config->start_at_healthy = true;
    config->abandon = true;
    return EMA_OK;
}

/* Whether the value is one, and may be where it is searched. */
static bool ema_identified_inside(const ema_identified_t* identified)
{
    bool inside = (size_t)identified->id < EMA_VALUE_COUNT;
#if !EMA_ONLY_CHECKED
    ema_bounds_t bounds;
    inside = ema_bounds_of(identified->id, &bounds) && (identified->lower >= bounds.lower)
             && (identified->upper <= bounds.upper);
#endif
    return inside;
}

static ema_status_t ema_identified_check(const ema_session_config_t* config, ema_annealer_config_t* annealer)
{
    if ((config->identified_count < 1U) || (config->identified_count > EMA_IDENTIFIED_MAX)) {
        return EMA_ERR_RANGE;
    }
    annealer->dimension = config->identified_count;
    for (uint32_t i = 0; i < config->identified_count; ++i) {
        const ema_identified_t* const identified = &config->identified[i];
        if (!(identified->lower < identified->upper)) {
            return EMA_ERR_BOUNDS;
        }
        if (ema_actuator_is_learned(identified->id) || !ema_identified_inside(identified)) {
            return EMA_ERR_RANGE;
        }
        const ema_real healthy = ema_value_of(config->actuator, identified->id);
        if (!(healthy >= identified->lower) || !(healthy <= identified->upper) || (healthy == EMA_R(0.0))
            || !(identified->min_shift_percent >= EMA_R(0.0))) {
            return EMA_ERR_RANGE;
        }
        for (uint32_t k = 0; k < i; ++k) {
            if (config->identified[k].id == identified->id) {
                return EMA_ERR_RANGE;
            }
        }
        if (config->start_at_healthy) {
            annealer->start[i] = ema_clamp((healthy - identified->lower) / (identified->upper - identified->lower),
                                           EMA_R(0.0), EMA_R(1.0));
        }
    }
    return EMA_OK;
}

ema_status_t ema_session_init(ema_session_t* session, const ema_session_config_t* config)
{
    if ((session == NULL) || (config == NULL) || (config->actuator == NULL)) {
        return EMA_ERR_NULL;
    }
    ema_status_t status = ema_actuator_check(config->actuator, NULL);
    ema_annealer_config_t annealer;
    ema_copy(&annealer, &config->annealer, sizeof annealer);
    if (status == EMA_OK) {
        status = ema_identified_check(config, &annealer);
    }
    ema_record_t record;
    if (status == EMA_OK) {
        status = ema_record_init(&record, &config->record);
    }
    if ((status == EMA_OK) && !ema_record_weights(&record, config->weight)) {
        status = EMA_ERR_RANGE;
    }
    if (status == EMA_OK) {
        /* the annealer refuses before anything has changed */
        status = ema_annealer_init(&session->annealer, &annealer);
    }
    if (status == EMA_OK) {
        ema_clear(session, (size_t)offsetof(ema_session_t, annealer));
        ema_clear(&session->actuator, sizeof *session - (size_t)offsetof(ema_session_t, actuator));
        session->config = config;
        ema_copy(&session->record, &record, sizeof record);
        session->starts_healthy = config->start_at_healthy;
        session->phase = EMA_PHASE_FEEDING;
    }
    return status;
}

/* How many values are searched was settled at the start: another number now would be read past the end. */
static bool ema_session_unchanged(const ema_session_t* session)
{
    return session->config->identified_count == session->annealer.config.dimension;
}

static bool ema_session_feeds(const ema_session_t* session)
{
    return (session->config != NULL) && (session->phase == EMA_PHASE_FEEDING);
}

ema_status_t ema_session_feed(ema_session_t* session, const ema_sample_t* sample)
{
    if ((session == NULL) || (sample == NULL)) {
        return EMA_ERR_NULL;
    }
    if (!ema_session_feeds(session)) {
        return EMA_ERR_ORDER;
    }
    const ema_status_t status = ema_record_append(&session->record, sample);
    /* a full record takes no later row, so its rows still follow each other */
    session->gap = session->gap || ((status != EMA_OK) && (status != EMA_ERR_FULL));
    return status;
}

ema_status_t ema_session_run(ema_session_t* session, uint32_t steps)
{
    if (session == NULL) {
        return EMA_ERR_NULL;
    }
    if (session->config == NULL) {
        return EMA_ERR_ORDER;
    }
    if ((steps == 0U) || !ema_session_unchanged(session)) {
        return EMA_ERR_RANGE;
    }
    ema_status_t status = EMA_OK;
    const bool opens = session->phase == EMA_PHASE_FEEDING;
    if (opens) {
        if (session->record.count < EMA_ROWS_MIN) {
            return EMA_ERR_SHORT;
        }
        status = ema_session_search_open(session);
    }
    if (session->phase != EMA_PHASE_DONE) {
        /* a copy of a session reads its own record, not the original's */
        session->sensitivity.cursor.record = &session->record;
    }
    uint32_t left = steps;
    while ((status == EMA_OK) && (left > 0U) && (session->phase != EMA_PHASE_DONE)) {
        uint32_t spent = ema_session_part_work(session);
        if (spent == 0U) {
            session->model_steps += ema_sensitivity_run(&session->sensitivity, left);
            spent = session->sensitivity.work.spent;
        } else if ((spent > left) && (left < steps)) {
            /* to the next slice */
            spent = left;
        } else {
            status = ema_session_part(session);
        }
        left = (left > spent) ? (left - spent) : 0U;
    }
    if (opens && (status != EMA_OK)) {
        /* no model can be made of the healthy actuator */
        session->phase = EMA_PHASE_FEEDING;
    }
    return status;
}

ema_phase_t ema_session_phase(const ema_session_t* session)
{
    return (session == NULL) ? EMA_PHASE_FEEDING : session->phase;
}

/* Whether the record runs another command than the unit's ground test. */
static bool ema_session_elsewhere(const ema_session_t* session)
{
    const ema_actuator_t* const actuator = session->config->actuator;
    const uint32_t rows = session->record.count - 1U;
    const ema_real steps = (ema_real)rows * (ema_real)actuator->options.record_every_steps;
    const ema_real usual_mm = actuator->params.command_speed_mm_s * (steps * actuator->params.step_s);
    return (usual_mm > EMA_R(0.0)) && (ema_record_function(&session->record) == NULL)
           && !(ema_abs(session->record.asked_mm - usual_mm) <= (EMA_COMMAND_APART * usual_mm));
}

ema_status_t ema_session_result(const ema_session_t* session, ema_result_t* result)
{
    if ((session == NULL) || (result == NULL)) {
        return EMA_ERR_NULL;
    }
    if (session->phase == EMA_PHASE_FEEDING) {
        return EMA_ERR_ORDER;
    }
    if (!ema_session_unchanged(session)) {
        return EMA_ERR_RANGE;
    }
    const ema_session_config_t* const config = session->config;
    ema_clear(result, sizeof *result);
    ema_sensitivity_result_t assessed;
    ema_clear(&assessed, sizeof assessed);
    if ((session->phase == EMA_PHASE_DONE) && session->assessed) {
        ema_sensitivity_result(&session->sensitivity, &assessed);
    }
    result->identified_count = config->identified_count;
    for (uint32_t i = 0; i < config->identified_count; ++i) {
        ema_estimate_t* const estimate = &result->identified[i];
        const ema_real x = session->annealer.best.x[i];
        const ema_real healthy = ema_value_of(config->actuator, config->identified[i].id);
        estimate->estimate = ema_identified_at(&config->identified[i], x);
        estimate->today = estimate->estimate;
        estimate->std = assessed.std[i];
        estimate->bias = assessed.bias[i];
        estimate->shift_percent = ((estimate->estimate - healthy) / healthy) * EMA_R(100.0);
        estimate->at_bound = ema_at_bound(x);
    }
    ema_temperature_correction(config, result);
    result->objective_before = session->healthy_cost;
    result->objective_after = session->annealer.best.cost;
    result->residual_rms_mm = assessed.residual_rms_mm;
    result->residual_correlation = assessed.residual_correlation;
    result->outside_ratio = assessed.outside_ratio;
    result->evaluations = session->evaluations;
    result->model_steps = session->model_steps;
    result->search = session->annealer.info;
    result->random = session->annealer.random;
    result->outcome = ema_annealer_outcome(&session->annealer);
    result->stage = session->stage;
    if (session->phase == EMA_PHASE_DONE) {
        ema_verdict_judge(config, assessed.determined && assessed.crossed, result);
        if (ema_session_elsewhere(session)) {
            result->reasons |= (uint32_t)EMA_REASON_OTHER_COMMAND;
            result->verdict = EMA_VERDICT_UNDECIDED;
        }
        if (session->gap) {
            result->reasons |= (uint32_t)EMA_REASON_GAP;
            result->verdict = EMA_VERDICT_UNDECIDED;
        }
    } else {
        result->verdict = EMA_VERDICT_UNDECIDED;
        result->reasons = (uint32_t)EMA_REASON_NOT_FINISHED;
    }
    return EMA_OK;
}

ema_status_t ema_session_adopt(ema_session_t* session, uint32_t rows)
{
    if (session == NULL) {
        return EMA_ERR_NULL;
    }
    return ema_session_feeds(session) ? ema_record_adopt(&session->record, rows) : EMA_ERR_ORDER;
}

ema_status_t ema_session_gap(ema_session_t* session)
{
    if (session == NULL) {
        return EMA_ERR_NULL;
    }
    if (!ema_session_feeds(session)) {
        return EMA_ERR_ORDER;
    }
    session->gap = true;
    return EMA_OK;
}

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

uint32_t ema_session_check(const ema_session_config_t* config)
{
    if ((config == NULL) || (config->actuator == NULL)) {
        return 0U;
    }
    const ema_params_t* const params = &config->actuator->params;
    ema_annealer_config_t annealer;
    ema_copy(&annealer, &config->annealer, sizeof annealer);
    annealer.dimension =
        (config->identified_count < EMA_IDENTIFIED_MAX) ? config->identified_count : EMA_IDENTIFIED_MAX;
    for (uint32_t i = 0; config->start_at_healthy && (i < annealer.dimension); ++i) {
        const ema_identified_t* const identified = &config->identified[i];
        ema_real healthy = EMA_R(0.0);
        (void)ema_actuator_get(config->actuator, identified->id, &healthy);
        annealer.start[i] = (healthy - identified->lower) / (identified->upper - identified->lower);
    }
    /* with other signals in it the objective's noise is not known here */
    bool alone = config->weight[EMA_CHANNEL_POSITION] > EMA_R(0.0);
    for (uint32_t channel = 0; channel < (uint32_t)EMA_CHANNEL_COUNT; ++channel) {
        alone = alone && ((channel == (uint32_t)EMA_CHANNEL_POSITION) || (config->weight[channel] == EMA_R(0.0)));
    }
    const ema_real period_s = params->step_s * (ema_real)config->actuator->options.record_every_steps;
    const ema_real noise_mm = params->position_noise_mm;
    const ema_real resolution =
        alone ? (config->weight[EMA_CHANNEL_POSITION] * noise_mm * noise_mm * period_s) : EMA_R(0.0);
    return ema_annealer_check(&annealer, resolution);
}

/* Standard deviations on either side that hold 95 % of a normal distribution. */
#define EMA_WIDTH_95 EMA_R(1.96)

/* What is not seen is stated as three standard deviations, as a share of a share in %. */
#define EMA_UNSEEN_STDS EMA_R(3.0e4)

ema_status_t ema_session_half_95(const ema_session_config_t* config, const ema_result_t* result, uint32_t place,
                                 ema_real* half_95)
{
    if ((config == NULL) || (config->actuator == NULL) || (result == NULL) || (half_95 == NULL)) {
        return EMA_ERR_NULL;
    }
    if ((place >= config->identified_count) || (place >= result->identified_count) || (place >= EMA_IDENTIFIED_MAX)) {
        return EMA_ERR_RANGE;
    }
    const ema_identified_t* const identified = &config->identified[place];
    const ema_estimate_t* const estimate = &result->identified[place];
    const uint32_t open = (uint32_t)EMA_REASON_NOT_FINISHED | (uint32_t)EMA_REASON_NOT_SENSITIVE;
    if (((result->reasons & open) != 0U) && !(estimate->std > EMA_R(0.0))) {
        *half_95 = identified->upper - identified->lower;
        return EMA_OK;
    }
    ema_real healthy = EMA_R(0.0);
    (void)ema_actuator_get(config->actuator, identified->id, &healthy);
    const ema_real value = ema_max(ema_abs(estimate->estimate), ema_abs(healthy));
    const ema_real scatter = (estimate->scatter_percent / EMA_R(100.0)) * value;
    /* three standard deviations of it, of the healthy value, in ten thousandths */
    const ema_real unseen =
        ((config->actuator->params.unseen_percent * identified->min_shift_percent) / EMA_UNSEEN_STDS) * healthy;
    const ema_real square =
        ((estimate->std * estimate->std) + (estimate->bias * estimate->bias)) + (scatter * scatter) + (unseen * unseen);
    *half_95 = EMA_WIDTH_95 * ema_sqrt(square);
    return EMA_OK;
}

const char* ema_reason_text(uint32_t reason)
{
    const char* text;
    switch (reason) {
#define EMA_REASON_CASE(name, bit, message)                                                                            \
    case (uint32_t)(name):                                                                                             \
        text = (message);                                                                                              \
        break;
        EMA_REASON_LIST(EMA_REASON_CASE)
#undef EMA_REASON_CASE
    default:
        text = "unknown reason";
        break;
    }
    return text;
}
