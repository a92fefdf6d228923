/* The range of a value as the module itself checks it: without nominal values, which firmware does not need. */
#ifndef EMA_BOUNDS_H
#define EMA_BOUNDS_H

#include "ema/ema_actuator.h"

typedef struct {
    ema_real lower;
    ema_real upper;
} ema_bounds_t;

/* Bounds of real value `id`; false when there is none in this build. Cost: one comparison per effect. */
bool ema_bounds_of(size_t id, ema_bounds_t* bounds);

/* Real value `id`, which there is: for those that were checked before. One that became none since reads as another. */
ema_real ema_value_of(const ema_actuator_t* actuator, ema_value_id_t id);

#endif
