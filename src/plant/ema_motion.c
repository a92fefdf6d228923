#include "plant/ema_motion.h"

#include <stddef.h>

#include "base/ema_compiler.h"
#include "base/ema_math.h"
#include "blocks/ema_mechanics.h"
#include "effects/ema_effect_sites.h"
#include "effects/ema_effect_sums.h"

/* Speed as the forces see it: past a reversal that is not located yet the friction keeps the direction of the motion.
 */
static ema_real ema_force_speed(int32_t motion, ema_real speed_rad_s)
{
    ema_real kept_rad_s = speed_rad_s;
    if (motion == (int32_t)EMA_MOTION_FORWARD) {
        kept_rad_s = ema_max(speed_rad_s, EMA_R(0.0));
    } else if (motion == (int32_t)EMA_MOTION_BACKWARD) {
        kept_rad_s = ema_min(speed_rad_s, EMA_R(0.0));
    } else {
        /* at rest there is none, and an elastic contact has no direction to keep */
    }
    return kept_rad_s;
}

/* Sites that most machines have no effect at, in the two groups that are passed by together. */
#define EMA_SITES_OF_INPUT                                                                                             \
    (((uint32_t)1 << (uint32_t)EMA_SITE_VOLTAGE) | ((uint32_t)1 << (uint32_t)EMA_SITE_WINDING)                         \
     | ((uint32_t)1 << (uint32_t)EMA_SITE_LOAD))
#define EMA_SITES_OF_SHAFT (((uint32_t)1 << (uint32_t)EMA_SITE_GREASE) | ((uint32_t)1 << (uint32_t)EMA_SITE_MOTOR))

/* Dry friction against the site's direction. */
static ema_real ema_level(const ema_plant_t* plant, uint32_t sites, const ema_site_t* site, ema_real level_Nm,
                          ema_real load_Nm)
{
    const ema_real own_Nm = ema_screw_level(&plant->screw, level_Nm, site->direction);
    ema_real total_Nm = own_Nm;
    if (load_Nm != EMA_R(0.0)) {
        total_Nm += ema_gearbox_lost(&plant->gearbox, load_Nm, site->direction);
    }
    if (ema_acts_among(sites, EMA_SITE_GREASE)) {
        total_Nm += site->grease * own_Nm;
    }
    if (ema_acts_among(sites, EMA_SITE_FRICTION)) {
        total_Nm += ema_site_friction(plant, site, own_Nm);
    }
    return ema_max(total_Nm, EMA_R(0.0));
}

/* Torque of dry friction on a shaft that slides, or of a stretched contact, which an end of travel alone can hold at
 * rest; of a shaft that rests both levels. One place asks for a level, so that it is no call. */
static ema_real ema_dry_friction(const ema_plant_t* plant, uint32_t sites, const ema_state_t* state, ema_site_t* site,
                                 ema_real load_Nm, bool rests, ema_forces_t* forces)
{
    const ema_real kept_Nm = rests ? plant->screw.static_Nm : plant->screw.dynamic_Nm;
    ema_real share = rests ? EMA_R(1.0) : (ema_real)state->motion;
    site->direction = share;
    if (ema_acts_among(sites, EMA_SITE_PRESLIDING)) {
        share = ema_site_presliding(plant, state->effect_memory, site->angle_rad - state->angle_rad);
        site->direction = (share < EMA_R(0.0)) ? EMA_R(-1.0) : EMA_R(1.0);
    }
    ema_real level_Nm = EMA_R(0.0);
    /* forward, then backward, or the one way that it slides */
    uint32_t k = 1U;
    if (rests) {
        k = 0U;
    }
    while (k < 2U) {
        level_Nm = ema_level(plant, sites, site, kept_Nm, load_Nm);
        if (k == 0U) {
            forces->level_forward_Nm = level_Nm;
            site->direction = EMA_R(-1.0);
        }
        ++k;
    }
    forces->level_backward_Nm = rests ? level_Nm : EMA_R(0.0);
    return -share * level_Nm;
}

EMA_NOINLINE void ema_forces_at(const ema_plant_t* plant, const ema_state_t* state, ema_step_scratch_t* work,
                                const ema_point_t* point)
{
    const bool starts = point == &work->segment.start;
    const ema_drive_output_t* const applied = &work->applied;
    ema_forces_t* const forces = &work->forces;
    ema_site_t site = {plant,
                       ema_force_speed(state->motion, point->speed_rad_s),
                       point->angle_rad,
                       plant->gearbox.lead_mm_per_rad * point->angle_rad,
                       point->current_A,
                       applied->input,
                       EMA_R(0.0),
                       EMA_R(0.0)};
    const uint32_t sites = plant->active.sites;
    /* kept out of the structure: each call would have them written and read again */
    ema_real input = applied->input;
    ema_real load_Nm = plant->screw.load_torque_Nm;
    if (((uint32_t)EMA_SITES_HELD & sites & EMA_SITES_OF_INPUT) != 0U) {
        if (!ema_drive_follows(applied) && ema_acts_among(sites, EMA_SITE_VOLTAGE)) {
            input += ema_site_voltage(plant, &site);
        }
        if (!ema_drive_follows(applied) && ema_acts_among(sites, EMA_SITE_WINDING)) {
            /* it warms between steps alone */
            if (starts) {
                work->winding_ohm = ema_site_winding(plant, state->effect_memory) * plant->motor.resistance_ohm;
            }
            input -= work->winding_ohm * site.current_A;
        }
        if (ema_acts_among(sites, EMA_SITE_LOAD)) {
            load_Nm += ema_site_load(plant, &site);
        }
    }
    ema_real torque_Nm = -load_Nm;
    if (ema_acts_among(sites, EMA_SITE_TORQUE)) {
        torque_Nm += ema_site_torque(plant, &site);
    }
    if (((uint32_t)EMA_SITES_HELD & sites & EMA_SITES_OF_SHAFT) != 0U) {
        if (ema_acts_among(sites, EMA_SITE_GREASE)) {
            site.grease = ema_site_grease(plant, state->effect_memory);
            torque_Nm -= (site.grease * plant->screw.viscous_Nm_s_per_rad) * site.speed_rad_s;
        }
        if (ema_acts_among(sites, EMA_SITE_MOTOR)) {
            const ema_real change = ema_site_motor(plant, &site);
            const ema_real changed_A = (EMA_R(1.0) + change) * site.current_A;
            /* the limit holds for the torque with its change */
            torque_Nm += ema_motor_torque(&plant->motor, changed_A) - ema_motor_torque(&plant->motor, site.current_A);
            input -= ema_drive_follows(applied) ? EMA_R(0.0)
                                                : (change * plant->motor.back_emf_V_s_per_rad * point->speed_rad_s);
        }
    }
    /* a shaft at rest breaks away by the levels at the start */
    const bool rests = (state->motion == (int32_t)EMA_MOTION_STUCK) && !ema_acts_among(sites, EMA_SITE_PRESLIDING);
    ema_real friction_Nm = work->segment.forces.level_forward_Nm;
    if (starts || (!rests && ema_friction_varies(sites))) {
        friction_Nm = ema_dry_friction(plant, sites, state, &site, load_Nm, rests, forces);
    }
    if (!rests) {
        forces->level_forward_Nm = friction_Nm;
        torque_Nm += friction_Nm;
    }
    forces->input = input;
    forces->torque_Nm = torque_Nm;
}

EMA_NOINLINE void ema_segment_open(const ema_plant_t* plant, const ema_state_t* state, ema_step_scratch_t* work)
{
    ema_segment_t* const segment = &work->segment;
    ema_span_t* const span = &work->span;
    span->current_A = state->current_A;
    span->speed_rad_s = state->speed_rad_s;
    segment->start.current_A = state->current_A;
    segment->start.speed_rad_s = state->speed_rad_s;
    segment->start.angle_rad = state->angle_rad;
    work->spent += plant->forces_work;
    ema_forces_at(plant, state, work, &segment->start);
    /* one by one: a copy of the whole waits for the writes to its parts */
    const ema_real input = work->forces.input;
    const ema_real torque_Nm = work->forces.torque_Nm;
    segment->forces.input = input;
    segment->forces.torque_Nm = torque_Nm;
    segment->forces.level_forward_Nm = work->forces.level_forward_Nm;
    segment->forces.level_backward_Nm = work->forces.level_backward_Nm;
    span->input = input;
    span->torque_Nm = torque_Nm;
    segment->end.current_A = EMA_R(0.0);
    segment->end.speed_rad_s = EMA_R(0.0);
    segment->turn_rad = EMA_R(0.0);
    span->input_rise = EMA_R(0.0);
    span->torque_rise_Nm = EMA_R(0.0);
}

EMA_NOINLINE void ema_segment_correct(const ema_plant_t* plant, const ema_state_t* state, ema_step_scratch_t* work)
{
    ema_segment_t* const segment = &work->segment;
    ema_span_t* const span = &work->span;
    ema_real reaction_Nm = EMA_R(0.0);
    span->torque_Nm = EMA_R(0.0);
    if (ema_acts(plant, EMA_SITE_TRANSMISSION)) {
        const ema_real play_end_mm =
            ema_screw_play_at(&plant->screw, state->play_mm, plant->gearbox.lead_mm_per_rad * segment->end.angle_rad);
        ema_site_transmission_trial(plant, state, play_end_mm, work->span_s, &work->rod);
        span->torque_Nm = work->rod.reaction_start_Nm;
        segment->forces.torque_Nm += span->torque_Nm;
        reaction_Nm = work->rod.reaction_end_Nm;
    }
    work->spent += plant->forces_work;
    ema_forces_at(plant, state, work, &segment->end);
    span->torque_rise_Nm = (work->forces.torque_Nm + reaction_Nm) - segment->forces.torque_Nm;
    span->input_rise = work->forces.input - segment->forces.input;
}

EMA_NOINLINE void ema_segment_respond(int32_t motion, ema_step_scratch_t* work, uint32_t from, uint32_t to)
{
    const ema_responses_t* const responses = work->responses;
    const ema_real* const current = (const ema_real*)(const void*)&responses->current; /* EMA-D4 */
    const ema_real* const speed = (const ema_real*)(const void*)&responses->speed;     /* EMA-D4 */
    const ema_real* const angle = (const ema_real*)(const void*)&responses->angle;     /* EMA-D4 */
    const ema_real* const stuck = &responses->stuck_from_current;
    const ema_real* const driven = (const ema_real*)(const void*)&work->span; /* EMA-D4 */
    ema_segment_t* const segment = &work->segment;
    ema_real current_A = segment->end.current_A;
    if (motion != (int32_t)EMA_MOTION_STUCK) {
        ema_real speed_rad_s = segment->end.speed_rad_s;
        ema_real turn_rad = segment->turn_rad;
        uint32_t k = from;
        do {
            const ema_real drive = driven[k];
            current_A += current[k] * drive;
            speed_rad_s += speed[k] * drive;
            turn_rad += angle[k] * drive;
            ++k;
        } while (k < to);
        segment->end.speed_rad_s = speed_rad_s;
        segment->turn_rad = turn_rad;
    } else {
        /* torques drive nothing */
        for (uint32_t k = (from + 1U) / 2U; k < (to / 2U); ++k) {
            current_A += stuck[k] * driven[(size_t)2U * k];
        }
    }
    segment->end.current_A = current_A;
    segment->end.angle_rad = segment->start.angle_rad + segment->turn_rad;
}

/* How far the forces inside a step may be off an even rise to be taken for one, as a share of the torques at work; and
 * off the polynomial through four points where they are not even. Of the voltage a quarter as much, which has no twist.
 * What rises or twists more than is tame may be a ripple too fast for so few points, and has to fit at more. */
#define EMA_TOL_LINEAR EMA_R(1.0e-5)
#define EMA_TOL_POLYNOMIAL EMA_R(1.0e-3)
#define EMA_TOL_TWIST EMA_R(1.0e-3)
#define EMA_SHARE_OF_INPUT EMA_R(0.25)

/* A torque that bends by less than this share of its rise, and hardly twists, is no ripple too fast for four points;
 * and what the polynomial leaves of its bend, be it a kink, is less than the second share of it. */
#define EMA_TOL_BEND EMA_R(0.25)
#define EMA_TOL_BEND_RESIDUAL EMA_R(0.1)

/* Bend and twist, as in ema_response_t, of what is off an even rise at the nodes. */
#define EMA_BEND_OF_SUM EMA_R(2.5)
#define EMA_TWIST_OF_DIFFERENCE EMA_R(5.590169943749474)

/* A fraction s of a segment, there s (1 - s), and the integral of that up to there. */
typedef struct {
    ema_real at;
    ema_real bubble;
    ema_real turn;
} ema_node_t;

/* The inner two of the four points of Lobatto's rule, which integrates fifth powers; and two to look at afterwards: one
 * that shows an end that was predicted badly as well as what is left between the four, and the middle. */
static const ema_node_t ema_nodes[4] = {
    {EMA_R(0.27639320225002101), EMA_R(0.19999999999999998), EMA_R(0.03115841385833824)},
    {EMA_R(0.72360679774997894), EMA_R(0.20000000000000001), EMA_R(0.1355082528083284)},
    {EMA_R(0.90000000000000002), EMA_R(0.089999999999999983), EMA_R(0.16200000000000001)},
    {EMA_R(0.5), EMA_R(0.25), EMA_R(0.083333333333333329)},
};

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
    work->spent += k * plant->forces_work;
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

EMA_NOINLINE void ema_motion_span(const ema_plant_t* plant, ema_state_t* state, ema_step_scratch_t* work,
                                  const ema_responses_t* responses, ema_real span_s)
{
    work->spent += plant->step_work;
    work->responses = responses;
    if (!ema_tries_whole(plant) || !ema_motion_try(plant, state, work, span_s, true)) {
        for (uint32_t k = 0; k < plant->substeps; ++k) {
            ema_motion_located(plant, state, work, span_s / (ema_real)plant->substeps);
        }
    }
}

EMA_NOINLINE void ema_delayed_output(const ema_plant_t* plant, ema_state_t* state, ema_step_scratch_t* work,
                                     ema_real output)
{
    state->delay_output[state->step & (EMA_DELAY_SAMPLES - 1U)] = output;
    const bool parted = plant->drive.delay_part > EMA_R(0.0);
    ema_drive_late(plant, state, plant->drive.delay_steps + (parted ? 1U : 0U), &work->applied);
}

void ema_delayed_step(const ema_plant_t* plant, ema_state_t* state, ema_step_scratch_t* work)
{
    const ema_real first_s = plant->drive.delay_part * plant->step_s;
    if (first_s > EMA_R(0.0)) {
        ema_motion_span(plant, state, work, &plant->responses[0], first_s);
        ema_drive_late(plant, state, plant->drive.delay_steps, &work->applied);
        ema_drive_current(plant, state, &work->applied);
    }
    ema_motion_span(plant, state, work, &plant->responses[1], plant->step_s - first_s);
}
