#include "ema_tick.h"

#include "ema_drive.h"
#include "ema_effect_sites.h"
#include "ema_encoder.h"
#include "ema_motion.h"
#include "ema_pid.h"

/* Current of a circuit without a time constant, from the instant on at which the drive applies its input. */
static void ema_tick_current(const ema_plant_t* plant, ema_state_t* state, const ema_drive_output_t* applied)
{
    const ema_circuit_t* const circuit = applied->current_loop ? &plant->current_loop : &plant->motor_circuit;
    if (circuit->algebraic) {
        state->current_A = ema_clamp((circuit->rate_speed * state->speed_rad_s) + (circuit->rate_voltage * applied->input), -plant->drive.current_limit_A,
                                     plant->drive.current_limit_A);
    }
}

/* The state as learned tables see it, at the motor's or at the rod's position. */
static ema_site_t ema_tick_site(const ema_plant_t* plant, const ema_state_t* state, ema_real position_mm)
{
    const ema_site_t site = {plant, state->speed_rad_s, state->angle_rad, position_mm, state->current_A, EMA_R(0.0)};
    return site;
}

/* What learned tables add to the rod sensor's reading; keeps how far tables are used outside the range that they were seen in. */
static ema_real ema_tick_learned(const ema_plant_t* plant, ema_state_t* state)
{
    const ema_site_t shaft = ema_tick_site(plant, state, state->motor_mm);
    const ema_site_t rod = ema_tick_site(plant, state, state->rod_mm);
    state->outside_ratio = ema_max(ema_site_outside(plant, &shaft, &rod), state->outside_ratio);
    return ema_site_reading(plant, &rod);
}

/* What was asked `age` steps ago. */
static ema_drive_output_t ema_tick_asked(const ema_plant_t* plant, const ema_state_t* state, uint32_t age)
{
    const ema_real output = state->delay_output[(state->step - age) & (EMA_DELAY_SAMPLES - 1U)];
    return ema_drive_step(&plant->drive, &plant->motor, output, state->current_A, state->speed_rad_s);
}

/* A drive that passes the output on with a delay: keeps the output, and what is applied at the start of the model step. */
static ema_drive_output_t ema_tick_late(const ema_plant_t* plant, ema_state_t* state, ema_real output)
{
    state->delay_output[state->step & (EMA_DELAY_SAMPLES - 1U)] = output;
    const bool parted = plant->drive.delay_part > EMA_R(0.0);
    return ema_tick_asked(plant, state, plant->drive.delay_steps + (parted ? 1U : 0U));
}

/* The model step under it: first what was asked before, then what was asked later. */
static void ema_tick_delayed(const ema_plant_t* plant, ema_state_t* state, const ema_drive_output_t* first)
{
    if (plant->drive.delay_part > EMA_R(0.0)) {
        ema_motion_part(plant, state, first, plant->drive.delay_part);
        const ema_drive_output_t second = ema_tick_asked(plant, state, plant->drive.delay_steps);
        ema_tick_current(plant, state, &second);
        ema_motion_part(plant, state, &second, EMA_R(1.0) - plant->drive.delay_part);
    } else {
        ema_motion_part(plant, state, first, EMA_R(1.0));
    }
}

void ema_tick(const ema_plant_t* plant, ema_state_t* state, ema_real command_mm, ema_output_t* row)
{
    row->position_mm = ema_encoder_rod(&plant->encoder, state->rod_mm);
    if (ema_acts_by_table(plant)) {
        row->position_mm += ema_tick_learned(plant, state);
    }
    row->motor_position_mm = state->motor_mm;
    const ema_real feedback_mm = ema_encoder_step(&plant->encoder, state, state->motor_mm, row->position_mm);
    const ema_real output = ema_pid_step(&plant->pid, state, command_mm, feedback_mm);
    ema_drive_output_t applied = ema_drive_step(&plant->drive, &plant->motor, output, state->current_A, state->speed_rad_s);
    row->voltage_V = applied.voltage_V;
    if (plant->drive.delayed) {
        applied = ema_tick_late(plant, state, output);
    }
    ema_tick_current(plant, state, &applied);
    row->current_A = state->current_A;
    const bool carried = ((ema_real)state->play_side * state->speed_rad_s) > EMA_R(0.0);
    row->speed_mm_s = carried ? (plant->gearbox.lead_mm_per_rad * state->speed_rad_s) : EMA_R(0.0);
    if (ema_acts(plant, EMA_SITE_TRANSMISSION)) {
        row->speed_mm_s = state->rod_speed_mm_s;
    }
    if (plant->drive.delayed) {
        ema_tick_delayed(plant, state, &applied);
    } else {
        ema_motion_step(plant, state, &applied);
    }
    ema_motion_arrive(plant, state);
    ++state->step;
}
