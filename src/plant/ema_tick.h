/* The order of the six blocks inside one model step: ema_tick.c is the only place that knows it. */
#ifndef EMA_TICK_H
#define EMA_TICK_H

#include "ema/detail/ema_step_scratch.h"

/* One model step with `command_mm` held over it; `row` is what it shows, except the rod's speed, which no objective
 * looks at. */
void ema_tick(const ema_plant_t* plant, ema_state_t* state, ema_step_scratch_t* work, ema_real command_mm,
              ema_output_t* row);

#endif
