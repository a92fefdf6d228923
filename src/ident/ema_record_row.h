/* Reading a record's rows inside the loops that run the model. */
#ifndef EMA_RECORD_ROW_H
#define EMA_RECORD_ROW_H

#include "base/ema_choice.h"
#include "base/ema_math.h"
#include "ema/detail/ema_plant.h"
#include "ema/ema_record.h"

/* Whether a record keeps counts, and the command that is a function, NULL where it is recorded. */
static inline bool ema_record_counts(const ema_record_t* record)
{
    return (EMA_ONLY_INT16 != 0) || (record->format == EMA_RECORD_INT16);
}

static inline const ema_command_t* ema_record_function(const ema_record_t* record)
{
    return (EMA_ONLY_RECORDED != 0) ? NULL : record->command;
}

/* Value at place `place` of row `row`. */
static inline ema_real ema_record_value(const ema_record_t* record, uint32_t row, uint32_t place)
{
    const size_t at = ((size_t)row * record->stride) + place;
    return ema_record_counts(record) ? ((ema_real)((const int16_t*)record->buffer)[at] * record->unit[place])
                                     : ((const ema_real*)record->buffer)[at];
}

/* Whether the weights of the channels, by ema_channel_t, are finite, none negative, one of them positive, and those on
 * recorded channels alone. */
bool ema_record_weights(const ema_record_t* record, const ema_real* weight);

_Static_assert(((size_t)offsetof(ema_output_t, position_mm) == ((size_t)EMA_CHANNEL_POSITION * sizeof(ema_real)))
                   && ((size_t)offsetof(ema_output_t, motor_position_mm)
                       == ((size_t)EMA_CHANNEL_MOTOR_POSITION * sizeof(ema_real)))
                   && ((size_t)offsetof(ema_output_t, current_A) == ((size_t)EMA_CHANNEL_CURRENT * sizeof(ema_real)))
                   && ((size_t)offsetof(ema_output_t, voltage_V) == ((size_t)EMA_CHANNEL_VOLTAGE * sizeof(ema_real))),
               "the first values of a row are in the order of the channels");

/* What a run shows on a channel. */
static inline ema_real ema_output_channel(const ema_output_t* output, uint32_t channel)
{
    return ((const ema_real*)(const void*)output)[channel]; /* EMA-D4 */
}

/* Command of model step `step` in row `row`. */
static inline ema_real ema_record_command(const ema_record_t* record, uint32_t row, uint32_t step)
{
    const ema_command_t* const function = ema_record_function(record);
    return (function != NULL) ? ema_command_at(function, step) : ema_record_value(record, row, 0U);
}

/* The value and the command as functions, where they are not in the way of every model step. */
ema_real ema_record_at(const ema_record_t* record, uint32_t row, uint32_t place);
ema_real ema_record_asked(const ema_record_t* record, uint32_t row, uint32_t step);

/* The rod may rest anywhere in its play, and the sensor is noisy by this many standard deviations. */
#define EMA_START_NOISE EMA_R(4.0)

/* At the command when the first sample agrees with it within play and noise, else where the sample says. */
static inline ema_real ema_start_mm(const ema_params_t* params, const ema_record_t* record)
{
    const ema_real command_mm = ema_record_asked(record, 0U, 0U);
    const ema_real position_mm = ema_record_at(record, 0U, (uint32_t)record->place[EMA_CHANNEL_POSITION]);
    const ema_real apart_mm = ema_abs(position_mm - command_mm);
    const ema_real doubt_mm = (EMA_R(0.5) * params->blk_upper_mm) + (EMA_START_NOISE * params->position_noise_mm);
    return (apart_mm <= doubt_mm) ? command_mm : position_mm;
}

#endif
