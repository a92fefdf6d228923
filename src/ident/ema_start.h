/* Where the rod rests before a record. */
#ifndef EMA_START_H
#define EMA_START_H

#include "base/ema_math.h"
#include "ident/ema_record_row.h"

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
