/* What the desk's own files share. */
#ifndef EMA_DESK_ACTUATOR_H
#define EMA_DESK_ACTUATOR_H

#include "ema/ema.h"

/* The actuator of the flat arrays. */
void ema_actuator_from(const double* values, const int32_t* options, ema_actuator_t* actuator);

#endif
