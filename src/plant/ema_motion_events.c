/* An integration step with its events, one after the other: find the next, move to it, let it happen. */
#include "plant/ema_motion_events.h"

#include "base/ema_compiler.h"
#include "base/ema_math.h"
#include "blocks/ema_mechanics.h"
#include "effects/ema_effect_sites.h"
#include "plant/ema_motion.h"
#include "plant/ema_series.h"

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
    work->spent += plant->forces_work;
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

/* A start at zero speed is on the root itself: the next root is sought from here on. */
#define EMA_ROOT_FROM EMA_R(0.0625)

EMA_NOINLINE void ema_regime_update(const ema_plant_t* plant, const ema_state_t* state, ema_step_scratch_t* work)
{
    const ema_circuit_t* const circuit = work->circuit;
    const ema_event_t* const last = &work->event;
    ema_regime_t* const regime = &work->regime;
    const ema_real input = work->segment.forces.input;
    const ema_real limit_A = plant->drive.current_limit_A;
    const ema_real reached_A = (last->kind == EMA_EVENT_CURRENT) ? ema_abs(last->value) : EMA_R(-1.0);
    ema_real current_A = state->current_A;
    ema_real rate = EMA_R(0.0);
    if (circuit->algebraic) {
        const ema_real free_A = (circuit->rate_speed * state->speed_rad_s) + (circuit->rate_voltage * input);
        current_A = ema_clamp(free_A, -limit_A, limit_A);
        regime->held = (current_A != free_A) || (reached_A == limit_A);
    } else {
        rate = (circuit->rate_current * current_A) + (circuit->rate_speed * state->speed_rad_s)
               + (circuit->rate_voltage * input);
        regime->held =
            ((current_A >= limit_A) && (rate > EMA_R(0.0))) || ((current_A <= -limit_A) && (rate < EMA_R(0.0)));
    }
    regime->held = regime->held && (last->kind != EMA_EVENT_RELEASE);
    const ema_real size_A = ema_abs(current_A);
    bool saturated =
        (size_A > plant->torque_limit_A) || ((size_A == plant->torque_limit_A) && ((rate * current_A) > EMA_R(0.0)));
    if (reached_A == plant->torque_limit_A) {
        saturated = regime->saturated_Nm == EMA_R(0.0);
    }
    regime->saturated_Nm = EMA_R(0.0);
    if (saturated) {
        regime->saturated_Nm = (current_A > EMA_R(0.0)) ? plant->motor.torque_limit_Nm : -plant->motor.torque_limit_Nm;
    }
}

EMA_NOINLINE void ema_segment_end(const ema_plant_t* plant, const ema_state_t* state, ema_step_scratch_t* work)
{
    const ema_circuit_t* const circuit = work->circuit;
    ema_segment_t* const segment = &work->segment;
    ema_span_t* const span = &work->span;
    ema_series_t* const series = &work->series;
    span->input = segment->forces.input;
    span->torque_Nm = segment->forces.torque_Nm + work->regime.saturated_Nm;
    span->input_bend = EMA_R(0.0);
    span->torque_bend_Nm = EMA_R(0.0);
    span->torque_twist_Nm = EMA_R(0.0);
    span->span_s = work->span_s;
    span->torque_gain_Nm_per_A =
        (work->regime.saturated_Nm != EMA_R(0.0)) ? EMA_R(0.0) : plant->motor.torque_constant_Nm_per_A;
    span->at_rest = state->motion == 0;
    span->current_held = work->regime.held;
    if (span->current_held && circuit->algebraic) {
        span->current_A = ema_circuit_follow(plant, circuit, state, span->input);
    }
    ema_series_end(plant, work, &segment->end);
    segment->end.angle_rad += state->angle_rad;
    /* at rest the terms of the speed are free to hold those of the torque, which say when the shaft breaks away */
    if (span->at_rest) {
        for (uint32_t k = 0; k <= EMA_SERIES_TERMS; ++k) {
            series->speed_rad_s[k] = span->torque_gain_Nm_per_A * series->current_A[k];
        }
        series->speed_rad_s[0] += span->torque_Nm;
        series->speed_rad_s[1] += span->torque_rise_Nm;
    }
}

/* Takes the earlier of the known event and the crossing of `bound` by a series that has crossed it at the end of the
 * span. */
static void ema_event_take(ema_event_t* event, ema_event_kind_t kind, ema_real* terms, ema_real bound, ema_real from)
{
    const ema_real keep = terms[0];
    terms[0] = keep - bound;
    const ema_real at = ema_series_root(terms, from);
    terms[0] = keep;
    if ((event->kind == EMA_EVENT_NONE) || (at < event->at)) {
        event->kind = kind;
        event->at = at;
        event->value = bound;
    }
}

/* Crossings of +-bound by the current, from inside or from outside. */
static void ema_event_current(ema_step_scratch_t* work, ema_real bound_A, bool outside)
{
    ema_real* const terms_A = work->series.current_A;
    const ema_real end_A = work->segment.end.current_A;
    const ema_real start_A = terms_A[0];
    if (outside) {
        const ema_real side_A = (start_A > EMA_R(0.0)) ? bound_A : -bound_A;
        if ((end_A * side_A) < (bound_A * bound_A)) {
            ema_event_take(&work->event, EMA_EVENT_CURRENT, terms_A, side_A, EMA_R(0.0));
        }
    } else if (ema_abs(end_A) > bound_A) {
        const ema_real side_A = (end_A > EMA_R(0.0)) ? bound_A : -bound_A;
        const ema_real from = (start_A == side_A) ? EMA_ROOT_FROM : EMA_R(0.0);
        const ema_real from_A = ema_series_at(terms_A, from);
        if ((end_A > EMA_R(0.0)) ? (from_A < side_A) : (from_A > side_A)) {
            ema_event_take(&work->event, EMA_EVENT_CURRENT, terms_A, side_A, from);
        }
    } else {
        /* stays inside */
    }
}

/* A held current is let go when the circuit on its own would bring it inward. */
static void ema_event_release(const ema_state_t* state, ema_step_scratch_t* work)
{
    const ema_circuit_t* const circuit = work->circuit;
    ema_real* const terms = work->terms;
    for (uint32_t k = 0; k <= EMA_SERIES_TERMS; ++k) {
        terms[k] = (state->motion == 0) ? EMA_R(0.0) : (circuit->rate_speed * work->series.speed_rad_s[k]);
    }
    const ema_real held_A = work->series.current_A[0];
    terms[0] += (circuit->rate_current * held_A) + (circuit->rate_voltage * work->segment.forces.input);
    terms[1] += circuit->rate_voltage * work->span.input_rise;
    if (circuit->algebraic) {
        terms[0] -= held_A;
    }
    if (((ema_series_at(terms, EMA_R(1.0)) * held_A) < EMA_R(0.0)) && ((terms[0] * held_A) > EMA_R(0.0))) {
        ema_event_take(&work->event, EMA_EVENT_RELEASE, terms, EMA_R(0.0), EMA_R(0.0));
    }
    ema_series_angle(&work->series, work->span_s, terms);
}

static void ema_event_at_rest(const ema_plant_t* plant, const ema_state_t* state, ema_step_scratch_t* work)
{
    const ema_forces_t* const forces = &work->segment.forces;
    ema_event_t* const event = &work->event;
    ema_real* const torque_Nm = work->series.speed_rad_s;
    /* a current that follows the voltage at once can break away at the very start */
    const ema_motion_t at_start = ema_screw_break_away(&plant->screw, state->angle_rad, torque_Nm[0],
                                                       forces->level_forward_Nm, forces->level_backward_Nm);
    const ema_motion_t at_end =
        ema_screw_break_away(&plant->screw, state->angle_rad, ema_series_at(torque_Nm, EMA_R(1.0)),
                             forces->level_forward_Nm, forces->level_backward_Nm);
    if (at_start != EMA_MOTION_STUCK) {
        event->kind = (at_start == EMA_MOTION_FORWARD) ? EMA_EVENT_FORWARD : EMA_EVENT_BACKWARD;
        event->at = EMA_R(0.0);
    } else if (at_end == EMA_MOTION_FORWARD) {
        ema_event_take(event, EMA_EVENT_FORWARD, torque_Nm, forces->level_forward_Nm, EMA_R(0.0));
    } else if (at_end == EMA_MOTION_BACKWARD) {
        ema_event_take(event, EMA_EVENT_BACKWARD, torque_Nm, -forces->level_backward_Nm, EMA_R(0.0));
    } else {
        /* held over the whole span */
    }
}

/* The speed reaches zero. */
static void ema_event_reversal(const ema_state_t* state, ema_step_scratch_t* work)
{
    ema_event_t* const event = &work->event;
    const ema_real direction = (ema_real)state->motion;
    ema_real* const speed_rad_s = work->series.speed_rad_s;
    const ema_real from = (state->speed_rad_s == EMA_R(0.0)) ? EMA_ROOT_FROM : EMA_R(0.0);
    if (!((direction * work->segment.end.speed_rad_s) > EMA_R(0.0))) {
        if ((direction * ema_series_at(speed_rad_s, from)) > EMA_R(0.0)) {
            ema_event_take(event, EMA_EVENT_REST, speed_rad_s, EMA_R(0.0), from);
        } else if ((event->kind == EMA_EVENT_NONE) || (from < event->at)) {
            event->kind = EMA_EVENT_REST;
            event->at = from;
        } else {
            /* something else comes first */
        }
    }
}

/* An end of travel that the shaft moves towards. */
static void ema_event_stop(const ema_plant_t* plant, const ema_state_t* state, ema_step_scratch_t* work)
{
    ema_event_t* const event = &work->event;
    const ema_real end_rad = work->segment.end.angle_rad;
    ema_real stop_rad = EMA_R(0.0);
    bool reached = false;
    if ((end_rad >= plant->screw.stop_upper_rad) && (end_rad > state->angle_rad)) {
        stop_rad = plant->screw.stop_upper_rad;
        reached = true;
    } else if ((end_rad <= plant->screw.stop_lower_rad) && (end_rad < state->angle_rad)) {
        stop_rad = plant->screw.stop_lower_rad;
        reached = true;
    } else {
        /* inside the travel */
    }
    if (reached) {
        const ema_real before = event->at;
        ema_event_take(event, EMA_EVENT_STOP, work->terms, stop_rad - state->angle_rad, EMA_R(0.0));
        if (event->at != before) {
            event->value = stop_rad;
        }
    }
}

EMA_NOINLINE void ema_event_find(const ema_plant_t* plant, const ema_state_t* state, ema_step_scratch_t* work)
{
    ema_event_t* const event = &work->event;
    ema_segment_end(plant, state, work);
    event->kind = EMA_EVENT_NONE;
    event->at = EMA_R(1.0);
    event->value = EMA_R(0.0);
    if (work->regime.held) {
        ema_event_release(state, work);
    } else {
        ema_event_current(work, plant->drive.current_limit_A, false);
        ema_event_current(work, plant->torque_limit_A, work->regime.saturated_Nm != EMA_R(0.0));
    }
    event->speed_rad_s = state->speed_rad_s;
    event->turn_rad = EMA_R(0.0);
    if (state->motion == 0) {
        ema_event_at_rest(plant, state, work);
    } else {
        if (state->motion != (int32_t)EMA_MOTION_ELASTIC) {
            ema_event_reversal(state, work);
        }
        ema_event_stop(plant, state, work);
        event->speed_rad_s = ema_series_at(work->series.speed_rad_s, event->at);
        event->turn_rad = ema_series_at(work->terms, event->at);
    }
    event->current_A = ema_series_at(work->series.current_A, event->at);
}
