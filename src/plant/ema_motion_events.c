/* An integration step with its events, one after the other: find the next, move to it, let it happen. Apart from
 * ema_motion.c so that a step without events needs none of its stack. */
#include "base/ema_math.h"
#include "blocks/ema_motor.h"
#include "effects/ema_effect_sites.h"
#include "plant/ema_events.h"
#include "plant/ema_motion.h"

/* The speed is zero: dry friction holds the shaft, or it reverses at once. */
static void ema_motion_rest(const ema_plant_t* plant, ema_state_t* state, ema_step_scratch_t* work)
{
    /* a turning point beyond a stop is the stop */
    if (state->angle_rad > plant->screw.stop_upper_rad) {
        state->angle_rad = plant->screw.stop_upper_rad;
        state->angle_low_rad = EMA_R(0.0);
    } else if (state->angle_rad < plant->screw.stop_lower_rad) {
        state->angle_rad = plant->screw.stop_lower_rad;
        state->angle_low_rad = EMA_R(0.0);
    } else {
        /* inside the travel */
    }
    /* a turning point is the extreme that the play sees */
    ema_screw_play_keep(&plant->screw, state, plant->gearbox.lead_mm_per_rad * state->angle_rad);
    state->speed_rad_s = EMA_R(0.0);
    state->motion = (int32_t)EMA_MOTION_STUCK;
    const ema_forces_t* const forces = &work->forces;
    ema_point_t* const here = &work->segment.start;
    here->current_A = state->current_A;
    here->speed_rad_s = EMA_R(0.0);
    here->angle_rad = state->angle_rad;
    work->spent += EMA_WORK_FORCES;
    ema_forces_at(plant, state, work, here);
    const ema_real torque_Nm = forces->torque_Nm + ema_motor_torque(&plant->motor, state->current_A);
    state->motion = (int32_t)ema_screw_break_away(&plant->screw, state->angle_rad, torque_Nm, forces->level_forward_Nm,
                                                  forces->level_backward_Nm);
}

/* How a shaft moves once it has left its rest. */
static int32_t ema_motion_left(const ema_plant_t* plant, ema_motion_t direction)
{
    return ema_acts(plant, EMA_SITE_PRESLIDING) ? (int32_t)EMA_MOTION_ELASTIC : (int32_t)direction;
}

static void ema_event_apply(const ema_plant_t* plant, ema_state_t* state, ema_step_scratch_t* work)
{
    const ema_event_t* const event = &work->event;
    switch (event->kind) {
    case EMA_EVENT_REST:
        ema_motion_rest(plant, state, work);
        break;
    case EMA_EVENT_STOP:
        state->angle_rad = event->value;
        state->angle_low_rad = EMA_R(0.0);
        state->speed_rad_s = EMA_R(0.0);
        state->motion = (int32_t)EMA_MOTION_STUCK;
        break;
    case EMA_EVENT_CURRENT:
        state->current_A = event->value;
        break;
    case EMA_EVENT_FORWARD:
        state->motion = ema_motion_left(plant, EMA_MOTION_FORWARD);
        break;
    case EMA_EVENT_BACKWARD:
        state->motion = ema_motion_left(plant, EMA_MOTION_BACKWARD);
        break;
    case EMA_EVENT_RELEASE:
    case EMA_EVENT_NONE:
    default:
        break;
    }
}

void ema_motion_rod(const ema_plant_t* plant, ema_state_t* state, ema_step_scratch_t* work, ema_real play_start_mm,
                    ema_real span_s)
{
    ema_screw_play_keep(&plant->screw, state, plant->gearbox.lead_mm_per_rad * state->angle_rad);
    const ema_transmission_t step = {play_start_mm, state->play_mm, span_s, plant->gearbox.lead_mm_per_rad};
    ema_site_transmission(plant, &step, state->effect_memory, &work->rod);
    state->rod_mm = work->rod.rod_mm;
    state->rod_speed_mm_s = work->rod.rod_speed_mm_s;
}

void ema_motion_events(const ema_plant_t* plant, ema_state_t* state, ema_step_scratch_t* work)
{
    ema_event_t* const event = &work->event;
    const ema_real play_start_mm = state->play_mm;
    const ema_real span_s = work->span_s;
    uint32_t events = 0U;
    bool done = false;
    event->kind = EMA_EVENT_NONE;
    work->regime.held = false;
    work->regime.saturated_Nm = EMA_R(0.0);
    while (!done && (events < EMA_EVENTS_MAX)) {
        ema_segment_open(plant, state, work);
        ema_regime_update(plant, state, work);
        if (ema_acts_on_motion(plant)) {
            ema_segment_end(plant, state, work);
            ema_segment_correct(plant, state, work);
        }
        ema_event_find(plant, state, work);
        state->current_A = event->current_A;
        if (state->motion != (int32_t)EMA_MOTION_STUCK) {
            state->speed_rad_s = event->speed_rad_s;
            ema_motion_turn(plant, state, event->turn_rad);
        }
        /* an excursion beyond the limit that another event cuts short is not located */
        if (ema_abs(state->current_A) > plant->drive.current_limit_A) {
            state->current_A = ema_clamp(state->current_A, -plant->drive.current_limit_A, plant->drive.current_limit_A);
        }
        ema_event_apply(plant, state, work);
        if (event->kind == EMA_EVENT_NONE) {
            done = true;
        } else {
            work->span_s -= work->span_s * event->at;
            ++events;
            done = !(work->span_s > EMA_R(0.0));
        }
    }
    if (!done) {
        state->speed_rad_s = EMA_R(0.0);
        state->motion = ema_motion_left(plant, EMA_MOTION_STUCK);
        ++state->unlocated_event_steps;
    }
    if (ema_acts(plant, EMA_SITE_TRANSMISSION)) {
        ema_motion_rod(plant, state, work, play_start_mm, span_s);
    }
}
