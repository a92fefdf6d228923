/* A limit of zero in the data means that there is none. */
#ifndef EMA_LIMITS_H
#define EMA_LIMITS_H

#include "ema/detail/ema_real.h"

/* Large enough never to bind, small enough that sums of it stay finite. */
#define EMA_NO_LIMIT EMA_R(1.0e30)

/* Most model steps of a delay: the samples that are kept, less those of the parabola that reads between two of them. */
#define EMA_DELAY_STEPS_MAX EMA_R(12.0)

static inline ema_real ema_limit_or_none(ema_real limit)
{
    return (limit > EMA_R(0.0)) ? limit : EMA_NO_LIMIT;
}

#endif
