/* A drive that passes its output on with a delay. */
#ifndef EMA_LATE_H
#define EMA_LATE_H

#include "ema_drive.h"

/* Current of a circuit without a time constant, from the instant on at which the drive applies its input. */
static inline void ema_drive_current(const ema_plant_t* plant, ema_state_t* state, const ema_drive_output_t* applied)
{
    const ema_circuit_t* const circuit = ema_circuit_of(plant, applied);
    if (circuit->algebraic) {
        state->current_A = ema_circuit_follow(plant, circuit, state, applied->input);
    }
}

/* Keeps the output; what is applied at the start of the model step goes to the work. */
void ema_late_output(const ema_plant_t* plant, ema_state_t* state, ema_work_t* work, ema_real output);

/* The model step under it: first what was asked before, over its share, then what was asked later; each in as many
 * integration steps as a whole one. */
void ema_late_step(const ema_plant_t* plant, ema_state_t* state, ema_work_t* work);

#endif
