/* Each block and each effect with parameters anywhere in their ranges and a state anywhere in the box below: every
 * number stays finite.
 *
 * The box is where a motion of an actuator within its ranges can be; its sizes are far beyond what the ranges' own
 * quotients give (2000 V over 0.07 mOhm is 3e7 A). What one block is given here is what the one before it is asserted
 * to give. Of what ema_plant_check refuses, the analysis is told what it cannot see by itself: a time constant is none
 * or at least the shortest step over 64 integration steps of reach 1.7 each. */
#include "states.h"

#include "blocks/ema_drive.h"
#include "blocks/ema_encoder.h"
#include "blocks/ema_mechanics.h"
#include "blocks/ema_pid.h"
#include "effects/ema_effect_sites.h"
#include "effects/ema_table.h"
#include "plant/ema_motion.h"

#define EMA_BOX_CURRENT_A 1.0e8f
#define EMA_BOX_SPEED_RAD_S 1.0e8f
#define EMA_BOX_ANGLE_RAD 1.0e10f
#define EMA_BOX_POSITION_MM 2.0e4f
#define EMA_BOX_INTEGRAL 1.0e15f
#define EMA_BOX_SHORTEST_S 9.0e-8f
#define EMA_BOX_INERTIA_KGM2 5.0e-11f
#define EMA_BOX_SMALLEST 1.0e-28f
#define EMA_BOX_STRETCH_RAD 1.0e-25f
#define EMA_BOX_PERIOD_S 1.0e-8f

static ema_params_t params;
static ema_options_t options;
static ema_effects_t effects;
static ema_plant_t plant;
static ema_state_t state;
static ema_step_scratch_t work;

static ema_real ema_within(ema_real size)
{
    return Frama_C_float_interval(-size, size);
}

/* Every parameter, option and value of an effect, anywhere in its range. */
static void ema_any_values(void)
{
#define EMA_PARAM(section, field, nominal, lower, upper, text)                                                         \
    params.field = Frama_C_float_interval(lower##f, upper##f);
#define EMA_OPTION(section, field, nominal, lower, upper, choices, text) options.field = Frama_C_interval(lower, upper);
#include "ema/ema_params.def"
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters)                            \
    {                                                                                                                  \
        ema_effect_##name##_t* const effect = &effects.name;                                                           \
        parameters                                                                                                     \
    }
#define EMA_P(field, nominal, lower, upper, text) effect->field = Frama_C_float_interval(lower##f, upper##f);
#include "ema/ema_effects.def"
}

static void ema_any_state(void)
{
    state.current_A = ema_within(EMA_BOX_CURRENT_A);
    state.speed_rad_s = ema_within(EMA_BOX_SPEED_RAD_S);
    state.angle_rad = ema_within(EMA_BOX_ANGLE_RAD);
    state.angle_low_rad = ema_within(EMA_BOX_ANGLE_RAD);
    state.motor_mm = ema_within(EMA_BOX_POSITION_MM);
    state.play_mm = ema_within(EMA_BOX_POSITION_MM);
    state.rod_mm = ema_within(EMA_BOX_POSITION_MM);
    state.integral = ema_within(EMA_BOX_INTEGRAL);
    state.previous_feedback_mm = ema_within(EMA_BOX_POSITION_MM);
    state.previous_measure_mm = ema_within(EMA_BOX_POSITION_MM);
    state.previous_error_m = ema_within(EMA_BOX_POSITION_MM);
    state.output = ema_within(1.0f);
    for (uint32_t k = 0; k < EMA_DELAY_SAMPLES; ++k) {
        state.delay_mm[k] = ema_within(EMA_BOX_POSITION_MM);
        state.delay_output[k] = ema_within(1.0f);
    }
    state.effect_memory[0] = ema_within(EMA_BOX_POSITION_MM);
    state.effect_memory[1] = ema_within(1.0e7f);
    state.effect_memory[2] = ema_within(1.0f);
    state.step = (uint32_t)Frama_C_unsigned_int_interval(0U, 0xffffffffU);
    state.motion = Frama_C_interval(EMA_MOTION_BACKWARD, EMA_MOTION_ELASTIC);
}

static void ema_prepare_blocks(void)
{
    /* none, or no smaller than numbers whose quotients fit */
    params.resolution_mm = (Frama_C_interval(0, 1) != 0) ? 0.0f : Frama_C_float_interval(EMA_BOX_SMALLEST, 10.0f);
    effects.presliding.stretch_rad = Frama_C_float_interval(EMA_BOX_STRETCH_RAD, 1.0f);
    effects.transmission_compliance.period_s = Frama_C_float_interval(EMA_BOX_PERIOD_S, 0.2f);
    ema_effects_adjust(&effects, &params);
    if (!(params.inertia_kgm2 > EMA_BOX_INERTIA_KGM2)) {
        ema_leave();
    }
    ema_pid_prepare(&plant.pid, &params, &options);
    ema_drive_prepare(&plant.drive, &params, &options);
    ema_motor_prepare(&plant.motor, &params);
    ema_gearbox_prepare(&plant.gearbox, &params);
    ema_screw_prepare(&plant.screw, &plant.gearbox, &params);
    ema_encoder_prepare(&plant.encoder, &params, &options);
    plant.torque_limit_A = plant.motor.torque_limit_Nm / plant.motor.torque_constant_Nm_per_A;
    plant.linear_current_A = ema_min(plant.drive.current_limit_A, plant.torque_limit_A);
    ema_effects_hold(&plant, &effects);
    plant.learned = &effects;
}

/* Encoder, control law, drive. */
static void ema_block_control(void)
{
    const ema_real command_mm = ema_within(EMA_BOX_POSITION_MM);
    const ema_real reading_mm = ema_encoder_rod(&plant.encoder, state.rod_mm) + ema_within(4000.0f);
    ema_real feedback_mm = ema_encoder_step(&plant.encoder, &state, state.motor_mm, reading_mm);
    /* rounding moves it by the resolution at most, which no interval of a product shows */
    feedback_mm = ema_within(3.0e5f);
    const ema_real output = ema_pid_step(&plant.pid, &state, command_mm, feedback_mm);
    //@ assert output: -1.0 <= output <= 1.0;
    plant.drive.loop_s = (Frama_C_interval(0, 1) != 0) ? 0.0f : Frama_C_float_interval(EMA_BOX_SHORTEST_S, 1.0f);
    ema_drive_step(&plant.drive, &plant.motor, output, state.current_A, state.speed_rad_s, &work.applied);
    //@ assert input: -5000.0 <= work.applied.input <= 5000.0;
}

/* Loads, friction and every effect, at rest and in motion. */
static void ema_block_forces(void)
{
    const ema_point_t point = {ema_within(EMA_BOX_CURRENT_A), ema_within(EMA_BOX_SPEED_RAD_S),
                               ema_within(EMA_BOX_ANGLE_RAD)};
    const ema_drive_output_t applied = {ema_within(5000.0f), ema_within(1.0e20f), Frama_C_interval(0, 1) != 0};
    work.applied = applied;
    ema_forces_at(&plant, &state, &work, &point);
    //@ assert torque: -1.0e17 <= work.forces.torque_Nm <= 1.0e17;
    //@ assert input: -2.0e14 <= work.forces.input <= 2.0e14;
    //@ assert level: 0.0 <= work.forces.level_forward_Nm <= 1.0e17 && 0.0 <= work.forces.level_backward_Nm <= 1.0e17;
}

/* Play, ends of travel and what lies behind the play. */
static void ema_block_rod(void)
{
    ema_screw_play(&plant.screw, &state, ema_within(EMA_BOX_POSITION_MM));
    //@ assert play: -2.1e4 <= state.play_mm <= 2.1e4;
    const ema_transmission_t step = {ema_within(EMA_BOX_POSITION_MM), state.play_mm,
                                     Frama_C_float_interval(1.0e-7f, 2.0e-2f), plant.gearbox.lead_mm_per_rad};
    ema_site_transmission(&plant, &step, state.effect_memory, &work.rod);
    const ema_real share = ema_site_presliding(&plant, state.effect_memory, ema_within(EMA_BOX_ANGLE_RAD));
    const ema_site_t site = {&plant, 0.0f, state.angle_rad, state.rod_mm, state.current_A, 0.0f};
    const ema_real reading_mm = ema_site_reading(&plant, &site);
    //@ assert reading: -4000.0 <= reading_mm <= 4000.0;
}

void main(void)
{
    ema_any_values();
    ema_any_state();
    ema_prepare_blocks();
    plant.active.sites = (uint16_t)Frama_C_unsigned_int_interval(0U, 0xffffU);
    for (uint32_t word = 0; word < EMA_EFFECT_WORDS; ++word) {
        plant.active.present[word] = Frama_C_unsigned_int_interval(0U, 0xffffffffU);
    }
    switch (Frama_C_interval(0, 2)) {
    case 0:
        ema_block_control();
        break;
    case 1:
        ema_block_forces();
        break;
    default:
        ema_block_rod();
        break;
    }
    Frama_C_show_each_end();
}
