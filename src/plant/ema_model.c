#include "ema/ema_model.h"

#include "base/ema_math.h"
#include "effects/ema_effect_sites.h"
#include "plant/ema_prepare.h"
#include "plant/ema_tick.h"

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
