#include "blocks/ema_drive.h"

#include "blocks/ema_limits.h"

void ema_drive_prepare(ema_drive_t* drive, const ema_params_t* params, const ema_options_t* options)
{
    drive->supply_V = params->supply_V;
    drive->current_limit_A = ema_limit_or_none(params->current_limit_A);
#if EMA_ONLY_VOLTAGE
    (void)options;
    drive->current_mode = false;
    drive->delayed = false;
#else
    drive->current_mode = options->mode == 1;
    drive->current_scale_A = params->current_scale_A;
    drive->command_scale_V = params->command_scale_V;
    drive->loop_s = params->current_loop_s;
    /* checked already: the bound says so where it is converted */
    const ema_real steps = ema_min(params->output_delay_s / params->step_s, EMA_DELAY_STEPS_MAX);
    drive->delayed = params->output_delay_s > EMA_R(0.0);
    drive->delay_steps = (uint16_t)steps;
    drive->delay_part = steps - (ema_real)drive->delay_steps;
#endif
}

void ema_drive_current_mode(const ema_drive_t* drive, const ema_motor_t* motor, ema_real output, ema_real current_A,
                            ema_real speed_rad_s, ema_drive_output_t* applied)
{
    const ema_real reference_A =
        ema_clamp(output * drive->current_scale_A, -drive->current_limit_A, drive->current_limit_A);
    const ema_real emf_V = motor->back_emf_V_s_per_rad * speed_rad_s;
    ema_real needed_V = (motor->resistance_ohm * reference_A) + emf_V;
    applied->input = reference_A;
    applied->current_loop = true;
    if (drive->loop_s > EMA_R(0.0)) {
        needed_V = (motor->resistance_ohm * current_A)
                   + (motor->inductance_H * ((reference_A - current_A) / drive->loop_s)) + emf_V;
        if (ema_abs(needed_V) > drive->supply_V) {
            needed_V = (needed_V > EMA_R(0.0)) ? drive->supply_V : -drive->supply_V;
            applied->input = needed_V;
            applied->current_loop = false;
        }
    }
    applied->voltage_V = (drive->command_scale_V > EMA_R(0.0)) ? (output * drive->command_scale_V) : needed_V;
}

void ema_drive_late(const ema_plant_t* plant, const ema_state_t* state, uint32_t age, ema_drive_output_t* applied)
{
    const ema_real output = state->delay_output[(state->step - age) & (EMA_DELAY_SAMPLES - 1U)];
    ema_drive_step(&plant->drive, &plant->motor, output, state->current_A, state->speed_rad_s, applied);
}

ema_real ema_circuit_follow(const ema_plant_t* plant, const ema_circuit_t* circuit, const ema_state_t* state,
                            ema_real input)
{
    const ema_real limit_A = plant->drive.current_limit_A;
    return ema_clamp((circuit->rate_speed * state->speed_rad_s) + (circuit->rate_voltage * input), -limit_A, limit_A);
}
