#include "ema/detail/ema_onboard.h"

#include <string.h>

#include "base/ema_bounds.h"
#include "base/ema_copy.h"
#include "base/ema_math.h"
#include "ident/ema_cursor_step.h"
#include "ident/ema_run_begin.h"
#include "plant/ema_run.h"

/* Start and factor of the checksum by Fowler, Noll and Vo, over words. */
#define EMA_FINGERPRINT_START 2166136261U
#define EMA_FINGERPRINT_FACTOR 16777619U

/* So much of what CSJ and BLK have moved in the signals may look like something else: standing errors of a machine grow
 * with its friction. */
#define EMA_TRUST EMA_R(0.02)

/* Scores nearer than this to the best, three standard deviations or a share of it, are not told from it. */
#define EMA_ALIKE EMA_R(9.0)
#define EMA_ALIKE_SHARE EMA_R(0.02)

/* An effect that leaves more than this share of the excess is not what is missing. */
#define EMA_LEFT_SHARE EMA_R(0.5)

static uint32_t ema_fingerprint_add(uint32_t fingerprint, uint32_t word)
{
    return (fingerprint ^ word) * EMA_FINGERPRINT_FACTOR;
}

uint32_t ema_onboard_fingerprint(const ema_actuator_t* actuator)
{
    uint32_t fingerprint = EMA_FINGERPRINT_START;
    for (uint32_t id = 0; id < (uint32_t)EMA_VALUE_COUNT; ++id) {
        const ema_real value = ema_value_of(actuator, (ema_value_id_t)id);
        const bool fault = (id == (uint32_t)EMA_VALUE_ID(csj_Nm)) || (id == (uint32_t)EMA_VALUE_ID(blk_mm));
        const float single = fault ? 0.0f : (float)value;
        uint32_t word = 0U;
        (void)memcpy(&word, &single, sizeof word); /* EMA-D3 */
        fingerprint = ema_fingerprint_add(fingerprint, word);
    }
    const int32_t* const option = (const int32_t*)(const void*)&actuator->options; /* EMA-D4 */
    for (uint32_t k = 0; k < (uint32_t)EMA_OPTION_COUNT; ++k) {
        fingerprint = ema_fingerprint_add(fingerprint, (uint32_t)option[k]);
    }
    return fingerprint;
}

/* Numbers of a table with which the loops below stay inside its arrays. */
static bool ema_table_sound(const ema_signatures_t* table)
{
    bool sound = (table->version == EMA_SIGNATURES_VERSION) && (table->pattern != NULL) && (table->unit != NULL)
                 && (table->value != NULL);
    sound = sound && (table->channels >= 1U) && (table->channels <= EMA_CHANNEL_COUNT)
            && (table->faults <= EMA_SIGNATURE_FAULTS_MAX);
    sound = sound && (table->rows <= EMA_SIGNATURE_ROWS_MAX) && (table->nuisances <= table->rows)
            && (table->patterns >= 1U) && (table->patterns <= EMA_SIGNATURE_ROWS_MAX);
    sound = sound && (table->bins >= 1U) && (table->bin_rows >= 1U)
            && (table->bins <= (table->record_rows / table->bin_rows));
    for (uint32_t k = 0; sound && (k < table->channels); ++k) {
        sound = table->channel[k] < EMA_CHANNEL_COUNT;
    }
    for (uint32_t k = 0; sound && (k < table->patterns); ++k) {
        const ema_pattern_t* const pattern = &table->pattern[k];
        sound = (pattern->effect < (uint8_t)EMA_EFFECT_COUNT) && (pattern->rows >= 1U) && (pattern->rows <= 2U)
                && (((uint32_t)pattern->first + pattern->rows) <= table->rows);
    }
    for (uint32_t k = 0; sound && (k < table->faults); ++k) {
        sound = (table->fault[k].row < table->rows) && ((size_t)table->fault[k].id < EMA_VALUE_COUNT);
    }
    return sound;
}

ema_status_t ema_onboard_check(const ema_signatures_t* table, const ema_actuator_t* actuator,
                               const ema_record_t* record)
{
    if ((table == NULL) || (actuator == NULL) || (record == NULL)) {
        return EMA_ERR_NULL;
    }
    if (!ema_table_sound(table) || (table->fingerprint != ema_onboard_fingerprint(actuator))) {
        return EMA_ERR_TABLE;
    }
    for (uint32_t k = 0; k < table->channels; ++k) {
        if (record->place[table->channel[k]] < 0) {
            return EMA_ERR_RANGE;
        }
    }
    return EMA_OK;
}

ema_status_t ema_onboard_start(ema_onboard_t* self, const ema_signatures_t* table, const ema_actuator_t* actuator,
                               const ema_record_t* record, ema_real start_mm)
{
    if (self == NULL) {
        return EMA_ERR_NULL;
    }
    const ema_status_t status = ema_onboard_check(table, actuator, record);
    return (status == EMA_OK) ? ema_onboard_begin(self, table, actuator, record, start_mm) : status;
}

ema_status_t ema_onboard_begin(ema_onboard_t* self, const ema_signatures_t* table, const ema_actuator_t* actuator,
                               const ema_record_t* record, ema_real start_mm)
{
    const ema_status_t status = ema_model_init(&self->model, actuator, start_mm);
    if (status == EMA_OK) {
        ema_clear(&self->scores, sizeof self->scores);
        self->scores.table = table;
        for (uint32_t k = 0; k < table->faults; ++k) {
            const ema_signature_fault_t* const fault = &table->fault[k];
            ema_real value = EMA_R(0.0);
            (void)ema_actuator_get(actuator, fault->id, &value);
            const ema_real moved = (value - fault->healthy) * fault->length;
            self->scores.moved_square += moved * moved;
        }
        const uint32_t wanted = table->bins * table->bin_rows;
        ema_cursor_start(&self->cursor, record, actuator);
        /* what follows the last whole bin is left out */
        self->cursor.rows = (wanted < self->cursor.rows) ? wanted : self->cursor.rows;
    }
    return status;
}

/* The mean of a bin goes into every sum. */
static void ema_scores_bin(ema_scores_t* scores)
{
    const ema_signatures_t* const table = scores->table;
    const size_t stride = (size_t)1U + ((size_t)table->channels * ((size_t)1U + table->rows));
    const int16_t* value = &table->value[stride * scores->bin];
    const ema_real share = EMA_R(1.0) / (ema_real)table->bin_rows;
    const ema_real apart_mm = ema_abs((scores->command_mm * share) - ((ema_real)value[0] * table->command_unit_mm));
    /* written so that NaN is far away */
    scores->command_apart_mm = (apart_mm <= scores->command_apart_mm) ? scores->command_apart_mm : apart_mm;
    ++value;
    ema_real white[EMA_CHANNEL_COUNT];
    for (uint32_t k = 0; k < table->channels; ++k) {
        white[k] = ((scores->difference[k] * share) - ((ema_real)value[k] * table->reference[k])) * table->weight[k];
        scores->square += white[k] * white[k];
        scores->difference[k] = EMA_R(0.0);
    }
    value = &value[table->channels];
    for (uint32_t row = 0; row < table->rows; ++row) {
        ema_real sum = EMA_R(0.0);
        for (uint32_t k = 0; k < table->channels; ++k) {
            sum += (ema_real)value[k] * white[k];
        }
        scores->product[row] += sum * table->unit[row];
        value = &value[table->channels];
    }
    scores->command_mm = EMA_R(0.0);
    scores->row_in_bin = 0U;
    ++scores->bin;
}

bool ema_onboard_done(const ema_onboard_t* self)
{
    return ema_cursor_ended(&self->cursor);
}

uint32_t ema_onboard_run(ema_onboard_t* self, uint32_t steps)
{
    const ema_signatures_t* const table = self->scores.table;
    ema_cursor_t* const cursor = &self->cursor;
    ema_scores_t* const scores = &self->scores;
    uint32_t made = 0U;
    self->model.work.spent = 0U;
    while ((self->model.work.spent < steps) && !ema_cursor_ended(cursor)) {
        const ema_real command_mm = ema_cursor_command(cursor, self->model.state.step);
        ema_output_t simulated;
        ema_tick(&self->model.plant, &self->model.state, &self->model.work, command_mm, &simulated);
        ++made;
        if (ema_cursor_row_due(cursor)) {
            const ema_record_t* const record = cursor->record;
            for (uint32_t k = 0; k < table->channels; ++k) {
                const uint32_t channel = table->channel[k];
                scores->difference[k] += ema_record_value(record, cursor->row, (uint32_t)record->place[channel])
                                         - ema_output_channel(&simulated, channel);
            }
            scores->command_mm += command_mm;
            ++scores->row_in_bin;
            if (scores->row_in_bin == table->bin_rows) {
                ema_scores_bin(scores);
            }
        }
        ema_cursor_pass(cursor);
    }
    return made;
}

/* By how much a pattern lowers the squared residual, and the size that this asks for. */
static ema_real ema_pattern_score(const ema_scores_t* scores, const ema_pattern_t* pattern, ema_real* size)
{
    const ema_real first = scores->product[pattern->first];
    ema_real score = EMA_R(0.0);
    *size = EMA_R(0.0);
    if (pattern->rows == 2U) {
        const ema_real second = scores->product[pattern->first + 1U];
        const ema_real along = (pattern->turn[0] * first) + (pattern->turn[1] * second);
        const ema_real across = pattern->turn[2] * second;
        *size = ema_sqrt((along * along) + (across * across));
        score = ((first * first) + (second * second)) - pattern->penalty;
    } else if (!pattern->one_sided || (first > EMA_R(0.0))) {
        *size = pattern->turn[0] * first;
        score = (first * first) - pattern->penalty;
    } else {
        /* the wrong sign */
    }
    return score;
}

/* The best pattern of the effect whose patterns begin at `*place`, which is moved behind them. */
static ema_real ema_effect_score(const ema_scores_t* scores, uint32_t* place, ema_real* size)
{
    const ema_signatures_t* const table = scores->table;
    const uint8_t effect = table->pattern[*place].effect;
    ema_real best = -EMA_R(1.0);
    *size = EMA_R(0.0);
    while ((*place < table->patterns) && (table->pattern[*place].effect == effect)) {
        ema_real own = EMA_R(0.0);
        const ema_real score = ema_pattern_score(scores, &table->pattern[*place], &own);
        if (score > best) {
            best = score;
            *size = own;
        }
        ++(*place);
    }
    return best;
}

/* Ranks the effects. */
static void ema_scores_rank(const ema_scores_t* scores, ema_finding_t* finding)
{
    const ema_signatures_t* const table = scores->table;
    uint32_t place = 0U;
    while (place < table->patterns) {
        const ema_effect_id_t effect = (ema_effect_id_t)table->pattern[place].effect;
        ema_real size = EMA_R(0.0);
        const ema_real score = ema_effect_score(scores, &place, &size);
        if (score > finding->score) {
            finding->runner_up = finding->effect;
            finding->runner_up_score = finding->score;
            finding->effect = effect;
            finding->score = score;
            finding->size = size;
        } else if (score > finding->runner_up_score) {
            finding->runner_up = effect;
            finding->runner_up_score = score;
        } else {
            /* behind two others */
        }
    }
    const ema_real near = finding->score - ema_max(EMA_ALIKE, EMA_ALIKE_SHARE * finding->score);
    place = 0U;
    while ((finding->effect != EMA_EFFECT_COUNT) && (place < table->patterns)) {
        const uint32_t effect = table->pattern[place].effect;
        ema_real size = EMA_R(0.0);
        const ema_real score = ema_effect_score(scores, &place, &size);
        finding->alike |= ((score > EMA_R(0.0)) && (score >= near)) ? ((ema_effect_set_t)1U << effect) : 0U;
    }
}

ema_status_t ema_onboard_result(const ema_onboard_t* self, ema_finding_t* finding)
{
    if ((self == NULL) || (finding == NULL)) {
        return EMA_ERR_NULL;
    }
    if (!ema_onboard_done(self)) {
        return EMA_ERR_ORDER;
    }
    const ema_scores_t* const scores = &self->scores;
    const ema_signatures_t* const table = scores->table;
    const ema_finding_t fresh = {.kind = EMA_FINDING_NONE, .effect = EMA_EFFECT_COUNT, .runner_up = EMA_EFFECT_COUNT};
    *finding = fresh;
    finding->energy = scores->square;
    for (uint32_t row = 0; row < table->nuisances; ++row) {
        finding->energy -= scores->product[row] * scores->product[row];
    }
    finding->limit = table->limit + (EMA_TRUST * EMA_TRUST * scores->moved_square);
    const bool same =
        (self->cursor.record->count == table->record_rows) && (scores->command_apart_mm <= table->command_apart_mm);
    if (same && ema_is_finite(finding->energy)) {
        for (uint32_t k = 0; k < table->faults; ++k) {
            finding->moved[k] = table->fault[k].turn * scores->product[table->fault[k].row];
        }
        ema_scores_rank(scores, finding);
        const ema_real allowed = table->energy + (finding->limit - table->limit);
        const ema_real excess = finding->energy - allowed;
        if ((finding->score <= finding->limit) && (excess <= finding->limit)) {
            finding->kind = EMA_FINDING_ADEQUATE;
        } else if ((finding->score > finding->limit) && ((excess - finding->score) <= (EMA_LEFT_SHARE * excess))) {
            finding->kind = EMA_FINDING_MISSING;
        } else {
            finding->kind = EMA_FINDING_UNKNOWN;
        }
    }
    return EMA_OK;
}

static const char* const ema_effect_names[] = {
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters) #name,
#include "ema/ema_effects.def"
};

const char* ema_effect_name(ema_effect_id_t effect)
{
    return ((uint32_t)effect < (uint32_t)EMA_EFFECT_COUNT) ? ema_effect_names[effect] : "none";
}
