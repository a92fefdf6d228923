#include "ema_desk.h"

#include <stdlib.h>

#include "ema/ema.h"
#include "ema_desk_actuator.h"
#include "ema_desk_record.h"

static const ema_desk_row_t ema_parameter_rows[] = {
#define EMA_PARAM(section, field, nominal, lower, upper, text) {#section, #field, text, "", nominal, lower, upper, 0},
#define EMA_OPTION(section, field, nominal, lower, upper, choices, text)                                               \
    {#section, #field, text, choices, nominal, lower, upper, 1},
#include "ema/ema_params.def"
};

static const ema_desk_row_t ema_effect_value_rows[] = {
#define EMA_P(field, nominal, lower, upper, text) {"", #field, text, "", nominal, lower, upper, 0},
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters) parameters
#include "ema/ema_effects.def"
};

/* The user's own are the last of the list. */
enum {
    EMA_OWN_EFFECT_COUNT = 0
#ifdef EMA_OWN_EFFECTS
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters) +1
#include EMA_OWN_EFFECTS
#undef EMA_EFFECT
#endif
};

static const ema_desk_effect_t ema_effect_rows[] = {
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters)                            \
    {#name,                                                                                                            \
     #site,                                                                                                            \
     equation,                                                                                                         \
     source,                                                                                                           \
     look_alikes,                                                                                                      \
     (memory),                                                                                                         \
     (substeps),                                                                                                       \
     0,                                                                                                                \
     0,                                                                                                                \
     (int32_t)(offsetof(ema_effects_t, name) / sizeof(ema_real)),                                                      \
     (int32_t)(sizeof(ema_effect_##name##_t) / sizeof(ema_real))},
#include "ema/ema_effects.def"
};

#define EMA_COUNT(array) ((int32_t)(sizeof(array) / sizeof((array)[0])))

_Static_assert((sizeof(ema_parameter_rows) / sizeof(ema_parameter_rows[0])) == (EMA_PARAM_COUNT + EMA_OPTION_COUNT),
               "a row per parameter and option");
_Static_assert((sizeof(ema_effect_value_rows) / sizeof(ema_effect_value_rows[0])) == EMA_EFFECT_VALUE_COUNT,
               "a row per value of an effect");

int32_t ema_desk_real_bits(void)
{
    return (int32_t)(8U * sizeof(ema_real));
}

uint32_t ema_desk_schema(void)
{
    return EMA_CONFIG_SCHEMA;
}

uint32_t ema_desk_version(void)
{
    return EMA_VERSION;
}

int32_t ema_desk_value_count(void)
{
    return (int32_t)EMA_VALUE_COUNT;
}

int32_t ema_desk_option_count(void)
{
    return (int32_t)EMA_OPTION_COUNT;
}

static int32_t ema_row_of(const ema_desk_row_t* rows, int32_t count, int32_t index, ema_desk_row_t* row)
{
    if (row == NULL) {
        return (int32_t)EMA_ERR_NULL;
    }
    if ((index < 0) || (index >= count)) {
        return (int32_t)EMA_ERR_RANGE;
    }
    *row = rows[index];
    return (int32_t)EMA_OK;
}

int32_t ema_desk_parameter_row(int32_t index, ema_desk_row_t* row)
{
    return ema_row_of(ema_parameter_rows, EMA_COUNT(ema_parameter_rows), index, row);
}

int32_t ema_desk_effect_value_row(int32_t index, ema_desk_row_t* row)
{
    return ema_row_of(ema_effect_value_rows, EMA_COUNT(ema_effect_value_rows), index, row);
}

int32_t ema_desk_effect_row(int32_t index, ema_desk_effect_t* row)
{
    if (row == NULL) {
        return (int32_t)EMA_ERR_NULL;
    }
    if ((index < 0) || (index >= (int32_t)EMA_EFFECT_COUNT)) {
        return (int32_t)EMA_ERR_RANGE;
    }
    *row = ema_effect_rows[index];
    row->is_learned = ema_actuator_is_learned((ema_value_id_t)(EMA_PARAM_COUNT + (size_t)row->first_value)) ? 1 : 0;
    row->is_own = (index >= ((int32_t)EMA_EFFECT_COUNT - (int32_t)EMA_OWN_EFFECT_COUNT)) ? 1 : 0;
    return (int32_t)EMA_OK;
}

const char* ema_desk_status_text(int32_t status)
{
    return ema_status_text((ema_status_t)status);
}

const char* ema_desk_reason_text(int32_t index, int32_t* bit)
{
    static const int32_t bits[] = {
#define EMA_REASON_BIT(name, value, text) (int32_t)(name),
        EMA_REASON_LIST(EMA_REASON_BIT)
#undef EMA_REASON_BIT
    };
    if ((bit == NULL) || (index < 0) || (index >= EMA_COUNT(bits))) {
        return NULL;
    }
    *bit = bits[index];
    return ema_reason_text((uint32_t)bits[index]);
}

int32_t ema_desk_check(const double* values, const int32_t* options, int32_t* offender)
{
    if ((values == NULL) || (options == NULL)) {
        return (int32_t)EMA_ERR_NULL;
    }
    ema_actuator_t actuator;
    ema_actuator_from(values, options, &actuator);
    size_t bad = 0;
    const ema_status_t status = ema_actuator_check(&actuator, &bad);
    if ((status != EMA_OK) && (offender != NULL)) {
        *offender = (int32_t)bad;
    }
    return (int32_t)status;
}

int32_t ema_desk_simulate(const double* values, const int32_t* options, const double* command_mm, int32_t rows,
                          double start_mm, double* out, int32_t* unlocated_event_steps)
{
    if ((values == NULL) || (options == NULL) || (command_mm == NULL) || (out == NULL)) {
        return (int32_t)EMA_ERR_NULL;
    }
    ema_actuator_t actuator;
    ema_model_t model;
    ema_actuator_from(values, options, &actuator);
    ema_status_t status = ema_model_init(&model, &actuator, (ema_real)start_mm);
    const int32_t every = (status == EMA_OK) ? actuator.options.record_every_steps : 1;
    for (int32_t row = 0; (status == EMA_OK) && (row < rows); ++row) {
        for (int32_t k = 0; (status == EMA_OK) && (k < every); ++k) {
            ema_output_t output;
            status = ema_model_step(&model, (ema_real)command_mm[row], &output);
            if (k == 0) {
                const size_t at = (size_t)row;
                const size_t count = (size_t)rows;
                out[at] = (double)output.position_mm;
                out[count + at] = (double)output.motor_position_mm;
                out[(2U * count) + at] = (double)output.current_A;
                out[(3U * count) + at] = (double)output.voltage_V;
                out[(4U * count) + at] = (double)output.speed_mm_s;
            }
        }
    }
    if ((status == EMA_OK) && (unlocated_event_steps != NULL)) {
        *unlocated_event_steps = (int32_t)model.state.unlocated_event_steps;
    }
    return (int32_t)status;
}

int32_t ema_desk_command(int32_t kind, const double* numbers, double step_s, int32_t rows, double* command_mm)
{
    if ((numbers == NULL) || (command_mm == NULL)) {
        return (int32_t)EMA_ERR_NULL;
    }
    if ((kind < 0) || (kind >= (int32_t)EMA_COMMAND_RECORD) || !(numbers[5] >= 0.0) || !(numbers[5] <= 1.0e6)) {
        return (int32_t)EMA_ERR_RANGE;
    }
    ema_command_config_t config = {0};
    config.kind = (ema_command_kind_t)kind;
    config.amplitude_mm = (ema_real)numbers[0];
    config.start_hz = (ema_real)numbers[1];
    config.end_hz = (ema_real)numbers[2];
    config.duration_s = (ema_real)numbers[3];
    config.share = (ema_real)numbers[4];
    config.count = (uint32_t)numbers[5];
    config.time_s = (ema_real)numbers[6];
    ema_command_t command;
    const ema_status_t status = ema_command_init(&command, &config, (ema_real)step_s);
    for (int32_t row = 0; (status == EMA_OK) && (row < rows); ++row) {
        command_mm[row] = (double)ema_command_at(&command, (uint32_t)row);
    }
    return (int32_t)status;
}

int32_t ema_desk_objective(const double* values, const int32_t* options, const double* command_mm,
                           const double* channels, const double* weight, int32_t rows, double start_mm,
                           double* objective)
{
    if ((values == NULL) || (options == NULL) || (command_mm == NULL) || (channels == NULL) || (weight == NULL)
        || (objective == NULL)) {
        return EMA_ERR_NULL;
    }
    if (rows < 1) {
        return EMA_ERR_SHORT;
    }
    ema_actuator_t actuator;
    ema_record_config_t config;
    ema_record_t record;
    ema_objective_t run;
    const bool none[EMA_CHANNEL_COUNT] = {false};
    ema_real weights[EMA_CHANNEL_COUNT];
    for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
        weights[channel] = (ema_real)weight[channel];
    }
    ema_actuator_from(values, options, &actuator);
    ema_status_t status = ema_record_config_from(&config, command_mm, channels, weight, none, rows, 0);
    if (status == EMA_OK) {
        status = ema_record_init(&record, &config);
    }
    for (int32_t row = 0; (status == EMA_OK) && (row < rows); ++row) {
        const ema_sample_t sample = ema_sample_from(command_mm, channels, row);
        status = ema_record_append(&record, &sample);
    }
    if (status == EMA_OK) {
        status = ema_objective_start(&run, &actuator, &record, weights, (ema_real)start_mm, EMA_COST_MAX);
    }
    if (status == EMA_OK) {
        while (ema_objective_run(&run, UINT32_MAX) == EMA_OBJECTIVE_RUNNING) {
        }
        *objective = (double)ema_objective_value(&run);
    }
    free(config.buffer);
    return (int32_t)status;
}

int32_t ema_desk_search_default(const double* values, const int32_t* options, ema_desk_search_t* search)
{
    if ((values == NULL) || (options == NULL) || (search == NULL)) {
        return (int32_t)EMA_ERR_NULL;
    }
    ema_actuator_t actuator;
    const ema_record_config_t record = {0};
    ema_session_config_t config;
    const ema_desk_search_t fresh = {0};
    ema_actuator_from(values, options, &actuator);
    ema_status_t status = ema_session_config_default(&config, &actuator, &record);
    if (status == EMA_OK) {
        status = ema_session_config_day(&config);
    }
    *search = fresh;
    search->identified_count = (int32_t)config.identified_count;
    for (uint32_t i = 0; i < config.identified_count; ++i) {
        search->identified_id[i] = (int32_t)config.identified[i].id;
        search->identified_lower[i] = (double)config.identified[i].lower;
        search->identified_upper[i] = (double)config.identified[i].upper;
        search->identified_min_shift_percent[i] = (double)config.identified[i].min_shift_percent;
    }
    for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
        search->weight[channel] = (double)config.weight[channel];
    }
    search->start_at_healthy = config.start_at_healthy ? 1 : 0;
    search->abandon = config.abandon ? 1 : 0;
    search->slice_steps = 100;
    search->evaluation_budget = (int32_t)config.annealer.evaluation_budget;
    search->reanneal_interval = (int32_t)config.annealer.reanneal_interval;
    search->initial_temperature = (double)config.annealer.initial_temperature;
    search->cooling = (double)config.annealer.cooling;
    search->function_tolerance = (double)config.annealer.function_tolerance;
    search->seed = (int64_t)config.annealer.seed;
    search->search = (int32_t)config.search;
    return (int32_t)status;
}

static ema_status_t ema_session_config_from(ema_session_config_t* config, const ema_actuator_t* actuator,
                                            const ema_record_config_t* record, const ema_desk_search_t* search)
{
    ema_status_t status = ema_session_config_default(config, actuator, record);
    if ((status == EMA_OK)
        && ((search->identified_count < 1) || (search->identified_count > (int32_t)EMA_IDENTIFIED_MAX)
            || (search->slice_steps < 1))) {
        status = EMA_ERR_RANGE;
    }
    if (status == EMA_OK) {
        config->identified_count = (uint32_t)search->identified_count;
        config->annealer.stall_evaluations = (config->annealer.stall_evaluations / 2U) * config->identified_count;
        for (uint32_t i = 0; (status == EMA_OK) && (i < config->identified_count); ++i) {
            const ema_real lower = (ema_real)search->identified_lower[i];
            const ema_real upper = (ema_real)search->identified_upper[i];
            const ema_identified_t identified = {(ema_value_id_t)search->identified_id[i], lower, upper,
                                                 (ema_real)search->identified_min_shift_percent[i]};
            config->identified[i] = identified;
            config->annealer.start[i] = ((ema_real)search->start[i] - lower) / (upper - lower);
            if ((search->identified_id[i] < 0) || (search->identified_id[i] >= (int32_t)EMA_VALUE_COUNT)) {
                status = EMA_ERR_RANGE;
            }
        }
        for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
            config->weight[channel] = (ema_real)search->weight[channel];
        }
        config->search = (search->search != 0) ? EMA_SEARCH_TWO_STAGES : EMA_SEARCH_ANNEALER;
        config->start_at_healthy = search->start_at_healthy != 0;
        config->abandon = search->abandon != 0;
        config->annealer.evaluation_budget = (uint32_t)search->evaluation_budget;
        config->annealer.reanneal_interval = (uint32_t)search->reanneal_interval;
        config->annealer.initial_temperature = (ema_real)search->initial_temperature;
        config->annealer.cooling = (ema_real)search->cooling;
        config->annealer.function_tolerance = (ema_real)search->function_tolerance;
        config->annealer.seed = (uint64_t)search->seed;
    }
    return status;
}

int32_t ema_desk_search_check(const double* values, const int32_t* options, const ema_desk_search_t* search,
                              int32_t* warnings)
{
    if ((values == NULL) || (options == NULL) || (search == NULL) || (warnings == NULL)) {
        return (int32_t)EMA_ERR_NULL;
    }
    ema_actuator_t actuator;
    ema_session_config_t config;
    const ema_record_config_t none = {0};
    ema_actuator_from(values, options, &actuator);
    const ema_status_t status = ema_session_config_from(&config, &actuator, &none, search);
    if (status == EMA_OK) {
        *warnings = (int32_t)ema_session_check(&config);
    }
    return (int32_t)status;
}

static void ema_result_to(const ema_session_config_t* config, const ema_result_t* from, ema_desk_result_t* to)
{
    const ema_desk_result_t fresh = {0};
    *to = fresh;
    for (uint32_t i = 0; i < from->identified_count; ++i) {
        to->estimate[i] = (double)from->identified[i].estimate;
        to->std[i] = (double)from->identified[i].std;
        to->shift_percent[i] = (double)from->identified[i].shift_percent;
        to->at_bound[i] = from->identified[i].at_bound ? 1 : 0;
        to->bias[i] = (double)from->identified[i].bias;
        ema_real half_95 = EMA_R(0.0);
        (void)ema_session_half_95(config, from, i, &half_95);
        to->half_95[i] = (double)half_95;
        to->scatter_percent[i] = (double)from->identified[i].scatter_percent;
        to->today[i] = (double)from->identified[i].today;
    }
    to->objective_before = (double)from->objective_before;
    to->objective_after = (double)from->objective_after;
    to->residual_rms_mm = (double)from->residual_rms_mm;
    to->residual_correlation = (double)from->residual_correlation;
    to->model_steps = (int64_t)from->model_steps;
    to->evaluations = (int32_t)from->evaluations;
    to->accepted = (int32_t)from->search.accepted;
    to->accepted_uphill = (int32_t)from->search.accepted_uphill;
    to->outcome = (int32_t)from->outcome;
    to->stage = (int32_t)from->stage;
    to->verdict = (int32_t)from->verdict;
    to->adequate = from->adequate ? 1 : 0;
    to->reasons = (int32_t)from->reasons;
    to->random_state = from->random.state;
}

/* Whole numbers of a table that fit their types, and no more of them than the table says. */
static bool ema_table_fits(const ema_desk_table_t* table)
{
    bool fits = (table->pattern != NULL) && (table->fault != NULL) && (table->unit != NULL) && (table->value != NULL)
                && (table->version >= 0) && (table->record_rows >= 0) && (table->bin_rows >= 0) && (table->bins >= 0)
                && (table->channels >= 0) && (table->channels <= (int32_t)EMA_CHANNEL_COUNT) && (table->patterns >= 0)
                && (table->patterns <= (int32_t)EMA_SIGNATURE_ROWS_MAX) && (table->faults >= 0)
                && (table->faults <= (int32_t)EMA_SIGNATURE_FAULTS_MAX) && (table->nuisances >= 0) && (table->rows >= 0)
                && (table->rows <= (int32_t)EMA_SIGNATURE_ROWS_MAX);
    fits = fits && ((int64_t)table->values == ((int64_t)table->bins * (1 + (table->channels * (1 + table->rows)))));
    for (int32_t k = 0; fits && (k < table->channels); ++k) {
        fits = (table->channel[k] >= 0) && (table->channel[k] < (int32_t)EMA_CHANNEL_COUNT);
    }
    for (int32_t k = 0; fits && (k < (3 * table->patterns)); ++k) {
        const double number = table->pattern[(8 * (k / 3)) + (k % 3)];
        fits = (number >= 0.0) && (number <= (double)UINT8_MAX);
    }
    for (int32_t k = 0; fits && (k < table->faults); ++k) {
        const double* const row = &table->fault[5 * k];
        fits =
            (row[0] >= 0.0) && (row[0] < (double)EMA_VALUE_COUNT) && (row[1] >= 0.0) && (row[1] <= (double)UINT8_MAX);
    }
    return fits;
}

/* What of a table is made anew in the module's types. */
typedef struct {
    ema_signatures_t table;
    ema_pattern_t pattern[EMA_SIGNATURE_ROWS_MAX];
    ema_real unit[EMA_SIGNATURE_ROWS_MAX];
} ema_desk_signatures_t;

static void ema_signatures_from(const ema_desk_table_t* from, ema_desk_signatures_t* to)
{
    const ema_desk_signatures_t fresh = {0};
    *to = fresh;
    ema_signatures_t* const table = &to->table;
    table->version = (uint32_t)from->version;
    table->fingerprint = from->fingerprint;
    table->record_rows = (uint32_t)from->record_rows;
    table->bin_rows = (uint32_t)from->bin_rows;
    table->bins = (uint32_t)from->bins;
    table->channels = (uint32_t)from->channels;
    table->patterns = (uint32_t)from->patterns;
    table->faults = (uint32_t)from->faults;
    table->nuisances = (uint32_t)from->nuisances;
    table->rows = (uint32_t)from->rows;
    table->command_unit_mm = (ema_real)from->command_unit_mm;
    table->command_apart_mm = (ema_real)from->command_apart_mm;
    table->limit = (ema_real)from->limit;
    table->energy = (ema_real)from->energy;
    for (uint32_t k = 0; k < table->channels; ++k) {
        table->channel[k] = (uint8_t)from->channel[k];
        table->reference[k] = (ema_real)from->reference[k];
        table->weight[k] = (ema_real)from->weight[k];
    }
    for (uint32_t k = 0; k < table->patterns; ++k) {
        const double* const row = &from->pattern[8U * k];
        const ema_pattern_t pattern = {(uint8_t)row[0],
                                       (uint8_t)row[1],
                                       (uint8_t)row[2],
                                       row[3] != 0.0,
                                       {(ema_real)row[4], (ema_real)row[5], (ema_real)row[6]},
                                       (ema_real)row[7]};
        to->pattern[k] = pattern;
    }
    for (uint32_t k = 0; k < table->faults; ++k) {
        const double* const row = &from->fault[5U * k];
        const ema_signature_fault_t fault = {(ema_value_id_t)row[0], (uint8_t)row[1], (ema_real)row[2],
                                             (ema_real)row[3], (ema_real)row[4]};
        table->fault[k] = fault;
    }
    for (uint32_t k = 0; k < table->rows; ++k) {
        to->unit[k] = (ema_real)from->unit[k];
    }
    table->pattern = to->pattern;
    table->unit = to->unit;
    table->value = from->value;
}

static void ema_finding_to(const ema_finding_t* from, ema_desk_finding_t* to)
{
    const ema_desk_finding_t found = {.kind = (int32_t)from->kind,
                                      .effect = (int32_t)from->effect,
                                      .runner_up = (int32_t)from->runner_up,
                                      .alike = (uint64_t)from->alike,
                                      .score = (double)from->score,
                                      .runner_up_score = (double)from->runner_up_score,
                                      .limit = (double)from->limit,
                                      .size = (double)from->size,
                                      .energy = (double)from->energy,
                                      .moved = {(double)from->moved[0], (double)from->moved[1]}};
    *to = found;
}

/* The values at a point of the search, in the parameters' units. */
static void ema_tried_at(const ema_session_config_t* config, const ema_real* x, double* tried)
{
    for (uint32_t i = 0; i < config->identified_count; ++i) {
        const double lower = (double)config->identified[i].lower;
        tried[i] = lower + ((double)x[i] * ((double)config->identified[i].upper - lower));
    }
}

/* Runs a fed session to its end, unless the progress stops it. */
static ema_status_t ema_guarded_to_end(ema_guarded_t* guarded, int32_t slice_steps, ema_desk_progress_t progress,
                                       void* context)
{
    const ema_session_t* const session = &guarded->session;
    const ema_annealer_t* const annealer = &session->annealer;
    ema_status_t status = EMA_OK;
    uint32_t told = 0U;
    uint32_t descents = 0U; /* model runs of the least squares that were told */
    bool stopped = false;
    double tried[EMA_IDENTIFIED_MAX] = {0.0};
    while ((status == EMA_OK) && !stopped && (ema_guarded_phase(guarded) != EMA_GUARDED_DONE)) {
        ema_tried_at(session->config, ema_annealer_candidate(annealer), tried);
        status = ema_guarded_run(guarded, (uint32_t)slice_steps);
        if ((status == EMA_OK) && (progress != NULL) && (session->stage == EMA_STAGE_LEAST_SQUARES)
            && (annealer->best.cost < EMA_COST_MAX) && (session->evaluations > descents)) {
            descents = session->evaluations;
            ema_tried_at(session->config, annealer->best.x, tried);
            stopped =
                progress((int32_t)descents, (double)annealer->best.cost, (double)annealer->best.cost, tried, context)
                != 0;
        } else if ((status == EMA_OK) && (progress != NULL) && (annealer->info.evaluations > told)) {
            const bool one = annealer->info.evaluations == (told + 1U);
            told = annealer->info.evaluations;
            if (told == 1U) {
                /* the start may have been moved meanwhile; it is always taken */
                ema_tried_at(session->config, annealer->current.x, tried);
            }
            stopped = progress((int32_t)(descents + told), (double)annealer->last_cost, (double)annealer->best.cost,
                               one ? tried : NULL, context)
                      != 0;
        }
    }
    return status;
}

/* With a table, or without where `signatures` is NULL. */
static int32_t ema_identify(const double* values, const int32_t* options, const double* command_mm,
                            const double* channels, int32_t rows, const ema_desk_search_t* search,
                            const ema_signatures_t* signatures, ema_desk_progress_t progress, void* context,
                            ema_desk_result_t* result, ema_desk_finding_t* finding, int32_t* bad_row)
{
    if ((values == NULL) || (options == NULL) || (command_mm == NULL) || (channels == NULL) || (search == NULL)
        || (result == NULL)) {
        return (int32_t)EMA_ERR_NULL;
    }
    if (rows < (int32_t)EMA_ROWS_MIN) {
        return (int32_t)EMA_ERR_SHORT;
    }
    ema_actuator_t actuator;
    ema_record_config_t record;
    ema_session_config_t config;
    ema_guarded_t guarded;
    ema_actuator_from(values, options, &actuator);
    bool keep[EMA_CHANNEL_COUNT] = {false};
    for (uint32_t k = 0; (signatures != NULL) && (k < signatures->channels); ++k) {
        keep[signatures->channel[k]] = true;
    }
    ema_status_t status =
        ema_record_config_from(&record, command_mm, channels, search->weight, keep, rows, search->int16_record);
    if (status == EMA_OK) {
        status = ema_session_config_from(&config, &actuator, &record, search);
    }
    if (status == EMA_OK) {
        status = ema_guarded_init(&guarded, &config, signatures);
    }
    for (int32_t row = 0; (status == EMA_OK) && (row < rows); ++row) {
        const ema_sample_t sample = ema_sample_from(command_mm, channels, row);
        status = ema_guarded_feed(&guarded, &sample);
        if ((status != EMA_OK) && (bad_row != NULL)) {
            *bad_row = row;
        }
    }
    if (status == EMA_OK) {
        status = ema_guarded_to_end(&guarded, search->slice_steps, progress, context);
    }
    if (status == EMA_OK) {
        ema_result_t onboard;
        ema_finding_t found;
        status = ema_guarded_result(&guarded, &onboard, &found);
        if (status == EMA_OK) {
            ema_result_to(&config, &onboard, result);
            if (finding != NULL) {
                ema_finding_to(&found, finding);
            }
        }
    }
    free(record.buffer);
    return (int32_t)status;
}

int32_t ema_desk_identify(const double* values, const int32_t* options, const double* command_mm,
                          const double* channels, int32_t rows, const ema_desk_search_t* search,
                          ema_desk_progress_t progress, void* context, ema_desk_result_t* result, int32_t* bad_row)
{
    return ema_identify(values, options, command_mm, channels, rows, search, NULL, progress, context, result, NULL,
                        bad_row);
}

int32_t ema_desk_identify_guarded(const double* values, const int32_t* options, const double* command_mm,
                                  const double* channels, int32_t rows, const ema_desk_search_t* search,
                                  const ema_desk_table_t* table, ema_desk_progress_t progress, void* context,
                                  ema_desk_result_t* result, ema_desk_finding_t* finding, int32_t* bad_row)
{
    if ((table == NULL) || (finding == NULL)) {
        return (int32_t)EMA_ERR_NULL;
    }
    if (!ema_table_fits(table)) {
        return (int32_t)EMA_ERR_TABLE;
    }
    ema_desk_signatures_t signatures;
    ema_signatures_from(table, &signatures);
    return ema_identify(values, options, command_mm, channels, rows, search, &signatures.table, progress, context,
                        result, finding, bad_row);
}

int32_t ema_desk_random(int64_t seed, int64_t stream, int32_t count, uint32_t* bits)
{
    if (bits == NULL) {
        return (int32_t)EMA_ERR_NULL;
    }
    ema_random_t random;
    ema_random_init(&random, (uint64_t)seed, (uint64_t)stream);
    for (int32_t k = 0; k < count; ++k) {
        bits[k] = ema_random_u32(&random);
    }
    return (int32_t)EMA_OK;
}
