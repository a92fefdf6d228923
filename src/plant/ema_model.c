#include "ema/ema_model.h"

#include "ema_effect_sites.h"
#include "ema_encoder.h"
#include "ema_prepare.h"
#include "ema_series.h"
#include "ema_tick.h"

/* The responses that this plant's drive and effects use. */
static void ema_circuits_prepare(ema_plant_t* plant)
{
    ema_circuit_prepare(&plant->motor_circuit, plant, plant->substep_s);
    if (plant->drive.current_mode) {
        ema_circuit_prepare(&plant->current_loop, plant, plant->substep_s);
    }
    if (plant->tries_whole_step) {
        ema_circuit_prepare(&plant->whole_step, plant, plant->step_s);
    }
}

void ema_model_learned(ema_model_t* model, const ema_actuator_t* actuator)
{
    if (model->plant.learned != NULL) {
        model->plant.learned = &actuator->effects;
    }
}

void ema_model_restart(ema_model_t* model)
{
    const ema_plant_t* const plant = &model->plant;
    const ema_state_t rest = {0};
    ema_state_t* const state = &model->state;
    *state = rest;
    state->motion = ema_acts(plant, EMA_SITE_PRESLIDING) ? (int32_t)EMA_MOTION_ELASTIC : (int32_t)EMA_MOTION_STUCK;
    state->angle_rad = plant->start_mm / plant->gearbox.lead_mm_per_rad;
    state->motor_mm = plant->start_mm;
    state->play_mm = plant->start_mm;
    state->rod_mm = plant->start_mm;
    const ema_site_t site = {plant, state->speed_rad_s, state->angle_rad, plant->start_mm, state->current_A, EMA_R(0.0)};
    const ema_real rod_mm = ema_encoder_rod(&plant->encoder, plant->start_mm) + (ema_acts(plant, EMA_SITE_READING) ? ema_site_reading(plant, &site) : EMA_R(0.0));
    const ema_real seen_mm = plant->encoder.at_rod ? rod_mm : plant->start_mm;
    for (uint32_t k = 0; k < EMA_DELAY_SAMPLES; ++k) {
        state->delay_mm[k] = seen_mm;
    }
}

ema_status_t ema_model_init(ema_model_t* model, const ema_actuator_t* actuator, ema_real start_mm)
{
    if ((model == NULL) || (actuator == NULL)) {
        return EMA_ERR_NULL;
    }
    if (!ema_is_finite(start_mm)) {
        return EMA_ERR_NOT_FINITE;
    }
    ema_status_t status = ema_actuator_check(actuator, NULL);
    if (status == EMA_OK) {
        status = ema_plant_prepare(&model->plant, actuator, start_mm);
    }
    if (status == EMA_OK) {
        ema_circuits_prepare(&model->plant);
        ema_model_restart(model);
    }
    return status;
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
    ema_tick(&model->plant, &model->state, command_mm, shown);
    /* the play and the limits of the output swallow NaN, so that rod and voltage alone do not tell */
    const ema_state_t* const state = &model->state;
    const bool finite = ema_is_finite(state->current_A) && ema_is_finite(state->speed_rad_s) && ema_is_finite(state->motor_mm) && ema_is_finite(state->rod_mm)
                        && ema_is_finite(state->integral);
    return finite ? EMA_OK : EMA_ERR_DIVERGED;
}
