#include "ema_motion.h"

#include "ema_effect_sites.h"
#include "ema_gearbox.h"
#include "ema_math.h"
#include "ema_motor.h"
#include "ema_series.h"

/* A start at zero speed is on the root itself: the next root is sought from here on. */
#define EMA_ROOT_FROM EMA_R(0.0625)

/* How far the forces inside a step may be off an even rise, as a share of the torques at work, or of the voltage: far below what an effect that can be seen makes. */
#define EMA_UNEVEN EMA_R(5.0e-5)
#define EMA_UNEVEN_INPUT EMA_R(1.0e-4)

/* What acts on circuit and shaft at a point of the motion, beside the motor's own torque; and what holds the shaft at rest. */
typedef struct {
    ema_real input;             /* of the circuit */
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

/* A span of the motion without events: what its ends are. */
typedef struct {
    ema_point_t start;
    ema_point_t end;
    ema_forces_t forces;      /* at the start */
    ema_real input_rise;
    ema_real torque_rise_Nm;
} ema_segment_t;

static ema_real ema_level(const ema_plant_t* plant, const ema_site_t* site, ema_real level_Nm, ema_real load_Nm, ema_real direction)
{
    const ema_real own_Nm = ema_screw_level(&plant->screw, level_Nm, direction);
    ema_real total_Nm = own_Nm + ema_gearbox_loss(&plant->gearbox, load_Nm, direction);
    if (plant->active.friction != 0U) {
        total_Nm += ema_site_friction(plant, site, own_Nm);
    }
    return ema_max(total_Nm, EMA_R(0.0));
}

/* Torque of dry friction on a shaft that slides, or of a stretched contact, which an end of travel alone can hold at rest. */
static ema_real ema_sliding_friction(const ema_plant_t* plant, const ema_state_t* state, const ema_site_t* site, ema_real load_Nm)
{
    if (plant->active.presliding == 0U) {
        const ema_real direction = (ema_real)state->motion;
        return -direction * ema_level(plant, site, plant->screw.dynamic_Nm, load_Nm, direction);
    }
    const ema_real share = ema_site_presliding(plant, state->effect_memory, site->angle_rad - state->angle_rad);
    return -share * ema_level(plant, site, plant->screw.dynamic_Nm, load_Nm, (share < EMA_R(0.0)) ? EMA_R(-1.0) : EMA_R(1.0));
}

/* Speed as the forces see it: past a reversal that is not located yet the friction keeps the direction of the motion. */
static ema_real ema_force_speed(int32_t motion, ema_real speed_rad_s)
{
    ema_real speed = speed_rad_s;
    if (motion == (int32_t)EMA_MOTION_STUCK) {
        speed = EMA_R(0.0);
    } else if (motion == (int32_t)EMA_MOTION_FORWARD) {
        speed = ema_max(speed_rad_s, EMA_R(0.0));
    } else if (motion == (int32_t)EMA_MOTION_BACKWARD) {
        speed = ema_min(speed_rad_s, EMA_R(0.0));
    } else {
        /* an elastic contact has no direction to keep */
    }
    return speed;
}

static ema_forces_t ema_forces_at(const ema_plant_t* plant, const ema_state_t* state, const ema_drive_output_t* applied, const ema_point_t* point)
{
    const ema_site_t site = {plant,
                             ema_force_speed(state->motion, point->speed_rad_s),
                             point->angle_rad,
                             plant->gearbox.lead_mm_per_rad * point->angle_rad,
                             point->current_A,
                             applied->current_loop ? applied->voltage_V : applied->input};
    ema_forces_t forces = {applied->input, EMA_R(0.0), EMA_R(0.0), EMA_R(0.0)};
    if (!applied->current_loop && (plant->active.voltage != 0U)) {
        forces.input += ema_site_voltage(plant, &site);
    }
    ema_real load_Nm = plant->screw.load_torque_Nm;
    if (plant->active.load != 0U) {
        load_Nm += ema_site_load(plant, &site);
    }
    forces.torque_Nm = -load_Nm;
    if (plant->active.torque != 0U) {
        forces.torque_Nm += ema_site_torque(plant, &site);
    }
    if (plant->active.motor != 0U) {
        const ema_real change = ema_site_motor(plant, &site);
        const ema_real changed_A = (EMA_R(1.0) + change) * site.current_A;
        /* the limit holds for the torque with its change */
        forces.torque_Nm += ema_motor_torque(&plant->motor, changed_A) - ema_motor_torque(&plant->motor, site.current_A);
        forces.input -= applied->current_loop ? EMA_R(0.0) : (change * plant->motor.back_emf_V_s_per_rad * point->speed_rad_s);
    }
    if ((state->motion == (int32_t)EMA_MOTION_STUCK) && (plant->active.presliding == 0U)) {
        forces.level_forward_Nm = ema_level(plant, &site, plant->screw.static_Nm, load_Nm, EMA_R(1.0));
        forces.level_backward_Nm = ema_level(plant, &site, plant->screw.static_Nm, load_Nm, EMA_R(-1.0));
    } else {
        forces.torque_Nm += ema_sliding_friction(plant, state, &site, load_Nm);
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

/* Opens a segment: the forces at its start, held over it until its end is known. */
static ema_segment_t ema_segment_open(const ema_plant_t* plant, const ema_state_t* state, const ema_drive_output_t* applied, ema_real span_s)
{
    ema_segment_t segment;
    segment.start.current_A = state->current_A;
    segment.start.speed_rad_s = state->speed_rad_s;
    segment.start.angle_rad = state->angle_rad;
    segment.end = segment.start;
    segment.forces = ema_forces_at(plant, state, applied, &segment.start);
    segment.input_rise = EMA_R(0.0);
    segment.torque_rise_Nm = EMA_R(0.0);
    if (plant->active.transmission != 0U) {
        segment.forces.torque_Nm += ema_transmission_trial(plant, state, state->play_mm, span_s).reaction_start_Nm;
    }
    return segment;
}

/* Lets the forces rise evenly to those at the predicted end. */
static void ema_segment_correct(const ema_plant_t* plant, const ema_state_t* state, const ema_drive_output_t* applied, ema_real span_s, ema_segment_t* segment)
{
    const ema_forces_t last = ema_forces_at(plant, state, applied, &segment->end);
    ema_forces_t first = segment->forces;
    segment->input_rise = last.input - first.input;
    if (plant->active.transmission != 0U) {
        first = ema_forces_at(plant, state, applied, &segment->start);
        const ema_rod_t rod = ema_transmission_trial(plant, state, ema_play_at(plant, state, segment->end.angle_rad), span_s);
        segment->forces.torque_Nm = first.torque_Nm + rod.reaction_start_Nm;
        segment->torque_rise_Nm = (last.torque_Nm + rod.reaction_end_Nm) - segment->forces.torque_Nm;
    } else {
        segment->torque_rise_Nm = last.torque_Nm - first.torque_Nm;
    }
}

static ema_real ema_response_rise(const ema_response_t* response, const ema_segment_t* segment)
{
    return ema_response_at(response, segment->start.current_A, segment->start.speed_rad_s, segment->forces.input, segment->forces.torque_Nm)
           + ((response->from_voltage_rise * segment->input_rise) + (response->from_torque_rise * segment->torque_rise_Nm));
}

/* End of an integration step from the prepared responses; `turn_rad` is the angle moved. */
static void ema_segment_respond(const ema_circuit_t* circuit, int32_t motion, ema_segment_t* segment, ema_real* turn_rad)
{
    *turn_rad = EMA_R(0.0);
    if (motion != 0) {
        *turn_rad = ema_response_rise(&circuit->angle, segment);
        segment->end.current_A = ema_response_rise(&circuit->current, segment);
        segment->end.speed_rad_s = ema_response_rise(&circuit->speed, segment);
        segment->end.angle_rad = segment->start.angle_rad + *turn_rad;
    } else {
        segment->end.current_A = (circuit->stuck_from_current * segment->start.current_A) + (circuit->stuck_from_voltage * segment->forces.input)
                                 + (circuit->stuck_from_voltage_rise * segment->input_rise);
    }
}

/* Turns the shaft; an elastic contact follows. */
static void ema_turn(const ema_plant_t* plant, ema_state_t* state, ema_real turn_rad)
{
    if (state->motion == (int32_t)EMA_MOTION_ELASTIC) {
        ema_site_presliding_keep(plant, state->effect_memory, ema_site_presliding(plant, state->effect_memory, turn_rad));
    }
    ema_add_compensated(&state->angle_rad, &state->angle_low_rad, turn_rad);
}

/* Current at the fraction `at` of a segment, from its values and rates at both ends: forces that follow the current bend with it. */
static ema_real ema_segment_current(const ema_circuit_t* circuit, ema_real span_s, const ema_segment_t* segment, ema_real at)
{
    const ema_real change_A = segment->start.current_A - segment->end.current_A;
    const ema_real slowing_rad_s = segment->start.speed_rad_s - segment->end.speed_rad_s;
    const ema_real bend_A_s = (circuit->rate_current * change_A) + (circuit->rate_speed * slowing_rad_s) - (circuit->rate_voltage * segment->input_rise);
    const ema_real even_A = segment->start.current_A - (at * change_A);
    return circuit->algebraic ? even_A : (even_A + (EMA_R(0.5) * at * (EMA_R(1.0) - at) * span_s * bend_A_s));
}

/* Whether the forces at the fraction `at` are those of an even rise, nearly. */
static bool ema_segment_even_at(const ema_plant_t* plant, const ema_circuit_t* circuit, const ema_state_t* state, const ema_drive_output_t* applied, ema_real span_s, const ema_segment_t* segment, ema_real at)
{
    const ema_real gained_rad_s = at * (segment->end.speed_rad_s - segment->start.speed_rad_s);
    const ema_point_t here = {ema_segment_current(circuit, span_s, segment, at), segment->start.speed_rad_s + gained_rad_s,
                              segment->start.angle_rad + (at * span_s * (segment->start.speed_rad_s + (EMA_R(0.5) * gained_rad_s)))};
    const ema_forces_t forces = ema_forces_at(plant, state, applied, &here);
    const ema_real torque_Nm = plant->screw.static_Nm + ema_abs(plant->motor.torque_constant_Nm_per_A * segment->start.current_A);
    const ema_real torque_off_Nm = forces.torque_Nm - (segment->forces.torque_Nm + (at * segment->torque_rise_Nm));
    const ema_real input_off = forces.input - (segment->forces.input + (at * segment->input_rise));
    return (ema_abs(torque_off_Nm) <= (EMA_UNEVEN * torque_Nm)) && (ema_abs(input_off) <= (EMA_UNEVEN_INPUT * ema_abs(applied->input)));
}

/* Whether an even rise stands for the whole segment: it does at two points, between which a ripple cannot hide. An elastic contact forgets which way it was
 * stretched, so a turning point inside is too much for it. */
static bool ema_segment_even(const ema_plant_t* plant, const ema_circuit_t* circuit, const ema_state_t* state, const ema_drive_output_t* applied, ema_real span_s, const ema_segment_t* segment)
{
    const bool turns = (state->motion == (int32_t)EMA_MOTION_ELASTIC) && !((segment->start.speed_rad_s * segment->end.speed_rad_s) > EMA_R(0.0));
    return !turns && ema_segment_even_at(plant, circuit, state, applied, span_s, segment, EMA_R(0.5)) && ema_segment_even_at(plant, circuit, state, applied, span_s, segment, EMA_R(0.1875));
}

/* One integration step with effects but without an event; false, and nothing changed, when something would happen, or, with `even`, when the effects do
 * not rise evenly over it. */
static bool ema_motion_smooth(const ema_plant_t* plant, const ema_circuit_t* circuit, ema_state_t* state, const ema_drive_output_t* applied, ema_real span_s, bool even)
{
    if (!(ema_abs(state->current_A) < plant->linear_current_A)) {
        return false;
    }
    ema_real turn_rad;
    ema_segment_t segment = ema_segment_open(plant, state, applied, span_s);
    ema_segment_respond(circuit, state->motion, &segment, &turn_rad);
    ema_segment_correct(plant, state, applied, span_s, &segment);
    ema_segment_respond(circuit, state->motion, &segment, &turn_rad);

    bool smooth = ema_abs(segment.end.current_A) <= plant->linear_current_A;
    if (state->motion != (int32_t)EMA_MOTION_STUCK) {
        const bool keeps = (state->motion == (int32_t)EMA_MOTION_ELASTIC) || (((ema_real)state->motion * segment.end.speed_rad_s) > EMA_R(0.0));
        smooth = smooth && keeps && (segment.end.angle_rad < plant->screw.stop_upper_rad) && (segment.end.angle_rad > plant->screw.stop_lower_rad);
    } else {
        const ema_real gain = plant->motor.torque_constant_Nm_per_A;
        const ema_real first_Nm = segment.forces.torque_Nm + (gain * segment.start.current_A);
        const ema_real last_Nm = segment.forces.torque_Nm + segment.torque_rise_Nm + (gain * segment.end.current_A);
        smooth = smooth && (ema_max(first_Nm, last_Nm) <= segment.forces.level_forward_Nm) && (ema_min(first_Nm, last_Nm) >= -segment.forces.level_backward_Nm);
    }
    smooth = smooth && (!even || ema_segment_even(plant, circuit, state, applied, span_s, &segment));
    if (smooth) {
        state->current_A = segment.end.current_A;
        state->speed_rad_s = segment.end.speed_rad_s;
        ema_turn(plant, state, turn_rad);
    }
    return smooth;
}

typedef enum {
    EMA_EVENT_NONE,
    EMA_EVENT_REST,     /* the speed reaches zero */
    EMA_EVENT_STOP,     /* an end of travel */
    EMA_EVENT_CURRENT,  /* the current reaches a limit of drive or torque */
    EMA_EVENT_RELEASE,  /* the drive need not hold the current any longer */
    EMA_EVENT_FORWARD,  /* the torque leaves what dry friction holds */
    EMA_EVENT_BACKWARD
} ema_event_kind_t;

typedef struct {
    ema_event_kind_t kind;
    ema_real at;      /* fraction of the span */
    ema_real value;   /* of the quantity that reached its bound */
} ema_event_t;

/* What the current does over a segment that is located. */
typedef struct {
    bool held;                 /* the drive holds it at its limit */
    ema_real rate;             /* of the free circuit at the start, A/s */
    ema_real saturated_Nm;     /* motor torque while it is saturated, else zero */
} ema_regime_t;

/* `last` is what happened just before and `was` the regime until then: on a bound itself they decide, for rounding puts the current on either side. */
static ema_regime_t ema_regime_of(const ema_plant_t* plant, const ema_circuit_t* circuit, const ema_state_t* state, ema_real input, const ema_event_t* last, const ema_regime_t* was)
{
    ema_regime_t regime = {false, EMA_R(0.0), EMA_R(0.0)};
    const ema_real limit_A = plant->drive.current_limit_A;
    ema_real current_A = state->current_A;
    if (circuit->algebraic) {
        const ema_real free_A = (circuit->rate_speed * state->speed_rad_s) + (circuit->rate_voltage * input);
        current_A = ema_clamp(free_A, -limit_A, limit_A);
        regime.held = (current_A != free_A) || ((last->kind == EMA_EVENT_CURRENT) && (ema_abs(last->value) == limit_A));
    } else {
        regime.rate = (circuit->rate_current * current_A) + (circuit->rate_speed * state->speed_rad_s) + (circuit->rate_voltage * input);
        regime.held = ((current_A >= limit_A) && (regime.rate > EMA_R(0.0))) || ((current_A <= -limit_A) && (regime.rate < EMA_R(0.0)));
    }
    regime.held = regime.held && (last->kind != EMA_EVENT_RELEASE);
    const ema_real size_A = ema_abs(current_A);
    bool saturated = (size_A > plant->torque_limit_A) || ((size_A == plant->torque_limit_A) && ((regime.rate * current_A) > EMA_R(0.0)));
    if ((last->kind == EMA_EVENT_CURRENT) && (ema_abs(last->value) == plant->torque_limit_A)) {
        saturated = was->saturated_Nm == EMA_R(0.0);
    }
    if (saturated) {
        regime.saturated_Nm = (current_A > EMA_R(0.0)) ? plant->motor.torque_limit_Nm : -plant->motor.torque_limit_Nm;
    }
    return regime;
}

/* A span as a series, and what was assumed for it. */
typedef struct {
    ema_series_t series;
    ema_segment_t segment;
    ema_regime_t regime;
} ema_located_t;

static void ema_located_build(const ema_plant_t* plant, const ema_state_t* state, const ema_circuit_t* circuit, ema_real span_s, ema_located_t* located)
{
    const ema_segment_t* const segment = &located->segment;
    const bool saturated = located->regime.saturated_Nm != EMA_R(0.0);
    ema_span_t span;
    span.current_A = state->current_A;
    span.speed_rad_s = state->speed_rad_s;
    span.input = segment->forces.input;
    span.input_rise = segment->input_rise;
    span.torque_Nm = segment->forces.torque_Nm + located->regime.saturated_Nm;
    span.torque_rise_Nm = segment->torque_rise_Nm;
    span.span_s = span_s;
    span.torque_gain_Nm_per_A = saturated ? EMA_R(0.0) : plant->motor.torque_constant_Nm_per_A;
    span.at_rest = state->motion == 0;
    span.current_held = located->regime.held;
    if (span.current_held && circuit->algebraic) {
        span.current_A = ema_clamp((circuit->rate_speed * state->speed_rad_s) + (circuit->rate_voltage * span.input), -plant->drive.current_limit_A, plant->drive.current_limit_A);
    }
    ema_series_build(&located->series, plant, circuit, &span);
    located->segment.end.current_A = ema_series_at(located->series.current_A, EMA_R(1.0));
    located->segment.end.speed_rad_s = ema_series_at(located->series.speed_rad_s, EMA_R(1.0));
    located->segment.end.angle_rad = state->angle_rad + ema_series_at(located->series.angle_rad, EMA_R(1.0));
    /* at rest the terms of the speed are free to hold those of the torque, which say when the shaft breaks away */
    if (span.at_rest) {
        for (uint32_t k = 0; k <= EMA_SERIES_TERMS; ++k) {
            located->series.speed_rad_s[k] = span.torque_gain_Nm_per_A * located->series.current_A[k];
        }
        located->series.speed_rad_s[0] += span.torque_Nm;
        located->series.speed_rad_s[1] += span.torque_rise_Nm;
    }
}

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

/* Crossings of +-bound by the current, from inside or from outside. */
static void ema_event_current(ema_event_t* event, ema_located_t* located, ema_real bound_A, bool outside)
{
    const ema_real end_A = located->segment.end.current_A;
    const ema_real start_A = located->series.current_A[0];
    if (outside) {
        const ema_real side_A = (start_A > EMA_R(0.0)) ? bound_A : -bound_A;
        if ((end_A * side_A) < (bound_A * bound_A)) {
            ema_event_take(event, EMA_EVENT_CURRENT, located->series.current_A, side_A, EMA_R(0.0));
        }
    } else if (ema_abs(end_A) > bound_A) {
        const ema_real side_A = (end_A > EMA_R(0.0)) ? bound_A : -bound_A;
        const ema_real from = (start_A == side_A) ? EMA_ROOT_FROM : EMA_R(0.0);
        const ema_real from_A = ema_series_at(located->series.current_A, from);
        if ((end_A > EMA_R(0.0)) ? (from_A < side_A) : (from_A > side_A)) {
            ema_event_take(event, EMA_EVENT_CURRENT, located->series.current_A, side_A, from);
        }
    } else {
        /* stays inside */
    }
}

/* A held current is let go when the circuit on its own would bring it inward. */
static void ema_event_release(ema_event_t* event, const ema_circuit_t* circuit, const ema_state_t* state, const ema_located_t* located)
{
    ema_real terms[EMA_SERIES_TERMS + 1U];
    for (uint32_t k = 0; k <= EMA_SERIES_TERMS; ++k) {
        terms[k] = (state->motion == 0) ? EMA_R(0.0) : (circuit->rate_speed * located->series.speed_rad_s[k]);
    }
    const ema_real held_A = located->series.current_A[0];
    terms[0] += (circuit->rate_current * held_A) + (circuit->rate_voltage * located->segment.forces.input);
    terms[1] += circuit->rate_voltage * located->segment.input_rise;
    if (circuit->algebraic) {
        terms[0] -= held_A;
    }
    if (((ema_series_at(terms, EMA_R(1.0)) * held_A) < EMA_R(0.0)) && ((terms[0] * held_A) > EMA_R(0.0))) {
        ema_event_take(event, EMA_EVENT_RELEASE, terms, EMA_R(0.0), EMA_R(0.0));
    }
}

static void ema_event_at_rest(ema_event_t* event, const ema_plant_t* plant, const ema_state_t* state, ema_located_t* located)
{
    const ema_forces_t* const forces = &located->segment.forces;
    ema_real* const torque_Nm = located->series.speed_rad_s;
    /* a current that follows the voltage at once can break away at the very start */
    const ema_motion_t at_start = ema_screw_break_away(&plant->screw, state->angle_rad, torque_Nm[0], forces->level_forward_Nm, forces->level_backward_Nm);
    const ema_motion_t at_end = ema_screw_break_away(&plant->screw, state->angle_rad, ema_series_at(torque_Nm, EMA_R(1.0)), forces->level_forward_Nm, forces->level_backward_Nm);
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
static void ema_event_reversal(ema_event_t* event, const ema_state_t* state, ema_located_t* located)
{
    const ema_real direction = (ema_real)state->motion;
    ema_real* const speed_rad_s = located->series.speed_rad_s;
    const ema_real from = (state->speed_rad_s == EMA_R(0.0)) ? EMA_ROOT_FROM : EMA_R(0.0);
    if (!((direction * located->segment.end.speed_rad_s) > EMA_R(0.0))) {
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
static void ema_event_stop(ema_event_t* event, const ema_plant_t* plant, const ema_state_t* state, ema_located_t* located)
{
    const ema_real end_rad = located->segment.end.angle_rad;
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
        const ema_event_t before = *event;
        ema_event_take(event, EMA_EVENT_STOP, located->series.angle_rad, stop_rad - state->angle_rad, EMA_R(0.0));
        if (event->at != before.at) {
            event->value = stop_rad;
        }
    }
}

static ema_event_t ema_event_find(const ema_plant_t* plant, const ema_circuit_t* circuit, const ema_state_t* state, ema_located_t* located)
{
    ema_event_t event = {EMA_EVENT_NONE, EMA_R(1.0), EMA_R(0.0)};
    if (located->regime.held) {
        ema_event_release(&event, circuit, state, located);
    } else {
        ema_event_current(&event, located, plant->drive.current_limit_A, false);
        ema_event_current(&event, located, plant->torque_limit_A, located->regime.saturated_Nm != EMA_R(0.0));
    }
    if (state->motion == 0) {
        ema_event_at_rest(&event, plant, state, located);
    } else {
        if (state->motion != (int32_t)EMA_MOTION_ELASTIC) {
            ema_event_reversal(&event, state, located);
        }
        ema_event_stop(&event, plant, state, located);
    }
    return event;
}

/* Moves the state to the fraction `at` of the span. */
static void ema_motion_to(const ema_plant_t* plant, ema_state_t* state, const ema_series_t* series, ema_real at)
{
    state->current_A = ema_series_at(series->current_A, at);
    if (state->motion != 0) {
        state->speed_rad_s = ema_series_at(series->speed_rad_s, at);
        ema_turn(plant, state, ema_series_at(series->angle_rad, at));
    }
}

/* The speed is zero: dry friction holds the shaft, or it reverses at once. */
static void ema_motion_rest(const ema_plant_t* plant, ema_state_t* state, const ema_drive_output_t* applied)
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
    ema_screw_play(&plant->screw, state, plant->gearbox.lead_mm_per_rad * state->angle_rad);
    state->speed_rad_s = EMA_R(0.0);
    state->motion = (int32_t)EMA_MOTION_STUCK;
    const ema_point_t here = {state->current_A, EMA_R(0.0), state->angle_rad};
    const ema_forces_t forces = ema_forces_at(plant, state, applied, &here);
    const ema_real torque_Nm = forces.torque_Nm + ema_motor_torque(&plant->motor, state->current_A);
    state->motion = (int32_t)ema_screw_break_away(&plant->screw, state->angle_rad, torque_Nm, forces.level_forward_Nm, forces.level_backward_Nm);
}

/* How a shaft moves once it has left its rest. */
static int32_t ema_motion_left(const ema_plant_t* plant, ema_motion_t direction)
{
    return (plant->active.presliding != 0U) ? (int32_t)EMA_MOTION_ELASTIC : (int32_t)direction;
}

static void ema_event_apply(const ema_plant_t* plant, ema_state_t* state, const ema_drive_output_t* applied, const ema_event_t* event)
{
    switch (event->kind) {
    case EMA_EVENT_REST:
        ema_motion_rest(plant, state, applied);
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

/* One integration step with its events, each located. */
static void ema_motion_events(const ema_plant_t* plant, const ema_circuit_t* circuit, ema_state_t* state, const ema_drive_output_t* applied, ema_real span_s)
{
    ema_real left_s = span_s;
    uint32_t events = 0U;
    bool done = false;
    ema_event_t event = {EMA_EVENT_NONE, EMA_R(0.0), EMA_R(0.0)};
    ema_regime_t regime = {false, EMA_R(0.0), EMA_R(0.0)};
    while (!done && (events < EMA_EVENTS_MAX)) {
        ema_located_t located;
        located.segment = ema_segment_open(plant, state, applied, left_s);
        regime = ema_regime_of(plant, circuit, state, located.segment.forces.input, &event, &regime);
        located.regime = regime;
        ema_located_build(plant, state, circuit, left_s, &located);
        if (plant->active.any) {
            ema_segment_correct(plant, state, applied, left_s, &located.segment);
            ema_located_build(plant, state, circuit, left_s, &located);
        }
        event = ema_event_find(plant, circuit, state, &located);
        ema_motion_to(plant, state, &located.series, event.at);
        /* an excursion beyond the limit that another event cuts short is not located */
        if (ema_abs(state->current_A) > plant->drive.current_limit_A) {
            state->current_A = ema_clamp(state->current_A, -plant->drive.current_limit_A, plant->drive.current_limit_A);
        }
        ema_event_apply(plant, state, applied, &event);
        if (event.kind == EMA_EVENT_NONE) {
            done = true;
        } else {
            left_s -= left_s * event.at;
            ++events;
            done = !(left_s > EMA_R(0.0));
        }
    }
    if (!done) {
        state->speed_rad_s = EMA_R(0.0);
        state->motion = ema_motion_left(plant, EMA_MOTION_STUCK);
        ++state->crowded_steps;
    }
}

/* Moves the rod behind the play over an integration step. */
static void ema_transmission_move(const ema_plant_t* plant, ema_state_t* state, ema_real play_start_mm, ema_real span_s)
{
    if (plant->active.transmission != 0U) {
        ema_screw_play(&plant->screw, state, plant->gearbox.lead_mm_per_rad * state->angle_rad);
        const ema_transmission_t step = {play_start_mm, state->play_mm, span_s, plant->gearbox.lead_mm_per_rad};
        const ema_rod_t rod = ema_site_transmission(plant, &step, state->effect_memory);
        state->rod_mm = rod.rod_mm;
        state->rod_speed_mm_s = rod.rod_speed_mm_s;
    }
}

void ema_motion_located(const ema_plant_t* plant, ema_state_t* state, const ema_drive_output_t* applied, ema_real span_s)
{
    const ema_circuit_t* const circuit = applied->current_loop ? &plant->current_loop : &plant->motor_circuit;
    const ema_real play_start_mm = state->play_mm;
    /* the prepared responses hold for a whole integration step alone */
    const bool whole = span_s == plant->substep_s;
    if (!plant->active.any || !whole || !ema_motion_smooth(plant, circuit, state, applied, span_s, false)) {
        ema_motion_events(plant, circuit, state, applied, span_s);
    }
    ema_transmission_move(plant, state, play_start_mm, span_s);
}

bool ema_motion_whole(const ema_plant_t* plant, ema_state_t* state, const ema_drive_output_t* applied)
{
    const ema_real play_start_mm = state->play_mm;
    /* the whole step is prepared for the circuit of the drive's mode alone */
    const bool whole = (applied->current_loop == plant->drive.current_mode) && ema_motion_smooth(plant, &plant->whole_step, state, applied, plant->step_s, true);
    if (whole) {
        ema_transmission_move(plant, state, play_start_mm, plant->step_s);
    }
    return whole;
}

void ema_motion_part(const ema_plant_t* plant, ema_state_t* state, const ema_drive_output_t* applied, ema_real part)
{
    const ema_real span_s = part * plant->substep_s;
    for (uint32_t k = 0; k < plant->substeps; ++k) {
        ema_motion_located(plant, state, applied, span_s);
    }
}
