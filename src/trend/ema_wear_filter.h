/* One wear law through all readings: a Kalman filter for level, rate and fading part, whose covariance is kept as
 * U D U' (Bierman 1977, section V.3; the walk adds to the level, which stands first, and so to D alone), since float32
 * leaves a covariance itself no longer positive. */
#ifndef EMA_WEAR_FILTER_H
#define EMA_WEAR_FILTER_H

#include "ema/detail/ema_real.h"

/* Level with what walked, rate, fading part. */
#define EMA_WEAR_STATES 3U

typedef struct {
    ema_real mean[EMA_WEAR_STATES];
    ema_real upper[EMA_WEAR_STATES]; /* of U: level and rate, level and fading, rate and fading; 1 on its diagonal */
    ema_real diagonal[EMA_WEAR_STATES];
    ema_real evidence_log; /* of the readings so far, but for what all laws share */
} ema_wear_t;

/* Before any reading. */
void ema_wear_begin(ema_wear_t* wear);

/* The level has walked with this variance. */
void ema_wear_walk(ema_wear_t* wear, ema_real variance);

/* Takes a reading of `row` times the states, of that variance. */
void ema_wear_take(ema_wear_t* wear, const ema_real row[EMA_WEAR_STATES], ema_real value, ema_real variance);

/* What `row` times the states comes to, and its variance. */
ema_real ema_wear_mean(const ema_wear_t* wear, const ema_real row[EMA_WEAR_STATES]);
ema_real ema_wear_variance(const ema_wear_t* wear, const ema_real row[EMA_WEAR_STATES]);

#endif
