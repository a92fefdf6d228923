/* What a search by least squares asks of its configuration, and the values of its coordinates. */
#ifndef EMA_LEAST_SQUARES_CHECK_H
#define EMA_LEAST_SQUARES_CHECK_H

#include "ema/ema_least_squares.h"

/* Value at the coordinate `x` of the unit box. */
static inline ema_real ema_searched_at(const ema_searched_t* searched, ema_real x)
{
    return searched->lower + (x * (searched->upper - searched->lower));
}

/* What the companion is where the value is `value`. */
ema_real ema_searched_with(const ema_searched_t* searched, const ema_actuator_t* actuator, ema_real value);

/* Errors: those of ema_least_squares_init but the model's. No address is NULL. */
ema_status_t ema_least_squares_check(const ema_least_squares_config_t* config, const ema_record_t* record);

/* Numbers that are compared, less those that are searched. */
ema_real ema_squares_freedom(const ema_least_squares_t* self);

/* Whether the lowest point so far explains the record. */
bool ema_squares_adequate(const ema_least_squares_t* self);

#endif
