/* The actuator's model: six blocks in series, one fixed step at a time.
 *
 * PID -> controller/drive -> motor -> gearbox -> ball screw with dry friction, ends of travel and backlash -> encoder.
 * Equations, signs and the order inside a step: docs/DESIGN.md, "One model step". Between reversals, saturations and
 * end stops the plant is linear and its input is held, so a step is exact; reversals, break-away, saturation and end
 * stops are located inside the step.
 */
#ifndef EMA_MODEL_H
#define EMA_MODEL_H

#include "ema/detail/ema_step_scratch.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    ema_plant_t plant;
    ema_state_t state;
    ema_step_scratch_t work; /* means nothing between two steps */
} ema_model_t;

/* Prepares the model of `actuator` with rod and motor at `start_mm`, at rest, the play centred. The actuator is copied
 * as far as it is needed; only learned tables that act stay where they are: then it must outlive the model, or
 * ema_model_learned names another place. Errors: EMA_ERR_NULL; EMA_ERR_NOT_FINITE, EMA_ERR_RANGE and EMA_ERR_ABSENT
 * (ema_actuator_check names the value); EMA_ERR_RANGE for a start outside the travel or a total feedback delay beyond
 * 12 steps; EMA_ERR_STIFF; EMA_ERR_INERTIA; EMA_ERR_RANGE for an anti-windup gain of two control periods or more, with
 * which the integrator swings up. Cost: about 20 model steps. On an error plant and state are unchanged. */
ema_status_t ema_model_init(ema_model_t* model, const ema_actuator_t* actuator, ema_real start_mm);

/* From now on the model, which must not be NULL, reads its learned tables from `actuator`, which must hold the same
 * ones and outlive it. Without a table that acts this does nothing. Cost: constant. */
void ema_model_learned(ema_model_t* model, const ema_actuator_t* actuator);

/* Puts the state back to the start. `model` must not be NULL. Cost: constant. */
void ema_model_restart(ema_model_t* model);

/* Makes one step with `command_mm` held over it; `output` may be NULL. The model must have been prepared.
 * Cost: fixed, except in a step with a reversal, break-away, saturation or end stop (at most EMA_EVENTS_MAX located
 * events). Errors: EMA_ERR_NULL; EMA_ERR_NOT_FINITE for the command, nothing changed; EMA_ERR_DIVERGED when the new
 * state is not finite. */
ema_status_t ema_model_step(ema_model_t* model, ema_real command_mm, ema_output_t* output);

#ifdef __cplusplus
}
#endif

#endif
