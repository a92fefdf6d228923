/* Prepares a plant from an actuator (blocks, responses of the circuits, state at rest) and runs its model steps. */
#ifndef EMA_RUN_H
#define EMA_RUN_H

#include "ema/detail/ema_step_scratch.h"

/* Prepares everything but the responses of the circuits: ema_circuit_prepare. Errors, the plant unchanged:
 * EMA_ERR_RANGE, EMA_ERR_INERTIA, EMA_ERR_STIFF. */
ema_status_t ema_plant_prepare(ema_plant_t* plant, ema_step_scratch_t* work, const ema_actuator_t* actuator,
                               ema_real start_mm);

/* What ema_model_init does, for plant and state that stand apart; no address is NULL. */
ema_status_t ema_run_prepare(ema_plant_t* plant, ema_state_t* state, ema_step_scratch_t* work,
                             const ema_actuator_t* actuator, ema_real start_mm);

/* Puts the state to the plant's start. */
void ema_state_rest(ema_state_t* state, const ema_plant_t* plant);

/* What ema_model_learned does. */
void ema_plant_learned(ema_plant_t* plant, const ema_actuator_t* actuator);

/* One model step with `command_mm` held over it; `row` is what it shows, except the rod's speed, which no objective
 * looks at. */
void ema_tick(const ema_plant_t* plant, ema_state_t* state, ema_step_scratch_t* work, ema_real command_mm,
              ema_output_t* row);

#endif
