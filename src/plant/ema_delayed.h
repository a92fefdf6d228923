/* A drive that passes its output on with a delay. */
#ifndef EMA_DELAYED_H
#define EMA_DELAYED_H

#include "blocks/ema_drive.h"

/* Keeps the output; what is applied at the start of the model step goes to the work. */
void ema_delayed_output(const ema_plant_t* plant, ema_state_t* state, ema_step_scratch_t* work, ema_real output);

/* The model step under it: first what was asked before, over its share, then what was asked later; each in as many
 * integration steps as a whole one. */
void ema_delayed_step(const ema_plant_t* plant, ema_state_t* state, ema_step_scratch_t* work);

#endif
