/* The bank of wear laws: each a row of numbers, and what a value comes to by it. Times are shares of the time since the
 * first reading, values shares of the limit. */
#ifndef EMA_LAW_H
#define EMA_LAW_H

#include <stdint.h>

#include "ema/detail/ema_real.h"

/* The first of them, which do not wear. */
#define EMA_LAWS_STILL 2U

#define EMA_LAW_STALLS 2U

typedef struct {
    ema_real parts;                 /* of the age, at whose ends the edges stand: onset, stalls and their ends */
    ema_real onset;                 /* wear begins */
    ema_real stall[EMA_LAW_STALLS]; /* stops for a while, from here, */
    ema_real again[EMA_LAW_STALLS]; /* to here; 1 for one that lasts, and both 1 for none */
    ema_real power;                 /* of the time in which it went on; 0 for none */
    ema_real growth;                /* e-foldings in one of it, where wear feeds on itself; 0 for none */
    ema_real pole;  /* such time after which it would be without bound, where it feeds on more of itself; 0 for none */
    ema_real order; /* of the pole: 1 where it feeds on its square, 2 on its power of 3 / 2 */
    ema_real fade;  /* time in which grease runs in; 0 for none */
    ema_real walk;  /* standard deviation of a random walk over one of it: steps and irregular wear */
    ema_real share_log; /* logarithm of what it is given before the readings */
} ema_law_t;

/* The law `number`, below EMA_FORECAST_LAWS. */
ema_law_t ema_law_of(uint32_t number);

/* Time in which wear went on until `at`. */
ema_real ema_law_own_time(const ema_law_t* law, ema_real at);

/* How much of the edges of its onset and its stalls has gone by `at`, each spread over the part about it: 0 .. 5. */
ema_real ema_law_passed(const ema_law_t* law, ema_real at);

/* Wear of rate 1 after that own time, which is 1 after 1; and how fast it rises there. */
ema_real ema_law_risen(const ema_law_t* law, ema_real own_time);
ema_real ema_law_rises(const ema_law_t* law, ema_real own_time);

/* The part that fades, from 0 towards -1. */
ema_real ema_law_faded(const ema_law_t* law, ema_real at);

/* For how long it has been stalled at the last reading; 0 where wear goes on. */
ema_real ema_law_stalled_for(const ema_law_t* law);

#endif
