#include "ema_motion.h"

#include "ema_effect_sites.h"
#include "ema_forces.h"
#include "ema_math.h"

/* How far the forces inside a step may be off an even rise, as a share of the torques at work, or of the voltage: far
 * below what an effect that can be seen makes. */
#define EMA_UNEVEN EMA_R(5.0e-5)
#define EMA_UNEVEN_INPUT EMA_R(1.0e-4)

static ema_real ema_response_rise(const ema_response_t* response, const ema_segment_t* segment)
{
    return ema_response_at(response, segment->start.current_A, segment->start.speed_rad_s, segment->forces.input,
                           segment->forces.torque_Nm)
           + ((response->from_voltage_rise * segment->input_rise)
              + (response->from_torque_rise * segment->torque_rise_Nm));
}

/* End of the segment from the prepared responses; answers the angle moved. */
static ema_real ema_segment_respond(const ema_circuit_t* circuit, int32_t motion, ema_segment_t* segment)
{
    ema_real turn_rad = EMA_R(0.0);
    if (motion != 0) {
        turn_rad = ema_response_rise(&circuit->angle, segment);
        segment->end.current_A = ema_response_rise(&circuit->current, segment);
        segment->end.speed_rad_s = ema_response_rise(&circuit->speed, segment);
        segment->end.angle_rad = segment->start.angle_rad + turn_rad;
    } else {
        segment->end.current_A = (circuit->stuck_from_current * segment->start.current_A)
                                 + (circuit->stuck_from_voltage * segment->forces.input)
                                 + (circuit->stuck_from_voltage_rise * segment->input_rise);
    }
    return turn_rad;
}

void ema_motion_turn(const ema_plant_t* plant, ema_state_t* state, ema_real turn_rad)
{
    if (state->motion == (int32_t)EMA_MOTION_ELASTIC) {
        ema_site_presliding_keep(plant, state->effect_memory,
                                 ema_site_presliding(plant, state->effect_memory, turn_rad));
    }
    ema_add_compensated(&state->angle_rad, &state->angle_low_rad, turn_rad);
}

/* Current at the fraction `at` of the segment, from its values and rates at both ends: forces that follow the current
 * bend with it. */
static ema_real ema_segment_current(const ema_work_t* work, ema_real at)
{
    const ema_circuit_t* const circuit = work->circuit;
    const ema_segment_t* const segment = &work->segment;
    const ema_real change_A = segment->start.current_A - segment->end.current_A;
    const ema_real slowing_rad_s = segment->start.speed_rad_s - segment->end.speed_rad_s;
    const ema_real bend_A_s = (circuit->rate_current * change_A) + (circuit->rate_speed * slowing_rad_s)
                              - (circuit->rate_voltage * segment->input_rise);
    const ema_real even_A = segment->start.current_A - (at * change_A);
    return circuit->algebraic ? even_A : (even_A + (EMA_R(0.5) * at * (EMA_R(1.0) - at) * work->span_s * bend_A_s));
}

/* Whether the forces at the fraction `at` are those of an even rise, nearly. */
static bool ema_segment_even_at(const ema_plant_t* plant, const ema_state_t* state, ema_work_t* work, ema_real at)
{
    const ema_segment_t* const segment = &work->segment;
    const ema_real gained_rad_s = at * (segment->end.speed_rad_s - segment->start.speed_rad_s);
    const ema_point_t here = {ema_segment_current(work, at), segment->start.speed_rad_s + gained_rad_s,
                              segment->start.angle_rad
                                  + (at * work->span_s * (segment->start.speed_rad_s + (EMA_R(0.5) * gained_rad_s)))};
    ema_forces_at(plant, state, work, &here);
    const ema_real torque_Nm =
        plant->screw.static_Nm + ema_abs(plant->motor.torque_constant_Nm_per_A * segment->start.current_A);
    const ema_real torque_off_Nm =
        work->forces.torque_Nm - (segment->forces.torque_Nm + (at * segment->torque_rise_Nm));
    const ema_real input_off = work->forces.input - (segment->forces.input + (at * segment->input_rise));
    return (ema_abs(torque_off_Nm) <= (EMA_UNEVEN * torque_Nm))
           && (ema_abs(input_off) <= (EMA_UNEVEN_INPUT * ema_abs(work->applied.input)));
}

/* Whether an even rise stands for the whole segment: it does at two points, between which a ripple cannot hide. An
 * elastic contact forgets which way it was stretched, so a turning point inside is too much for it. */
static bool ema_segment_even(const ema_plant_t* plant, const ema_state_t* state, ema_work_t* work)
{
    const bool turns = (state->motion == (int32_t)EMA_MOTION_ELASTIC)
                       && !((work->segment.start.speed_rad_s * work->segment.end.speed_rad_s) > EMA_R(0.0));
    return !turns && ema_segment_even_at(plant, state, work, EMA_R(0.5))
           && ema_segment_even_at(plant, state, work, EMA_R(0.1875));
}

/* One integration step with effects but without an event, by the work's circuit over its span; false, and nothing
 * changed, when something would happen, or, with `even`, when the effects do not rise evenly over it. */
static bool ema_motion_smooth(const ema_plant_t* plant, ema_state_t* state, ema_work_t* work, bool even)
{
    if (!(ema_abs(state->current_A) < plant->linear_current_A)) {
        return false;
    }
    ema_segment_t* const segment = &work->segment;
    ema_segment_open(plant, state, work);
    (void)ema_segment_respond(work->circuit, state->motion, segment);
    ema_segment_correct(plant, state, work);
    const ema_real turn_rad = ema_segment_respond(work->circuit, state->motion, segment);

    bool smooth = ema_abs(segment->end.current_A) <= plant->linear_current_A;
    if (state->motion != (int32_t)EMA_MOTION_STUCK) {
        const bool keeps = (state->motion == (int32_t)EMA_MOTION_ELASTIC)
                           || (((ema_real)state->motion * segment->end.speed_rad_s) > EMA_R(0.0));
        smooth = smooth && keeps && (segment->end.angle_rad < plant->screw.stop_upper_rad)
                 && (segment->end.angle_rad > plant->screw.stop_lower_rad);
    } else {
        const ema_real gain = plant->motor.torque_constant_Nm_per_A;
        const ema_real first_Nm = segment->forces.torque_Nm + (gain * segment->start.current_A);
        const ema_real last_Nm = segment->forces.torque_Nm + segment->torque_rise_Nm + (gain * segment->end.current_A);
        smooth = smooth && (ema_max(first_Nm, last_Nm) <= segment->forces.level_forward_Nm)
                 && (ema_min(first_Nm, last_Nm) >= -segment->forces.level_backward_Nm);
    }
    smooth = smooth && (!even || ema_segment_even(plant, state, work));
    if (smooth) {
        state->current_A = segment->end.current_A;
        state->speed_rad_s = segment->end.speed_rad_s;
        ema_motion_turn(plant, state, turn_rad);
    }
    return smooth;
}

/* Moves the rod behind the play over an integration step. */
static void ema_transmission_move(const ema_plant_t* plant, ema_state_t* state, ema_work_t* work,
                                  ema_real play_start_mm, ema_real span_s)
{
    if (ema_acts(plant, EMA_SITE_TRANSMISSION)) {
        ema_screw_play_keep(&plant->screw, state, plant->gearbox.lead_mm_per_rad * state->angle_rad);
        const ema_transmission_t step = {play_start_mm, state->play_mm, span_s, plant->gearbox.lead_mm_per_rad};
        ema_site_transmission(plant, &step, state->effect_memory, &work->rod);
        state->rod_mm = work->rod.rod_mm;
        state->rod_speed_mm_s = work->rod.rod_speed_mm_s;
    }
}

void ema_motion_located(const ema_plant_t* plant, ema_state_t* state, ema_work_t* work, ema_real span_s)
{
    const ema_real play_start_mm = state->play_mm;
    /* the prepared responses hold for a whole integration step alone */
    const bool whole = span_s == plant->substep_s;
    work->circuit = ema_circuit_of(plant, &work->applied);
    work->span_s = span_s;
    if (!ema_acts_on_motion(plant) || !whole || !ema_motion_smooth(plant, state, work, false)) {
        ema_motion_events(plant, state, work);
    }
    ema_transmission_move(plant, state, work, play_start_mm, span_s);
}

bool ema_motion_whole(const ema_plant_t* plant, ema_state_t* state, ema_work_t* work)
{
    const ema_real play_start_mm = state->play_mm;
    work->circuit = &plant->whole_step;
    work->span_s = plant->step_s;
    /* the whole step is prepared for the circuit of the drive's mode alone */
    const bool whole =
        (work->applied.current_loop == plant->drive.current_mode) && ema_motion_smooth(plant, state, work, true);
    if (whole) {
        ema_transmission_move(plant, state, work, play_start_mm, plant->step_s);
    }
    return whole;
}
