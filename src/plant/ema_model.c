#include "ema/ema_model.h"

#include "base/ema_compiler.h"
#include "base/ema_copy.h"
#include "base/ema_math.h"
#include "blocks/ema_drive.h"
#include "blocks/ema_encoder.h"
#include "blocks/ema_limits.h"
#include "blocks/ema_mechanics.h"
#include "blocks/ema_pid.h"
#include "effects/ema_effect_sites.h"
#include "plant/ema_run.h"
#include "plant/ema_series.h"

void ema_model_learned(ema_model_t* model, const ema_actuator_t* actuator)
{
    ema_plant_learned(&model->plant, actuator);
}

void ema_model_restart(ema_model_t* model)
{
    ema_state_rest(&model->state, &model->plant);
}

ema_status_t ema_model_init(ema_model_t* model, const ema_actuator_t* actuator, ema_real start_mm)
{
    if ((model == NULL) || (actuator == NULL)) {
        return EMA_ERR_NULL;
    }
    return ema_run_prepare(&model->plant, &model->state, &model->work, actuator, start_mm);
}

/* Speed of the rod: zero while it rests in the play. */
static ema_real ema_rod_speed(const ema_plant_t* plant, const ema_state_t* state)
{
    const bool carried = ((ema_real)state->play_side * state->speed_rad_s) > EMA_R(0.0);
    const ema_real speed_mm_s = carried ? (plant->gearbox.lead_mm_per_rad * state->speed_rad_s) : EMA_R(0.0);
    return ema_acts(plant, EMA_SITE_TRANSMISSION) ? state->rod_speed_mm_s : speed_mm_s;
}

ema_status_t ema_model_step(ema_model_t* model, ema_real command_mm, ema_output_t* output)
{
    if (model == NULL) {
        return EMA_ERR_NULL;
    }
    if (!ema_is_finite(command_mm)) {
        return EMA_ERR_NOT_FINITE;
    }
    ema_output_t row;
    ema_output_t* const shown = (output != NULL) ? output : &row;
    shown->speed_mm_s = ema_rod_speed(&model->plant, &model->state);
    ema_tick(&model->plant, &model->state, &model->work, command_mm, shown);
    /* the play and the limits of the output swallow NaN, so that rod and voltage alone do not tell */
    const ema_state_t* const state = &model->state;
    /* zero of a finite number, NaN of any other */
    const ema_real none = (state->current_A - state->current_A) + (state->speed_rad_s - state->speed_rad_s)
                          + (state->motor_mm - state->motor_mm) + (state->rod_mm - state->rod_mm)
                          + (state->integral - state->integral);
    return (none == EMA_R(0.0)) ? EMA_OK : EMA_ERR_DIVERGED;
}

/* Most integration steps in a model step; a plant that needs more has a time constant that should be set to zero. */
#define EMA_SUBSTEPS_MAX 64U

/* Model steps in a period of a rod behind a compliance from which on one integration step follows it. */
#define EMA_STEPS_OF_A_SWING EMA_R(8.0)

/* Back-calculation gain times control period from which on the integrator swings up. */
#define EMA_ANTI_WINDUP_MAX EMA_R(2.0)

/* One electrical law without its responses. */
static void ema_circuit_set(ema_circuit_t* circuit, ema_real time_constant_s, ema_real speed_per_input, ema_real gain)
{
    ema_clear(circuit, sizeof *circuit);
    if (time_constant_s > EMA_R(0.0)) {
        circuit->rate_current = EMA_R(-1.0) / time_constant_s;
        circuit->rate_voltage = gain / time_constant_s;
    } else {
        circuit->algebraic = true;
        circuit->rate_voltage = gain;
    }
    circuit->rate_speed = -speed_per_input * circuit->rate_voltage;
}

/* Sum of the rates of the linear plant with that law: a bound of its fastest motion. */
static ema_real ema_fastest_per_s(const ema_params_t* params, ema_real time_constant_s, ema_real speed_per_input,
                                  ema_real gain)
{
    const bool lags = time_constant_s > EMA_R(0.0);
    const ema_real inverse_inertia_per_kgm2 = EMA_R(1.0) / params->inertia_kgm2;
    const ema_real drag = params->viscous_Nm_s_per_rad * inverse_inertia_per_kgm2;
    const ema_real rate_speed = -speed_per_input * (lags ? (gain / time_constant_s) : gain);
    const ema_real coupling = ema_abs(params->torque_constant_Nm_per_A * rate_speed) * inverse_inertia_per_kgm2;
    return lags ? (drag + ema_sqrt(coupling) - (EMA_R(-1.0) / time_constant_s)) : (drag + coupling);
}

/* Integration steps in a model step that the plant itself needs. */
static ema_real ema_substeps_needed(const ema_params_t* params, const ema_options_t* options)
{
    ema_real fastest_per_s = ema_fastest_per_s(params, params->inductance_H / params->resistance_ohm,
                                               params->back_emf_V_s_per_rad, EMA_R(1.0) / params->resistance_ohm);
    if ((EMA_ONLY_VOLTAGE == 0) && (options->mode == 1)) {
        const ema_real loop_per_s = ema_fastest_per_s(params, params->current_loop_s, EMA_R(0.0), EMA_R(1.0));
        /* an ideal drive never applies the bus voltage itself */
        fastest_per_s = (params->current_loop_s > EMA_R(0.0)) ? ema_max(fastest_per_s, loop_per_s) : loop_per_s;
    }
    return (fastest_per_s * params->step_s) / EMA_SERIES_REACH;
}

/* Whether the samples that are kept suffice for what is late. */
static bool ema_delays_fit(const ema_params_t* params)
{
    bool fit = true;
#if !EMA_ONLY_EXACT
    fit = (params->delay_s / params->step_s) <= EMA_DELAY_STEPS_MAX;
#endif
#if !EMA_ONLY_VOLTAGE
    fit = fit && ((params->output_delay_s / params->step_s) <= EMA_DELAY_STEPS_MAX);
#endif
    (void)params;
    return fit;
}

/* Why no model can be made of parameters as the effects leave them. */
static ema_status_t ema_plant_check(const ema_params_t* params, const ema_options_t* options, ema_real inertia_kgm2,
                                    ema_real start_mm)
{
    ema_status_t status = EMA_OK;
    if ((EMA_SITES_HELD != 0) && !ema_choice_fits(params, options)) {
        /* an effect has asked for it */
        status = EMA_ERR_ABSENT;
    } else if (!(ema_abs(start_mm) <= params->travel_mm) || !ema_delays_fit(params) || !(params->supply_V > EMA_R(0.0))
               || !(params->viscous_Nm_s_per_rad >= EMA_R(0.0))
               || !((params->anti_windup_per_s * params->step_s * (ema_real)options->every_steps) < EMA_ANTI_WINDUP_MAX)
               || !(params->resistance_ohm > EMA_R(0.0)) || !(ema_abs(params->friction_asymmetry) <= EMA_R(1.0))) {
        status = EMA_ERR_RANGE;
    } else if (!(params->inertia_kgm2 > (EMA_R(0.05) * inertia_kgm2))) {
        status = EMA_ERR_INERTIA;
    } else if (!(ema_substeps_needed(params, options) <= (ema_real)EMA_SUBSTEPS_MAX)) {
        status = EMA_ERR_STIFF;
    } else {
        /* a plant that can be prepared */
    }
    return status;
}

static void ema_motion_prepare(ema_plant_t* plant, const ema_params_t* params, const ema_options_t* options)
{
    /* checked already: the bound says so where it is converted */
    const ema_real needed = ema_clamp(ema_substeps_needed(params, options), EMA_R(0.0), (ema_real)EMA_SUBSTEPS_MAX);
    plant->substeps = (uint8_t)((uint32_t)needed + ((needed > ema_floor(needed)) ? 1U : 0U));
    const uint32_t wanted = (options->substeps > 0) ? (uint32_t)options->substeps : plant->active.substeps;
    /* what is late is tried part by part, whether effects ask for it or not */
    /* a rod that swings within few steps is not followed by one that takes its play and its reaction for even */
    const bool swings =
        ema_acts(plant, EMA_SITE_TRANSMISSION)
        && !(plant->effects.transmission_compliance.period_s >= (EMA_STEPS_OF_A_SWING * params->step_s));
    plant->tries_whole_step =
        (plant->substeps == 1U) && (options->substeps == 0)
        && (ema_drive_delays(&plant->drive) || ((EMA_SITES_HELD != 0) && (wanted > 1U) && !swings));
    if (plant->substeps < wanted) {
        plant->substeps = (uint8_t)wanted;
    }
    plant->step_s = params->step_s;
    plant->substep_s = params->step_s / (ema_real)plant->substeps;
    plant->torque_limit_A = plant->motor.torque_limit_Nm / plant->motor.torque_constant_Nm_per_A;
    plant->linear_current_A = ema_min(plant->drive.current_limit_A, plant->torque_limit_A);
    ema_circuit_set(&plant->motor_circuit, params->inductance_H / params->resistance_ohm, params->back_emf_V_s_per_rad,
                    EMA_R(1.0) / params->resistance_ohm);
#if !EMA_ONLY_VOLTAGE
    ema_circuit_set(&plant->current_loop, params->current_loop_s, EMA_R(0.0), EMA_R(1.0));
#endif
    plant->warming_ahead_ratio = ema_acts_by_warmth(plant) ? ema_site_ahead(plant) : EMA_R(0.0);
}

EMA_NOINLINE ema_status_t ema_plant_prepare(ema_plant_t* plant, ema_step_scratch_t* work,
                                            const ema_actuator_t* actuator, ema_real start_mm)
{
    ema_params_t* const params = &work->params;
    const ema_options_t* const options = &actuator->options;
    ema_copy(params, &actuator->params, sizeof *params);
    ema_effects_adjust(&actuator->effects, params);
    const ema_status_t status = ema_plant_check(params, options, actuator->params.inertia_kgm2, start_mm);
    if (status == EMA_OK) {
        plant->start_mm = start_mm;
        ema_effects_hold(plant, &actuator->effects);
        ema_pid_prepare(&plant->pid, params, options);
        ema_drive_prepare(&plant->drive, params, options);
        ema_motor_prepare(&plant->motor, params);
        ema_gearbox_prepare(&plant->gearbox, params);
        ema_screw_prepare(&plant->screw, &plant->gearbox, params);
        ema_encoder_prepare(&plant->encoder, params, options);
        ema_motion_prepare(plant, params, options);
    }
    return status;
}

/* The responses that this plant's drive and effects use. */
static void ema_responses_all(ema_plant_t* plant, ema_step_scratch_t* work)
{
    ema_real first_s = plant->substep_s;
    ema_real second_s = plant->step_s;
    work->circuit = ema_drive_regulates(&plant->drive) ? &plant->current_loop : &plant->motor_circuit;
    if (ema_tries_whole(plant) && ema_drive_delays(&plant->drive)) {
        first_s = plant->drive.delay_part * plant->step_s;
        second_s = plant->step_s - first_s;
    }
    ema_responses_prepare(&plant->responses[0], plant, work, first_s);
    if (!ema_tries_whole(plant)) {
        second_s = plant->substep_s;
        work->circuit = &plant->motor_circuit;
    }
    if (ema_tries_whole(plant) || ema_drive_regulates(&plant->drive)) {
        ema_responses_prepare(&plant->responses[1], plant, work, second_s);
    }
}

void ema_plant_learned(ema_plant_t* plant, const ema_actuator_t* actuator)
{
    if (plant->learned != NULL) {
        plant->learned = &actuator->effects;
    }
}

void ema_state_rest(ema_state_t* state, const ema_plant_t* plant)
{
    ema_clear(state, sizeof *state);
    state->motion = ema_acts(plant, EMA_SITE_PRESLIDING) ? (int32_t)EMA_MOTION_ELASTIC : (int32_t)EMA_MOTION_STUCK;
    state->angle_rad = plant->start_mm / plant->gearbox.lead_mm_per_rad;
    state->motor_mm = plant->start_mm;
    state->play_mm = plant->start_mm;
    state->rod_mm = plant->start_mm;
#if !EMA_ONLY_EXACT
    const ema_site_t site = {.plant = plant,
                             .speed_rad_s = state->speed_rad_s,
                             .angle_rad = state->angle_rad,
                             .position_mm = plant->start_mm,
                             .current_A = state->current_A};
    const ema_real rod_mm = ema_encoder_rod(&plant->encoder, plant->start_mm)
                            + (ema_acts(plant, EMA_SITE_READING) ? ema_site_reading(plant, &site) : EMA_R(0.0));
    const ema_real seen_mm = plant->encoder.at_rod ? rod_mm : plant->start_mm;
    for (uint32_t k = 0; k < EMA_DELAY_SAMPLES; ++k) {
        state->delay_mm[k] = seen_mm;
    }
#endif
}

EMA_NOINLINE ema_status_t ema_run_prepare(ema_plant_t* plant, ema_state_t* state, ema_step_scratch_t* work,
                                          const ema_actuator_t* actuator, ema_real start_mm)
{
    ema_status_t status = ema_is_finite(start_mm) ? ema_actuator_check(actuator, NULL) : EMA_ERR_NOT_FINITE;
    if (status == EMA_OK) {
        status = ema_plant_prepare(plant, work, actuator, start_mm);
    }
    if (status == EMA_OK) {
        ema_responses_all(plant, work);
        ema_state_rest(state, plant);
    }
    return status;
}
