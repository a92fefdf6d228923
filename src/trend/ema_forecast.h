/* The instants that a forecast looks at, and what comes of wear that may change its pace. Times are shares of the time
 * since the first reading. */
#ifndef EMA_FORECAST_H
#define EMA_FORECAST_H

#include <stdint.h>

#include "ema/ema_trend.h"

/* What is looked ahead; what comes later is open. */
#define EMA_FORECAST_HORIZON EMA_R(20.0)

/* Instant `place`, below EMA_FORECAST_TIMES: 0, and then evenly by its logarithm up to EMA_FORECAST_HORIZON. */
ema_real ema_forecast_time(uint32_t place);

/* The share that has reached the limit at instant `place`, by the shares over wear's own time where it goes on now and
 * where it is stalled. What goes on changes its pace at a time as likely as any other, one in each of those times: in
 * one case of four it stalls, else its pace turns to another whose logarithm scatters by 0.75. What has been stalled
 * for `stalled_for` still is after a further x with probability (1 + x / stalled_for)^-2; a stall to come lasts as one
 * that has been for 0.3. */
ema_real ema_forecast_share(const ema_real going[EMA_FORECAST_TIMES], const ema_real stalled[EMA_FORECAST_TIMES],
                            ema_real stalled_for, uint32_t place);

#endif
