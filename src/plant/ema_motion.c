#include "ema_motion.h"

#include "ema_effect_sites.h"
#include "ema_gearbox.h"
#include "ema_limits.h"
#include "ema_math.h"
#include "ema_motor.h"
#include "ema_series.h"

/* A start at zero speed is on the root itself: the next root is sought from here on. */
#define EMA_ROOT_FROM EMA_R(0.0625)

/* What acts on the shaft beside the motor's linear torque, and what holds it at rest. */
typedef struct {
    ema_real input;          /* of the circuit */
    ema_real torque_Nm;
    ema_real level_forward_Nm;  /* dry friction at rest against each direction */
    ema_real level_backward_Nm;
} ema_forces_t;

/* A point of the motion. */
typedef struct {
    ema_real current_A;
    ema_real speed_rad_s;
    ema_real angle_rad;
} ema_point_t;

static ema_real ema_level(const ema_plant_t* plant, const ema_site_t* site, ema_real level_Nm, ema_real load_Nm, ema_real direction)
{
    ema_real total_Nm = level_Nm + ema_gearbox_loss(&plant->gearbox, load_Nm, direction);
    if (plant->active.friction != 0U) {
        total_Nm += ema_site_friction(plant, site, level_Nm);
    }
    return ema_max(total_Nm, EMA_R(0.0));
}

static ema_forces_t ema_forces_at(const ema_plant_t* plant, const ema_drive_output_t* applied, int32_t motion, const ema_point_t* point)
{
    /* past a reversal that is not located yet the friction keeps the direction of the motion */
    const ema_real direction = (ema_real)motion;
    const ema_real speed_rad_s = (motion == 0) ? EMA_R(0.0) : (direction * ema_max(direction * point->speed_rad_s, EMA_R(0.0)));
    const ema_site_t site = {speed_rad_s, point->angle_rad, plant->gearbox.lead_mm_per_rad * point->angle_rad, point->current_A, applied->voltage_V};
    ema_forces_t forces = {applied->input, EMA_R(0.0), EMA_R(0.0), EMA_R(0.0)};
    if (!applied->current_loop && (plant->active.voltage != 0U)) {
        forces.input += ema_site_voltage(plant, &site);
    }
    ema_real load_Nm = plant->screw.load_torque_Nm;
    if (plant->active.load != 0U) {
        load_Nm += ema_site_load(plant, &site);
    }
    forces.torque_Nm = ema_motor_torque(&plant->motor, point->current_A) - (plant->motor.torque_constant_Nm_per_A * point->current_A) - load_Nm;
    if (plant->active.torque != 0U) {
        forces.torque_Nm += ema_site_torque(plant, &site);
    }
    if (motion == 0) {
        forces.level_forward_Nm = ema_level(plant, &site, plant->screw.static_Nm, load_Nm, EMA_R(1.0));
        forces.level_backward_Nm = ema_level(plant, &site, plant->screw.static_Nm, load_Nm, EMA_R(-1.0));
    } else {
        forces.torque_Nm -= direction * ema_level(plant, &site, plant->screw.dynamic_Nm, load_Nm, direction);
    }
    return forces;
}

/* Output of the play at a motor angle, without moving it. */
static ema_real ema_play_at(const ema_plant_t* plant, const ema_state_t* state, ema_real angle_rad)
{
    ema_state_t trial = *state;
    ema_screw_play(&plant->screw, &trial, plant->gearbox.lead_mm_per_rad * angle_rad);
    return trial.play_mm;
}

static ema_rod_t ema_transmission_trial(const ema_plant_t* plant, const ema_state_t* state, ema_real play_end_mm, ema_real span_s)
{
    ema_real memory[EMA_EFFECT_MEMORY_COUNT + 1];
    for (uint32_t k = 0; k < (uint32_t)EMA_EFFECT_MEMORY_COUNT; ++k) {
        memory[k] = state->effect_memory[k];
    }
    const ema_transmission_t step = {state->play_mm, play_end_mm, span_s, plant->gearbox.lead_mm_per_rad};
    return ema_site_transmission(plant, &step, memory);
}

/* The drive holds a current that reached its limit while the voltage drives it outward. */
static bool ema_current_held(const ema_plant_t* plant, const ema_circuit_t* circuit, const ema_state_t* state, ema_real input)
{
    const ema_real limit_A = plant->drive.current_limit_A;
    if (circuit->algebraic) {
        return ema_abs((circuit->rate_speed * state->speed_rad_s) + (circuit->rate_voltage * input)) > limit_A;
    }
    const ema_real rate = (circuit->rate_current * state->current_A) + (circuit->rate_speed * state->speed_rad_s) + (circuit->rate_voltage * input);
    return ((state->current_A >= limit_A) && (rate > EMA_R(0.0))) || ((state->current_A <= -limit_A) && (rate < EMA_R(0.0)));
}

static ema_point_t ema_point_of(const ema_series_t* series, const ema_state_t* state, ema_real at)
{
    const ema_point_t point = {ema_series_at(series->current_A, at), ema_series_at(series->speed_rad_s, at), state->angle_rad + ema_series_at(series->angle_rad, at)};
    return point;
}

/* Series over the span with effects taken at its start and at its predicted end. */
static ema_forces_t ema_predict(const ema_plant_t* plant, const ema_state_t* state, const ema_drive_output_t* applied, const ema_circuit_t* circuit, ema_real span_s, ema_series_t* series)
{
    const ema_point_t start = {state->current_A, state->speed_rad_s, state->angle_rad};
    ema_forces_t forces = ema_forces_at(plant, applied, state->motion, &start);
    const bool held = ema_current_held(plant, circuit, state, forces.input);
    ema_span_t span = {state->current_A, state->speed_rad_s, forces.input, EMA_R(0.0), forces.torque_Nm, EMA_R(0.0), span_s, state->motion == 0, held};
    if (held && circuit->algebraic) {
        span.current_A = ema_clamp((circuit->rate_speed * state->speed_rad_s) + (circuit->rate_voltage * forces.input), -plant->drive.current_limit_A, plant->drive.current_limit_A);
    }
    if (plant->active.transmission != 0U) {
        span.torque_Nm += ema_transmission_trial(plant, state, state->play_mm, span_s).reaction_start_Nm;
    }
    ema_series_build(series, plant, circuit, &span);
    const ema_point_t end = ema_point_of(series, state, EMA_R(1.0));
    const bool saturates = (ema_abs(end.current_A) > plant->linear_current_A) || (ema_abs(start.current_A) > plant->linear_current_A);
    if (plant->active.any || saturates) {
        const ema_forces_t last = ema_forces_at(plant, applied, state->motion, &end);
        span.input_rise = last.input - forces.input;
        span.torque_Nm = forces.torque_Nm;
        span.torque_rise_Nm = last.torque_Nm - forces.torque_Nm;
        if (plant->active.transmission != 0U) {
            const ema_rod_t rod = ema_transmission_trial(plant, state, ema_play_at(plant, state, end.angle_rad), span_s);
            span.torque_Nm += rod.reaction_start_Nm;
            span.torque_rise_Nm += rod.reaction_end_Nm - rod.reaction_start_Nm;
        }
        ema_series_build(series, plant, circuit, &span);
    }
    forces.torque_Nm = span.torque_Nm;
    /* at rest the terms of the torque are those of the current: they say when it breaks away */
    if (state->motion == 0) {
        for (uint32_t k = 0; k <= EMA_SERIES_TERMS; ++k) {
            series->speed_rad_s[k] = plant->motor.torque_constant_Nm_per_A * series->current_A[k];
        }
        series->speed_rad_s[0] += span.torque_Nm;
        series->speed_rad_s[1] += span.torque_rise_Nm;
    }
    return forces;
}

typedef enum {
    EMA_EVENT_NONE,
    EMA_EVENT_REST,    /* the speed reaches zero */
    EMA_EVENT_STOP,    /* an end of travel */
    EMA_EVENT_LIMIT,   /* the current reaches its limit */
    EMA_EVENT_FORWARD, /* the torque leaves what dry friction holds */
    EMA_EVENT_BACKWARD
} ema_event_kind_t;

typedef struct {
    ema_event_kind_t kind;
    ema_real at;      /* fraction of the span */
    ema_real value;   /* of the quantity that reached its bound */
} ema_event_t;

/* Takes the earlier of the known event and the crossing of `bound` by a series that has crossed it at the end of the span. */
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

static ema_event_t ema_event_find(const ema_plant_t* plant, const ema_state_t* state, const ema_forces_t* forces, ema_series_t* series)
{
    ema_event_t event = {EMA_EVENT_NONE, EMA_R(1.0), EMA_R(0.0)};
    const ema_real end_A = ema_series_at(series->current_A, EMA_R(1.0));
    const ema_real limit_A = plant->drive.current_limit_A;
    if ((ema_abs(end_A) > limit_A) && (ema_abs(series->current_A[0]) < limit_A)) {
        ema_event_take(&event, EMA_EVENT_LIMIT, series->current_A, (end_A > EMA_R(0.0)) ? limit_A : -limit_A, EMA_R(0.0));
    }
    if (state->motion == 0) {
        /* a current that follows the voltage at once can break away at the very start */
        const ema_motion_t at_start = ema_screw_break_away(&plant->screw, state->angle_rad, series->speed_rad_s[0], forces->level_forward_Nm, forces->level_backward_Nm);
        const ema_motion_t at_end = ema_screw_break_away(&plant->screw, state->angle_rad, ema_series_at(series->speed_rad_s, EMA_R(1.0)), forces->level_forward_Nm, forces->level_backward_Nm);
        if (at_start != EMA_MOTION_STUCK) {
            event.kind = (at_start == EMA_MOTION_FORWARD) ? EMA_EVENT_FORWARD : EMA_EVENT_BACKWARD;
            event.at = EMA_R(0.0);
        } else if (at_end == EMA_MOTION_FORWARD) {
            ema_event_take(&event, EMA_EVENT_FORWARD, series->speed_rad_s, forces->level_forward_Nm, EMA_R(0.0));
        } else if (at_end == EMA_MOTION_BACKWARD) {
            ema_event_take(&event, EMA_EVENT_BACKWARD, series->speed_rad_s, -forces->level_backward_Nm, EMA_R(0.0));
        } else {
            /* held over the whole span */
        }
    } else {
        const ema_real direction = (ema_real)state->motion;
        const ema_real from = (state->speed_rad_s == EMA_R(0.0)) ? EMA_ROOT_FROM : EMA_R(0.0);
        if (!((direction * ema_series_at(series->speed_rad_s, EMA_R(1.0))) > EMA_R(0.0))) {
            if ((direction * ema_series_at(series->speed_rad_s, from)) > EMA_R(0.0)) {
                ema_event_take(&event, EMA_EVENT_REST, series->speed_rad_s, EMA_R(0.0), from);
            } else {
                event.kind = EMA_EVENT_REST;
                event.at = from;
            }
        }
        const ema_real end_rad = state->angle_rad + ema_series_at(series->angle_rad, EMA_R(1.0));
        if (end_rad >= plant->screw.stop_upper_rad) {
            ema_event_take(&event, EMA_EVENT_STOP, series->angle_rad, plant->screw.stop_upper_rad - state->angle_rad, EMA_R(0.0));
            event.value = (event.kind == EMA_EVENT_STOP) ? plant->screw.stop_upper_rad : event.value;
        } else if (end_rad <= plant->screw.stop_lower_rad) {
            ema_event_take(&event, EMA_EVENT_STOP, series->angle_rad, plant->screw.stop_lower_rad - state->angle_rad, EMA_R(0.0));
            event.value = (event.kind == EMA_EVENT_STOP) ? plant->screw.stop_lower_rad : event.value;
        } else {
            /* inside the travel */
        }
    }
    return event;
}

/* Moves the state to the fraction `at` of the span. */
static void ema_motion_to(ema_state_t* state, const ema_series_t* series, ema_real at)
{
    state->current_A = ema_series_at(series->current_A, at);
    if (state->motion != 0) {
        state->speed_rad_s = ema_series_at(series->speed_rad_s, at);
        ema_add_compensated(&state->angle_rad, &state->angle_low_rad, ema_series_at(series->angle_rad, at));
    }
}

static void ema_event_apply(const ema_plant_t* plant, ema_state_t* state, const ema_drive_output_t* applied, const ema_event_t* event)
{
    switch (event->kind) {
    case EMA_EVENT_REST: {
        /* a turning point is the extreme that the play sees */
        ema_screw_play(&plant->screw, state, plant->gearbox.lead_mm_per_rad * state->angle_rad);
        state->speed_rad_s = EMA_R(0.0);
        const ema_point_t here = {state->current_A, EMA_R(0.0), state->angle_rad};
        const ema_forces_t forces = ema_forces_at(plant, applied, 0, &here);
        const ema_real torque_Nm = forces.torque_Nm + (plant->motor.torque_constant_Nm_per_A * state->current_A);
        state->motion = (int32_t)ema_screw_break_away(&plant->screw, state->angle_rad, torque_Nm, forces.level_forward_Nm, forces.level_backward_Nm);
        break;
    }
    case EMA_EVENT_STOP:
        state->angle_rad = event->value;
        state->angle_low_rad = EMA_R(0.0);
        state->speed_rad_s = EMA_R(0.0);
        state->motion = (int32_t)EMA_MOTION_STUCK;
        break;
    case EMA_EVENT_LIMIT:
        state->current_A = event->value;
        break;
    case EMA_EVENT_FORWARD:
        state->motion = (int32_t)EMA_MOTION_FORWARD;
        break;
    case EMA_EVENT_BACKWARD:
        state->motion = (int32_t)EMA_MOTION_BACKWARD;
        break;
    case EMA_EVENT_NONE:
    default:
        break;
    }
}

void ema_motion_located(const ema_plant_t* plant, ema_state_t* state, const ema_drive_output_t* applied)
{
    const ema_circuit_t* const circuit = applied->current_loop ? &plant->current_loop : &plant->motor_circuit;
    const ema_real play_start_mm = state->play_mm;
    ema_real left_s = plant->substep_s;
    uint32_t events = 0U;
    bool done = false;
    while (!done && (events < EMA_EVENTS_MAX)) {
        ema_series_t series;
        const ema_forces_t forces = ema_predict(plant, state, applied, circuit, left_s, &series);
        const ema_event_t event = ema_event_find(plant, state, &forces, &series);
        ema_motion_to(state, &series, event.at);
        if (event.kind == EMA_EVENT_NONE) {
            done = true;
        } else {
            ema_event_apply(plant, state, applied, &event);
            left_s -= left_s * event.at;
            ++events;
            done = !(left_s > EMA_R(0.0));
        }
    }
    if (!done) {
        state->speed_rad_s = EMA_R(0.0);
        state->motion = (int32_t)EMA_MOTION_STUCK;
        ++state->crowded_steps;
    }
    if (plant->active.transmission != 0U) {
        ema_screw_play(&plant->screw, state, plant->gearbox.lead_mm_per_rad * state->angle_rad);
        const ema_transmission_t step = {play_start_mm, state->play_mm, plant->substep_s, plant->gearbox.lead_mm_per_rad};
        state->rod_mm = ema_site_transmission(plant, &step, state->effect_memory).rod_mm;
    }
}
