/* When wear that is known with a doubt first reaches the limit. */
#ifndef EMA_FIRST_PASSAGE_H
#define EMA_FIRST_PASSAGE_H

#include "ema/detail/ema_real.h"

/* Probability that a normal number of mean 0 and variance 1 lies above `z`. Error under 1e-6, in float64
 * under 1e-7. */
ema_real ema_normal_above(ema_real z);

/* Probability that the limit is reached by a time at which the value has advanced by `advance` from `left` below the
 * limit, with the variance `doubt` of what is known and `walked` of a random walk until then; above zero together.
 * First passage of a Brownian motion whose drift is normal (Cox and Miller 1965, section 5.7, with the drift integrated
 * out). */
ema_real ema_reached(ema_real left, ema_real advance, ema_real doubt, ema_real walked);

#endif
