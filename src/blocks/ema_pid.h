/* Block 1: PID control logic. Equations: docs/DESIGN.md, "PID control logic". */
#ifndef EMA_PID_H
#define EMA_PID_H

#include "base/ema_choice.h"
#include "base/ema_math.h"
#include "ema/detail/ema_plant.h"

void ema_pid_prepare(ema_pid_t* pid, const ema_params_t* params, const ema_options_t* options);

/* The control law in its general form: cascade, derivative action. */
ema_real ema_pid_general(const ema_pid_t* pid, ema_state_t* state, ema_real error_m, ema_real feedback_mm);

/* Output of the control law for the command and the feedback at this step; holds between control instants. */
static inline ema_real ema_pid_step(const ema_pid_t* pid, ema_state_t* state, ema_real command_mm, ema_real feedback_mm)
{
    if ((pid->every_steps > 1U) && ((state->step % pid->every_steps) != 0U)) {
        return state->output;
    }
    const ema_real error_m = (command_mm - feedback_mm) * EMA_R(1.0e-3);
    if ((EMA_ONLY_PI == 0) && !pid->plain) {
        state->output = ema_pid_general(pid, state, error_m, feedback_mm);
        return state->output;
    }
    const ema_real raw = (pid->gain * error_m) + state->integral;
    const ema_real output = ema_min(ema_max(raw, -pid->output_limit), pid->output_limit);
    state->integral += pid->period_s * ((pid->integral_gain * error_m) + (pid->anti_windup_per_s * (output - raw)));
    state->output = output;
    return output;
}

#endif
