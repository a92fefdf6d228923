/* The order of the six blocks inside one model step: the only place that knows it. Inlined into the loops that run the model. */
#ifndef EMA_TICK_H
#define EMA_TICK_H

#include "ema_drive.h"
#include "ema_encoder.h"
#include "ema_motion.h"
#include "ema_pid.h"

/* Current of a circuit without a time constant, from the instant on at which the drive applies its input. */
static inline void ema_tick_current(const ema_plant_t* plant, ema_state_t* state, const ema_drive_output_t* applied)
{
    const ema_circuit_t* const circuit = applied->current_loop ? &plant->current_loop : &plant->motor_circuit;
    if (circuit->algebraic) {
        state->current_A = ema_clamp((circuit->rate_speed * state->speed_rad_s) + (circuit->rate_voltage * applied->input), -plant->drive.current_limit_A,
                                     plant->drive.current_limit_A);
    }
}

/* A drive that passes the output on with a delay: keeps the output, and what is applied at the start of the model step. */
ema_drive_output_t ema_tick_late(const ema_plant_t* plant, ema_state_t* state, ema_real output);

/* The model step under it: first what was asked before, then what was asked later. */
void ema_tick_delayed(const ema_plant_t* plant, ema_state_t* state, const ema_drive_output_t* first);

/* What learned tables add to the rod sensor's reading; keeps how far tables are used outside the range that they were seen in. */
ema_real ema_tick_learned(const ema_plant_t* plant, ema_state_t* state);

static inline ema_output_t ema_tick(const ema_plant_t* plant, ema_state_t* state, ema_real command_mm)
{
    ema_output_t row;
    row.position_mm = ema_encoder_rod(&plant->encoder, state->rod_mm);
    if (plant->active.tables != 0U) {
        row.position_mm += ema_tick_learned(plant, state);
    }
    row.motor_position_mm = state->motor_mm;
    const ema_real feedback_mm = ema_encoder_step(&plant->encoder, state, state->motor_mm, row.position_mm);
    const ema_real output = ema_pid_step(&plant->pid, state, command_mm, feedback_mm);
    const ema_drive_output_t applied = ema_drive_step(&plant->drive, &plant->motor, output, state->current_A, state->speed_rad_s);
    const ema_drive_output_t first = plant->drive.delayed ? ema_tick_late(plant, state, output) : applied;
    ema_tick_current(plant, state, &first);
    row.current_A = state->current_A;
    row.voltage_V = applied.voltage_V;
    const bool carried = ((ema_real)state->play_side * state->speed_rad_s) > EMA_R(0.0);
    row.speed_mm_s = carried ? (plant->gearbox.lead_mm_per_rad * state->speed_rad_s) : EMA_R(0.0);
    if (plant->active.transmission != 0U) {
        row.speed_mm_s = state->rod_speed_mm_s;
    }
    if (plant->drive.delayed) {
        ema_tick_delayed(plant, state, &first);
    } else {
        ema_motion_step(plant, state, &first);
    }
    ema_motion_arrive(plant, state);
    ++state->step;
    return row;
}

#endif
