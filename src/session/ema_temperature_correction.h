/* What is known of the day: what its temperature makes of CSJ, and how far readings of a sound machine lie apart. */
#ifndef EMA_TEMPERATURE_CORRECTION_H
#define EMA_TEMPERATURE_CORRECTION_H

#include "ema/ema_session.h"

/* Fills the scatter of every estimate of `result`, which has its shifts, and brings CSJ to the temperature of the
 * healthy runs where the actuator says what a degree does to it and grease and winding, searched beside it, agree;
 * where they do not, what the temperature that both allow may make of it is part of its scatter. */
void ema_temperature_correction(const ema_session_config_t* config, ema_result_t* result);

#endif
