#include "ema_motion.h"

#include "ema_effect_sites.h"
#include "ema_events.h"
#include "ema_gearbox.h"
#include "ema_math.h"
#include "ema_motor.h"

/* How far the forces inside a step may be off an even rise, as a share of the torques at work, or of the voltage: far below what an effect that can be seen makes. */
#define EMA_UNEVEN EMA_R(5.0e-5)
#define EMA_UNEVEN_INPUT EMA_R(1.0e-4)

static ema_real ema_level(const ema_plant_t* plant, const ema_site_t* site, ema_real level_Nm, ema_real load_Nm, ema_real direction)
{
    const ema_real own_Nm = ema_screw_level(&plant->screw, level_Nm, direction);
    ema_real total_Nm = own_Nm + ema_gearbox_loss(&plant->gearbox, load_Nm, direction);
    if (ema_acts(plant, EMA_SITE_FRICTION)) {
        total_Nm += ema_site_friction(plant, site, own_Nm);
    }
    return ema_max(total_Nm, EMA_R(0.0));
}

/* Torque of dry friction on a shaft that slides, or of a stretched contact, which an end of travel alone can hold at rest. */
static ema_real ema_sliding_friction(const ema_plant_t* plant, const ema_state_t* state, const ema_site_t* site, ema_real load_Nm)
{
    if (!ema_acts(plant, EMA_SITE_PRESLIDING)) {
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

static void ema_forces_at(const ema_plant_t* plant, const ema_state_t* state, const ema_drive_output_t* applied, const ema_point_t* point, ema_forces_t* forces)
{
    const ema_site_t site = {plant,
                             ema_force_speed(state->motion, point->speed_rad_s),
                             point->angle_rad,
                             plant->gearbox.lead_mm_per_rad * point->angle_rad,
                             point->current_A,
                             applied->current_loop ? applied->voltage_V : applied->input};
    forces->input = applied->input;
    forces->level_forward_Nm = EMA_R(0.0);
    forces->level_backward_Nm = EMA_R(0.0);
    if (!applied->current_loop && ema_acts(plant, EMA_SITE_VOLTAGE)) {
        forces->input += ema_site_voltage(plant, &site);
    }
    ema_real load_Nm = plant->screw.load_torque_Nm;
    if (ema_acts(plant, EMA_SITE_LOAD)) {
        load_Nm += ema_site_load(plant, &site);
    }
    forces->torque_Nm = -load_Nm;
    if (ema_acts(plant, EMA_SITE_TORQUE)) {
        forces->torque_Nm += ema_site_torque(plant, &site);
    }
    if (ema_acts(plant, EMA_SITE_MOTOR)) {
        const ema_real change = ema_site_motor(plant, &site);
        const ema_real changed_A = (EMA_R(1.0) + change) * site.current_A;
        /* the limit holds for the torque with its change */
        forces->torque_Nm += ema_motor_torque(&plant->motor, changed_A) - ema_motor_torque(&plant->motor, site.current_A);
        forces->input -= applied->current_loop ? EMA_R(0.0) : (change * plant->motor.back_emf_V_s_per_rad * point->speed_rad_s);
    }
    if ((state->motion == (int32_t)EMA_MOTION_STUCK) && !ema_acts(plant, EMA_SITE_PRESLIDING)) {
        forces->level_forward_Nm = ema_level(plant, &site, plant->screw.static_Nm, load_Nm, EMA_R(1.0));
        forces->level_backward_Nm = ema_level(plant, &site, plant->screw.static_Nm, load_Nm, EMA_R(-1.0));
    } else {
        forces->torque_Nm += ema_sliding_friction(plant, state, &site, load_Nm);
    }
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
static void ema_segment_open(const ema_plant_t* plant, const ema_state_t* state, const ema_drive_output_t* applied, ema_real span_s, ema_segment_t* segment)
{
    segment->start.current_A = state->current_A;
    segment->start.speed_rad_s = state->speed_rad_s;
    segment->start.angle_rad = state->angle_rad;
    segment->end = segment->start;
    ema_forces_at(plant, state, applied, &segment->start, &segment->forces);
    segment->input_rise = EMA_R(0.0);
    segment->torque_rise_Nm = EMA_R(0.0);
    if (ema_acts(plant, EMA_SITE_TRANSMISSION)) {
        segment->forces.torque_Nm += ema_transmission_trial(plant, state, state->play_mm, span_s).reaction_start_Nm;
    }
}

/* Lets the forces rise evenly to those at the predicted end. */
static void ema_segment_correct(const ema_plant_t* plant, const ema_state_t* state, const ema_drive_output_t* applied, ema_real span_s, ema_segment_t* segment)
{
    ema_forces_t forces;
    if (ema_acts(plant, EMA_SITE_TRANSMISSION)) {
        ema_forces_at(plant, state, applied, &segment->start, &forces);
        const ema_real play_end_mm = ema_screw_play_at(&plant->screw, state->play_mm, plant->gearbox.lead_mm_per_rad * segment->end.angle_rad);
        const ema_rod_t rod = ema_transmission_trial(plant, state, play_end_mm, span_s);
        segment->forces.torque_Nm = forces.torque_Nm + rod.reaction_start_Nm;
        ema_forces_at(plant, state, applied, &segment->end, &forces);
        segment->torque_rise_Nm = (forces.torque_Nm + rod.reaction_end_Nm) - segment->forces.torque_Nm;
    } else {
        ema_forces_at(plant, state, applied, &segment->end, &forces);
        segment->torque_rise_Nm = forces.torque_Nm - segment->forces.torque_Nm;
    }
    segment->input_rise = forces.input - segment->forces.input;
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
    ema_forces_t forces;
    ema_forces_at(plant, state, applied, &here, &forces);
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
    ema_segment_t segment;
    ema_segment_open(plant, state, applied, span_s, &segment);
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
    ema_forces_t forces;
    ema_forces_at(plant, state, applied, &here, &forces);
    const ema_real torque_Nm = forces.torque_Nm + ema_motor_torque(&plant->motor, state->current_A);
    state->motion = (int32_t)ema_screw_break_away(&plant->screw, state->angle_rad, torque_Nm, forces.level_forward_Nm, forces.level_backward_Nm);
}

/* How a shaft moves once it has left its rest. */
static int32_t ema_motion_left(const ema_plant_t* plant, ema_motion_t direction)
{
    return ema_acts(plant, EMA_SITE_PRESLIDING) ? (int32_t)EMA_MOTION_ELASTIC : (int32_t)direction;
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
    ema_segment_t segment;
    ema_event_t event = {EMA_EVENT_NONE, EMA_R(0.0), EMA_R(0.0), EMA_R(0.0), EMA_R(0.0), EMA_R(0.0)};
    ema_regime_t regime = {false, EMA_R(0.0), EMA_R(0.0)};
    while (!done && (events < EMA_EVENTS_MAX)) {
        ema_segment_open(plant, state, applied, left_s, &segment);
        regime = ema_regime_of(plant, circuit, state, segment.forces.input, &event, &regime);
        if (ema_acts_on_motion(plant)) {
            ema_segment_end(plant, circuit, state, &regime, left_s, &segment);
            ema_segment_correct(plant, state, applied, left_s, &segment);
        }
        ema_event_find(plant, circuit, state, &regime, left_s, &segment, &event);
        state->current_A = event.current_A;
        if (state->motion != (int32_t)EMA_MOTION_STUCK) {
            state->speed_rad_s = event.speed_rad_s;
            ema_turn(plant, state, event.turn_rad);
        }
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
    if (ema_acts(plant, EMA_SITE_TRANSMISSION)) {
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
    if (!ema_acts_on_motion(plant) || !whole || !ema_motion_smooth(plant, circuit, state, applied, span_s, false)) {
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
