#include "plant/ema_motion.h"

#include "base/ema_math.h"
#include "effects/ema_effect_sites.h"
#include "plant/ema_forces.h"
#include "plant/ema_resolve.h"

void ema_motion_turn(const ema_plant_t* plant, ema_state_t* state, ema_real turn_rad)
{
    ema_add_compensated(&state->angle_rad, &state->angle_low_rad, turn_rad);
    if (state->motion == (int32_t)EMA_MOTION_ELASTIC) {
        ema_site_presliding_keep(plant, state->effect_memory,
                                 ema_site_presliding(plant, state->effect_memory, turn_rad));
    }
}

/* Current and speed bend on their way to the segment's end by what their rates change from end to end. */
static void ema_segment_bow(const ema_plant_t* plant, const ema_state_t* state, ema_step_scratch_t* work)
{
    const ema_circuit_t* const circuit = work->circuit;
    ema_segment_t* const segment = &work->segment;
    const ema_real gained_A = segment->end.current_A - segment->start.current_A;
    const ema_real gained_rad_s = segment->end.speed_rad_s - segment->start.speed_rad_s;
    const ema_real half_s = EMA_R(0.5) * work->span_s;
    ema_real bend_rad_s = EMA_R(0.0);
    if (state->motion != (int32_t)EMA_MOTION_STUCK) {
        bend_rad_s = (half_s * plant->screw.inverse_inertia_per_kgm2)
                     * ((plant->screw.viscous_Nm_s_per_rad * gained_rad_s)
                        - (plant->motor.torque_constant_Nm_per_A * gained_A) - work->span.torque_rise_Nm);
    }
    segment->bend_rad_s = bend_rad_s;
    segment->bend_A = circuit->algebraic ? (circuit->rate_speed * bend_rad_s)
                                         : (-half_s
                                            * ((circuit->rate_current * gained_A) + (circuit->rate_speed * gained_rad_s)
                                               + (circuit->rate_voltage * work->span.input_rise)));
}

/* What the forces at the node are off an even rise, into the work's `forces`. */
static void ema_segment_off(const ema_plant_t* plant, const ema_state_t* state, ema_step_scratch_t* work,
                            const ema_node_t* node)
{
    ema_segment_t* const segment = &work->segment;
    const ema_real gained_A = segment->end.current_A - segment->start.current_A;
    const ema_real gained_rad_s = segment->end.speed_rad_s - segment->start.speed_rad_s;
    segment->between.current_A = segment->start.current_A + (node->at * gained_A) + (node->bubble * segment->bend_A);
    segment->between.speed_rad_s =
        segment->start.speed_rad_s + (node->at * gained_rad_s) + (node->bubble * segment->bend_rad_s);
    segment->between.angle_rad =
        segment->start.angle_rad
        + (work->span_s
           * ((node->at * (segment->start.speed_rad_s + (EMA_R(0.5) * node->at * gained_rad_s)))
              + (node->turn * segment->bend_rad_s)));
    ema_forces_at(plant, state, work, &segment->between);
    if (ema_acts(plant, EMA_SITE_TRANSMISSION)) {
        work->forces.torque_Nm +=
            work->rod.reaction_start_Nm + (node->at * (work->rod.reaction_end_Nm - work->rod.reaction_start_Nm));
    }
    work->forces.torque_Nm -= segment->forces.torque_Nm + (node->at * work->span.torque_rise_Nm);
    work->forces.input -= segment->forces.input + (node->at * work->span.input_rise);
}

static bool ema_segment_torque_within(const ema_step_scratch_t* work, ema_real torque_Nm, ema_real share)
{
    return ema_abs(torque_Nm) <= (share * work->segment.working_Nm);
}

static bool ema_segment_within(const ema_step_scratch_t* work, ema_real input, ema_real torque_Nm, ema_real share)
{
    return ema_segment_torque_within(work, torque_Nm, share)
           && (ema_abs(input) <= (EMA_SHARE_OF_INPUT * share * ema_abs(work->applied.input)));
}

/* From what the forces are off at the first node, which the span holds, and at the second: their bend and twist. How
 * many nodes say whether they are resolved by that. */
static uint32_t ema_segment_bend(const ema_state_t* state, ema_step_scratch_t* work)
{
    ema_span_t* const span = &work->span;
    const ema_forces_t* const here = &work->forces;
    const ema_real twists_Nm = here->torque_Nm - span->torque_bend_Nm;
    uint32_t nodes = 4U;
    if (ema_segment_torque_within(work, twists_Nm, EMA_TOL_TWIST)) {
        nodes = 3U;
        if ((state->motion != (int32_t)EMA_MOTION_ELASTIC)
            && (ema_abs(here->torque_Nm) <= (EMA_TOL_BEND * ema_abs(span->torque_rise_Nm)))
            && ema_segment_within(work, ema_max(ema_abs(span->input_bend), ema_abs(here->input)),
                                  EMA_TOL_BEND_RESIDUAL * here->torque_Nm, EMA_TOL_POLYNOMIAL)) {
            nodes = 2U;
        }
    }
    span->input_bend = EMA_BEND_OF_SUM * (span->input_bend + here->input);
    span->torque_bend_Nm = EMA_BEND_OF_SUM * (span->torque_bend_Nm + here->torque_Nm);
    span->torque_twist_Nm = EMA_TWIST_OF_DIFFERENCE * twists_Nm;
    ema_segment_respond(state->motion, work, 6U, EMA_RESPONSES);
    return nodes;
}

/* Whether nothing can be off an even rise by more than is taken for one: the laws of dry friction hang on a speed that
 * keeps its direction, or on a load or a place that a step hardly moves, and it is the same at both ends. */
static bool ema_segment_steady(const ema_plant_t* plant, const ema_step_scratch_t* work)
{
    return ema_friction_alone(plant) && ema_segment_torque_within(work, work->span.torque_rise_Nm, EMA_TOL_LINEAR);
}

/* Bends and twists the forces through those at the inner nodes; false where they are not resolved by that, which is
 * looked at where it can be. An elastic contact forgets which way it was stretched, so a turning point inside is too
 * much for it. */
static bool ema_segment_resolve(const ema_plant_t* plant, const ema_state_t* state, ema_step_scratch_t* work)
{
    ema_segment_t* const segment = &work->segment;
    const ema_forces_t* const here = &work->forces;
    ema_span_t* const span = &work->span;
    segment->working_Nm =
        plant->screw.static_Nm + ema_abs(plant->motor.torque_constant_Nm_per_A * segment->start.current_A);
    bool resolved = (state->motion != (int32_t)EMA_MOTION_ELASTIC)
                    || ((segment->start.speed_rad_s * segment->end.speed_rad_s) > EMA_R(0.0));
    uint32_t nodes = ema_segment_steady(plant, work) ? 0U : 2U;
    uint32_t k = 0U;
    for (; resolved && (k < nodes); ++k) {
        const ema_node_t* const node = &ema_nodes[k];
        /* the second node is on the first one's way */
        if (k != 1U) {
            ema_segment_bow(plant, state, work);
        }
        ema_segment_off(plant, state, work, node);
        if (k == 0U) {
            span->input_bend = here->input;
            span->torque_bend_Nm = here->torque_Nm;
            if (ema_segment_within(work, here->input, here->torque_Nm, EMA_TOL_LINEAR)
                && ema_segment_torque_within(work, span->torque_rise_Nm, EMA_TOL_TWIST)) {
                nodes = 1U;
            }
        } else if (k == 1U) {
            nodes = ema_segment_bend(state, work);
        } else {
            const ema_real bent_Nm =
                span->torque_bend_Nm + (((EMA_R(2.0) * node->at) - EMA_R(1.0)) * span->torque_twist_Nm);
            resolved = ema_segment_within(work, here->input - (node->bubble * span->input_bend),
                                          here->torque_Nm - (node->bubble * bent_Nm), EMA_TOL_POLYNOMIAL);
        }
    }
    work->spent += k * EMA_WORK_FORCES;
    return resolved;
}

/* A span by the work's responses; false, and nothing changed, when something would happen in it, or, with `whole`, when
 * the effects are not resolved over it. */
static bool ema_motion_smooth(const ema_plant_t* plant, ema_state_t* state, ema_step_scratch_t* work, bool whole)
{
    if (!(ema_abs(state->current_A) < plant->linear_current_A)) {
        return false;
    }
    ema_segment_t* const segment = &work->segment;
    ema_segment_open(plant, state, work);
    ema_segment_respond(state->motion, work, 0U, 4U);
    if (ema_acts_on_motion(plant)) {
        ema_segment_correct(plant, state, work);
        /* of a torque from the start on there is that of a mass behind the play, or none */
        ema_segment_respond(state->motion, work, ema_acts(plant, EMA_SITE_TRANSMISSION) ? 3U : 4U, EMA_RESPONSES_EVEN);
        if (whole && !ema_segment_resolve(plant, state, work)) {
            return false;
        }
    }

    bool smooth = ema_abs(segment->end.current_A) <= plant->linear_current_A;
    if (state->motion != (int32_t)EMA_MOTION_STUCK) {
        const bool keeps = (state->motion == (int32_t)EMA_MOTION_ELASTIC)
                           || (((ema_real)state->motion * segment->end.speed_rad_s) > EMA_R(0.0));
        smooth = smooth && keeps && (segment->end.angle_rad < plant->screw.stop_upper_rad)
                 && (segment->end.angle_rad > plant->screw.stop_lower_rad);
    } else {
        const ema_real gain = plant->motor.torque_constant_Nm_per_A;
        const ema_real first_Nm = segment->forces.torque_Nm + (gain * segment->start.current_A);
        const ema_real last_Nm =
            segment->forces.torque_Nm + work->span.torque_rise_Nm + (gain * segment->end.current_A);
        smooth = smooth && (ema_max(first_Nm, last_Nm) <= segment->forces.level_forward_Nm)
                 && (ema_min(first_Nm, last_Nm) >= -segment->forces.level_backward_Nm);
    }
    if (smooth) {
        state->current_A = segment->end.current_A;
        state->speed_rad_s = segment->end.speed_rad_s;
        ema_motion_turn(plant, state, segment->turn_rad);
    }
    return smooth;
}

/* A span by the work's responses, where there are any; false, and nothing changed, where it has to be taken event by
 * event, or in substeps. */
static bool ema_motion_try(const ema_plant_t* plant, ema_state_t* state, ema_step_scratch_t* work, ema_real span_s,
                           bool whole)
{
    work->circuit = ema_circuit_of(plant, &work->applied);
    work->span_s = span_s;
    const bool done = (work->responses != NULL) && ema_drive_keeps(&plant->drive, &work->applied)
                      && ema_motion_smooth(plant, state, work, whole);
    if (done && ema_acts(plant, EMA_SITE_TRANSMISSION)) {
        /* the play is as it was */
        ema_motion_rod(plant, state, work, state->play_mm, work->span_s);
    }
    return done;
}

void ema_motion_located(const ema_plant_t* plant, ema_state_t* state, ema_step_scratch_t* work, ema_real span_s)
{
    work->responses = (ema_acts_on_motion(plant) && !ema_drive_delays(&plant->drive)) ? &plant->responses[0] : NULL;
    /* events are found without the frame of a try below them */
    if (!ema_motion_try(plant, state, work, span_s, false)) {
        ema_motion_events(plant, state, work);
    }
}

void ema_motion_span(const ema_plant_t* plant, ema_state_t* state, ema_step_scratch_t* work,
                     const ema_responses_t* responses, ema_real span_s)
{
    ++work->spent;
    work->responses = responses;
    if (!ema_tries_whole(plant) || !ema_motion_try(plant, state, work, span_s, true)) {
        for (uint32_t k = 0; k < plant->substeps; ++k) {
            ema_motion_located(plant, state, work, span_s / (ema_real)plant->substeps);
        }
    }
}
