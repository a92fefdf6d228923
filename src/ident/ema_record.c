#include "ident/ema_record_row.h"

#include "base/ema_copy.h"
#include "base/ema_math.h"
#include "ident/ema_cursor_step.h"

#define EMA_INT16_FULL EMA_R(32767.0)

/* Below the least the value of one count has few bits left or none; above the largest all counts together may round to
 * infinity. */
#define EMA_FULL_SCALE_MIN EMA_R(1.0e-30)
#define EMA_FULL_SCALE_MAX EMA_R(1.0e30)

static bool ema_scale_valid(ema_real full_scale)
{
    return (full_scale >= EMA_FULL_SCALE_MIN) && (full_scale <= EMA_FULL_SCALE_MAX);
}

ema_status_t ema_record_init(ema_record_t* record, const ema_record_config_t* config)
{
    if ((record == NULL) || (config == NULL) || (config->buffer == NULL)) {
        return EMA_ERR_NULL;
    }
    if (((EMA_ONLY_INT16 != 0) && (config->format == EMA_RECORD_REAL))
        || ((EMA_ONLY_RECORDED != 0) && (config->command != NULL))) {
        return EMA_ERR_ABSENT;
    }
    ema_record_t made;
    ema_clear(&made, sizeof made);
    made.buffer = config->buffer;
    made.command = config->command;
    made.format = config->format;
    bool scales = true;
    if (ema_record_function(&made) == NULL) {
        made.unit[0] = config->command_full_scale_mm / EMA_INT16_FULL;
        scales = ema_scale_valid(config->command_full_scale_mm);
        made.stride = 1U;
    }
    for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
        made.place[channel] = -1;
        if ((channel == (uint32_t)EMA_CHANNEL_POSITION) || config->keep[channel]) {
            made.place[channel] = (int8_t)made.stride;
            made.unit[made.stride] = config->full_scale[channel] / EMA_INT16_FULL;
            scales = scales && ema_scale_valid(config->full_scale[channel]);
            ++made.stride;
        }
    }
    const size_t value_bytes = ema_record_counts(&made) ? sizeof(int16_t) : sizeof(ema_real);
    const size_t rows = config->buffer_bytes / (value_bytes * made.stride);
    const bool known =
        (config->format == EMA_RECORD_INT16) || ((EMA_ONLY_INT16 == 0) && (config->format == EMA_RECORD_REAL));
    if (((uintptr_t)config->buffer % value_bytes) != 0U) {
        return EMA_ERR_ALIGN;
    }
    if ((rows < 1U) || !known || (ema_record_counts(&made) && !scales)) {
        return EMA_ERR_RANGE;
    }
    made.capacity = (rows < (size_t)INT32_MAX) ? (uint32_t)rows : (uint32_t)INT32_MAX;
    ema_copy(record, &made, sizeof made);
    return EMA_OK;
}

/* The value at `place` of a row, in the order in which rows are stored. */
static ema_real ema_sample_value(const ema_record_t* record, const ema_sample_t* sample, uint32_t place)
{
    ema_real value = sample->command_mm;
    for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
        if (record->place[channel] == (int8_t)place) {
            value = sample->channel[channel];
        }
    }
    return value;
}

ema_status_t ema_record_append(ema_record_t* record, const ema_sample_t* sample)
{
    if ((record == NULL) || (sample == NULL)) {
        return EMA_ERR_NULL;
    }
    if (record->count >= record->capacity) {
        return EMA_ERR_FULL;
    }
    const bool scaled = ema_record_counts(record);
    ema_real row[1U + EMA_CHANNEL_COUNT];
    for (uint32_t place = 0; place < record->stride; ++place) {
        row[place] = ema_sample_value(record, sample, place);
        if (!ema_is_finite(row[place])) {
            return EMA_ERR_NOT_FINITE;
        }
        if (scaled && (ema_abs(row[place]) > (record->unit[place] * EMA_INT16_FULL))) {
            return EMA_ERR_SCALE;
        }
    }
    const size_t start = (size_t)record->count * record->stride;
    for (uint32_t place = 0; place < record->stride; ++place) {
        if (scaled) {
            ((int16_t*)record->buffer)[start + place] = (int16_t)ema_clamp(
                ema_floor((row[place] / record->unit[place]) + EMA_R(0.5)), -EMA_INT16_FULL, EMA_INT16_FULL);
        } else {
            ((ema_real*)record->buffer)[start + place] = row[place];
        }
    }
    if ((ema_record_function(record) == NULL) && (record->count > 0U)) {
        record->asked_mm +=
            ema_abs(ema_record_value(record, record->count, 0U) - ema_record_value(record, record->count - 1U, 0U));
    }
    ++record->count;
    return EMA_OK;
}

ema_status_t ema_record_read(const ema_record_t* record, uint32_t row, uint32_t every_steps, ema_sample_t* sample)
{
    if ((record == NULL) || (sample == NULL)) {
        return EMA_ERR_NULL;
    }
    if (row >= record->count) {
        return EMA_ERR_RANGE;
    }
    sample->command_mm = ema_record_command(record, row, row * every_steps);
    for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
        sample->channel[channel] =
            (record->place[channel] < 0) ? EMA_R(0.0) : ema_record_value(record, row, (uint32_t)record->place[channel]);
    }
    return EMA_OK;
}

ema_real ema_record_at(const ema_record_t* record, uint32_t row, uint32_t place)
{
    return ema_record_value(record, row, place);
}

ema_real ema_record_asked(const ema_record_t* record, uint32_t row, uint32_t step)
{
    return ema_record_command(record, row, step);
}

bool ema_record_weights(const ema_record_t* record, const ema_real* weight)
{
    bool valid = true;
    bool any = false;
    for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
        const bool weighs = (weight[channel] > EMA_R(0.0)) && ema_is_finite(weight[channel]);
        valid = valid && ((weight[channel] == EMA_R(0.0)) || (weighs && (record->place[channel] >= 0)));
        any = any || weighs;
    }
    return valid && any;
}

ema_status_t ema_record_adopt(ema_record_t* record, uint32_t rows)
{
    if (record == NULL) {
        return EMA_ERR_NULL;
    }
    if (rows > (record->capacity - record->count)) {
        return EMA_ERR_FULL;
    }
    const uint32_t end = record->count + rows;
    /* every count is a number */
    if (!ema_record_counts(record)) {
        for (uint32_t row = record->count; row < end; ++row) {
            for (uint32_t place = 0; place < record->stride; ++place) {
                if (!ema_is_finite(ema_record_value(record, row, place))) {
                    return EMA_ERR_NOT_FINITE;
                }
            }
        }
    }
    /* in the order in which rows are appended, so that the sum is the same to the bit */
    for (uint32_t row = (record->count > 0U) ? record->count : 1U; (ema_record_function(record) == NULL) && (row < end);
         ++row) {
        record->asked_mm += ema_abs(ema_record_value(record, row, 0U) - ema_record_value(record, row - 1U, 0U));
    }
    record->count = end;
    return EMA_OK;
}

void ema_cursor_start(ema_cursor_t* cursor, const ema_record_t* record, const ema_actuator_t* actuator)
{
    cursor->record = record;
    cursor->every_steps = (uint32_t)actuator->options.record_every_steps;
    cursor->rows = record->count;
    cursor->row = 0U;
    cursor->step_in_row = 0U;
}
