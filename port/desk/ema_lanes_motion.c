/* A span of the motion for all lanes at once, by the prepared responses: what ema_motion.c and ema_forces.c do under the
 * same names. Where nothing else is said, a lane that fails on its way is worked on to the end all the same: its numbers
 * are thrown away. */
#include <stddef.h>

#include "ema_effect_sites.h"
#include "ema_lanes.h"
#include "ema_motion.h"
#include "ema_motor.h"
#include "ema_resolve.h"
#include "ema_screw.h"

/* Places in `driven`: those of ema_response_t. */
enum {
    EMA_DRIVEN_CURRENT = 0,
    EMA_DRIVEN_SPEED = 1,
    EMA_DRIVEN_INPUT = 2,
    EMA_DRIVEN_TORQUE = 3,
    EMA_DRIVEN_INPUT_RISE = 4,
    EMA_DRIVEN_TORQUE_RISE = 5,
    EMA_DRIVEN_INPUT_BEND = 6,
    EMA_DRIVEN_TORQUE_BEND = 7,
    EMA_DRIVEN_TORQUE_TWIST = 8
};

static inline ema_real ema_flag(bool holds)
{
    return holds ? EMA_R(1.0) : EMA_R(0.0);
}

static ema_real ema_lanes_count(const ema_lane_t flag)
{
    ema_real count = EMA_R(0.0);
    EMA_EACH_LANE
    {
        count += flag[l];
    }
    return count;
}

/* Adds what drives by the responses in the columns `from` to `to`, in lanes where `wanted` is set. */
static inline void ema_lanes_respond(ema_lanes_t* lanes, const ema_lanes_responses_t* responses, const ema_lane_t wanted,
                                     uint32_t from, uint32_t to)
{
    ema_lanes_segment_t* const segment = &lanes->segment;
    EMA_EACH_LANE
    {
        const bool stuck = lanes->now.motion[l] == EMA_R(0.0);
        const bool want = wanted[l] != EMA_R(0.0);
        ema_real current_A = segment->end.current_A[l];
        ema_real stuck_A = segment->end.current_A[l];
        ema_real speed_rad_s = segment->end.speed_rad_s[l];
        ema_real turn_rad = segment->turn_rad[l];
        for (uint32_t k = from; k < to; ++k) {
            const ema_real drive = segment->driven[k][l];
            current_A += responses->current[k][l] * drive;
            speed_rad_s += responses->speed[k][l] * drive;
            turn_rad += responses->angle[k][l] * drive;
        }
        /* torques drive nothing */
        for (uint32_t k = (from + 1U) / 2U; k < (to / 2U); ++k) {
            stuck_A += responses->stuck[k][l] * segment->driven[2U * k][l];
        }
        current_A = stuck ? stuck_A : current_A;
        speed_rad_s = stuck ? segment->end.speed_rad_s[l] : speed_rad_s;
        turn_rad = stuck ? segment->turn_rad[l] : turn_rad;
        segment->end.current_A[l] = want ? current_A : segment->end.current_A[l];
        segment->end.speed_rad_s[l] = want ? speed_rad_s : segment->end.speed_rad_s[l];
        segment->turn_rad[l] = want ? turn_rad : segment->turn_rad[l];
        segment->end.angle_rad[l] = segment->start.angle_rad[l] + segment->turn_rad[l];
    }
}

static void ema_lanes_segment_open(ema_lanes_t* lanes)
{
    ema_lanes_segment_t* const segment = &lanes->segment;
    EMA_EACH_LANE
    {
        segment->start.current_A[l] = lanes->now.current_A[l];
        segment->start.speed_rad_s[l] = lanes->now.speed_rad_s[l];
        segment->start.angle_rad[l] = lanes->now.angle_rad[l];
    }
    ema_lanes_forces_at(lanes, &segment->start);
    EMA_EACH_LANE
    {
        segment->forces.input[l] = lanes->forces.input[l];
        segment->forces.torque_Nm[l] = lanes->forces.torque_Nm[l];
        segment->forces.level_forward_Nm[l] = lanes->forces.level_forward_Nm[l];
        segment->forces.level_backward_Nm[l] = lanes->forces.level_backward_Nm[l];
        segment->driven[EMA_DRIVEN_CURRENT][l] = segment->start.current_A[l];
        segment->driven[EMA_DRIVEN_SPEED][l] = segment->start.speed_rad_s[l];
        segment->driven[EMA_DRIVEN_INPUT][l] = segment->forces.input[l];
        segment->driven[EMA_DRIVEN_TORQUE][l] = segment->forces.torque_Nm[l];
        segment->driven[EMA_DRIVEN_INPUT_RISE][l] = EMA_R(0.0);
        segment->driven[EMA_DRIVEN_TORQUE_RISE][l] = EMA_R(0.0);
        segment->end.current_A[l] = EMA_R(0.0);
        segment->end.speed_rad_s[l] = EMA_R(0.0);
        segment->turn_rad[l] = EMA_R(0.0);
        segment->reaction_start_Nm[l] = EMA_R(0.0);
        segment->reaction_end_Nm[l] = EMA_R(0.0);
    }
}

/* What lies behind the play, tried over the span. */
static void ema_lanes_reaction(ema_lanes_t* lanes)
{
    ema_lanes_segment_t* const segment = &lanes->segment;
    EMA_EACH_LANE
    {
        const ema_plant_t* const plant = &lanes->plant[l];
        ema_state_t* const state = &lanes->state[l];
        ema_rod_t rod;
        state->play_mm = lanes->now.play_mm[l];
        const ema_real end_mm = ema_screw_play_at(&plant->screw, lanes->now.play_mm[l],
                                                  lanes->constant.lead_mm_per_rad[l] * segment->end.angle_rad[l]);
        ema_site_transmission_trial(plant, state, end_mm, segment->span_s[l], &rod);
        segment->reaction_start_Nm[l] = rod.reaction_start_Nm;
        segment->reaction_end_Nm[l] = rod.reaction_end_Nm;
        segment->forces.torque_Nm[l] += rod.reaction_start_Nm;
    }
}

static void ema_lanes_segment_correct(ema_lanes_t* lanes)
{
    ema_lanes_segment_t* const segment = &lanes->segment;
    if (ema_acts(&lanes->plant[0], EMA_SITE_TRANSMISSION)) {
        ema_lanes_reaction(lanes);
    }
    ema_lanes_forces_at(lanes, &segment->end);
    EMA_EACH_LANE
    {
        segment->driven[EMA_DRIVEN_TORQUE][l] = segment->reaction_start_Nm[l];
        segment->driven[EMA_DRIVEN_TORQUE_RISE][l] =
            (lanes->forces.torque_Nm[l] + segment->reaction_end_Nm[l]) - segment->forces.torque_Nm[l];
        segment->driven[EMA_DRIVEN_INPUT_RISE][l] = lanes->forces.input[l] - segment->forces.input[l];
    }
}

static void ema_lanes_segment_off(ema_lanes_t* lanes, const ema_node_t* node)
{
    const ema_lanes_plant_t* const constant = &lanes->constant;
    const ema_lanes_segment_t* const segment = &lanes->segment;
    const bool algebraic = lanes->plant[0].drive.current_mode ? lanes->plant[0].current_loop.algebraic
                                                              : lanes->plant[0].motor_circuit.algebraic;
    const bool transmits = ema_acts(&lanes->plant[0], EMA_SITE_TRANSMISSION);
    ema_lanes_point_t here;
    EMA_EACH_LANE
    {
        const ema_real gained_A = segment->end.current_A[l] - segment->start.current_A[l];
        const ema_real gained_rad_s = segment->end.speed_rad_s[l] - segment->start.speed_rad_s[l];
        const ema_real half_s = EMA_R(0.5) * segment->span_s[l];
        const ema_real moving_rad_s = (half_s * constant->inverse_inertia_per_kgm2[l])
                                      * ((constant->viscous_Nm_s_per_rad[l] * gained_rad_s)
                                         - (constant->torque_constant_Nm_per_A[l] * gained_A)
                                         - segment->driven[EMA_DRIVEN_TORQUE_RISE][l]);
        const ema_real bend_rad_s = (lanes->now.motion[l] != EMA_R(0.0)) ? moving_rad_s : EMA_R(0.0);
        const ema_real lags_A =
            -half_s
            * ((constant->rate_current[l] * gained_A) + (constant->rate_speed[l] * gained_rad_s)
               + (constant->rate_voltage[l] * segment->driven[EMA_DRIVEN_INPUT_RISE][l]));
        const ema_real bend_A = algebraic ? (constant->rate_speed[l] * bend_rad_s) : lags_A;
        here.current_A[l] = segment->start.current_A[l] + (node->at * gained_A) + (node->bubble * bend_A);
        here.speed_rad_s[l] = segment->start.speed_rad_s[l] + (node->at * gained_rad_s) + (node->bubble * bend_rad_s);
        here.angle_rad[l] =
            segment->start.angle_rad[l]
            + (segment->span_s[l]
               * ((node->at * (segment->start.speed_rad_s[l] + (EMA_R(0.5) * node->at * gained_rad_s)))
                  + (node->turn * bend_rad_s)));
    }
    ema_lanes_forces_at(lanes, &here);
    EMA_EACH_LANE
    {
        const ema_real reaction_Nm =
            segment->reaction_start_Nm[l]
            + (node->at * (segment->reaction_end_Nm[l] - segment->reaction_start_Nm[l]));
        const ema_real torque_Nm =
            transmits ? (lanes->forces.torque_Nm[l] + reaction_Nm) : lanes->forces.torque_Nm[l];
        lanes->forces.torque_Nm[l] =
            torque_Nm - (segment->forces.torque_Nm[l] + (node->at * segment->driven[EMA_DRIVEN_TORQUE_RISE][l]));
        lanes->forces.input[l] -=
            segment->forces.input[l] + (node->at * segment->driven[EMA_DRIVEN_INPUT_RISE][l]);
    }
}

static inline bool ema_lane_within(const ema_lanes_t* lanes, uint32_t l, ema_real input, ema_real torque_Nm,
                                   ema_real share)
{
    const ema_real working_Nm =
        lanes->constant.static_Nm[l]
        + ema_abs(lanes->constant.torque_constant_Nm_per_A[l] * lanes->segment.start.current_A[l]);
    const bool torque = ema_abs(torque_Nm) <= (share * working_Nm);
    const bool voltage = ema_abs(input) <= (EMA_SHARE_OF_INPUT * share * ema_abs(lanes->applied.input[l]));
    return torque && voltage;
}

/* Looks at a third or fourth node in lanes where `looks` is set. */
static void ema_lanes_look(ema_lanes_t* lanes, const ema_node_t* node, const ema_lane_t looks)
{
    const ema_lanes_segment_t* const segment = &lanes->segment;
    ema_lanes_segment_off(lanes, node);
    EMA_EACH_LANE
    {
        const ema_real bent_Nm =
            segment->driven[EMA_DRIVEN_TORQUE_BEND][l]
            + (((EMA_R(2.0) * node->at) - EMA_R(1.0)) * segment->driven[EMA_DRIVEN_TORQUE_TWIST][l]);
        const bool within = ema_lane_within(
            lanes, l, lanes->forces.input[l] - (node->bubble * segment->driven[EMA_DRIVEN_INPUT_BEND][l]),
            lanes->forces.torque_Nm[l] - (node->bubble * bent_Nm), EMA_UNRESOLVED);
        lanes->done[l] = ((looks[l] != EMA_R(0.0)) && !within) ? EMA_R(0.0) : lanes->done[l];
    }
}

/* Clears `done` where the effects are not resolved over the span. */
static void ema_lanes_segment_resolve(ema_lanes_t* lanes, const ema_lanes_responses_t* responses)
{
    ema_lanes_segment_t* const segment = &lanes->segment;
    ema_lane_t first_input;
    ema_lane_t first_Nm;
    ema_lane_t uneven;
    ema_lane_t third;
    ema_lane_t fourth;
    ema_lanes_segment_off(lanes, &ema_nodes[0]);
    EMA_EACH_LANE
    {
        const bool turns = (lanes->now.motion[l] == (ema_real)EMA_MOTION_ELASTIC)
                           && !((segment->start.speed_rad_s[l] * segment->end.speed_rad_s[l]) > EMA_R(0.0));
        const bool even = ema_lane_within(lanes, l, lanes->forces.input[l], lanes->forces.torque_Nm[l], EMA_UNEVEN);
        const bool tame =
            ema_lane_within(lanes, l, EMA_R(0.0), segment->driven[EMA_DRIVEN_TORQUE_RISE][l], EMA_TAME);
        const ema_real done = turns ? EMA_R(0.0) : lanes->done[l];
        first_input[l] = lanes->forces.input[l];
        first_Nm[l] = lanes->forces.torque_Nm[l];
        lanes->done[l] = done;
        uneven[l] = (even && tame) ? EMA_R(0.0) : done;
    }
    if (ema_lanes_count(uneven) > EMA_R(0.0)) {
        ema_lanes_segment_off(lanes, &ema_nodes[1]);
        EMA_EACH_LANE
        {
            const ema_real second_input = lanes->forces.input[l];
            const ema_real second_Nm = lanes->forces.torque_Nm[l];
            const ema_real twists_Nm = second_Nm - first_Nm[l];
            const bool tame = ema_lane_within(lanes, l, EMA_R(0.0), twists_Nm, EMA_TAME);
            const bool small =
                ema_abs(second_Nm) <= (EMA_GENTLE * ema_abs(segment->driven[EMA_DRIVEN_TORQUE_RISE][l]));
            const bool fits = ema_lane_within(lanes, l, ema_max(ema_abs(first_input[l]), ema_abs(second_input)),
                                              EMA_LEFT_OF_BEND * second_Nm, EMA_UNRESOLVED);
            const bool elastic = lanes->now.motion[l] == (ema_real)EMA_MOTION_ELASTIC;
            segment->driven[EMA_DRIVEN_INPUT_BEND][l] = EMA_BEND_OF_SUM * (first_input[l] + second_input);
            segment->driven[EMA_DRIVEN_TORQUE_BEND][l] = EMA_BEND_OF_SUM * (first_Nm[l] + second_Nm);
            segment->driven[EMA_DRIVEN_TORQUE_TWIST][l] = EMA_TWIST_OF_DIFFERENCE * twists_Nm;
            third[l] = (tame && small && fits && !elastic) ? EMA_R(0.0) : uneven[l];
            fourth[l] = tame ? EMA_R(0.0) : uneven[l];
        }
        ema_lanes_respond(lanes, responses, uneven, 6U, EMA_RESPONSES);
        if (ema_lanes_count(third) > EMA_R(0.0)) {
            ema_lanes_look(lanes, &ema_nodes[2], third);
        }
        if (ema_lanes_count(fourth) > EMA_R(0.0)) {
            ema_lanes_look(lanes, &ema_nodes[3], fourth);
        }
    }
}

/* Clears `done` where something happens in the span; moves the others. */
static void ema_lanes_commit(ema_lanes_t* lanes)
{
    const ema_lanes_plant_t* const constant = &lanes->constant;
    ema_lanes_segment_t* const segment = &lanes->segment;
    ema_lanes_state_t* const now = &lanes->now;
    EMA_EACH_LANE
    {
        const ema_real motion = now->motion[l];
        const ema_real end_A = segment->end.current_A[l];
        const ema_real gain = constant->torque_constant_Nm_per_A[l];
        const ema_real first_Nm = segment->forces.torque_Nm[l] + (gain * segment->start.current_A[l]);
        const ema_real last_Nm =
            segment->forces.torque_Nm[l] + segment->driven[EMA_DRIVEN_TORQUE_RISE][l] + (gain * end_A);
        const bool keeps = (motion == (ema_real)EMA_MOTION_ELASTIC)
                           || ((motion * segment->end.speed_rad_s[l]) > EMA_R(0.0));
        const bool moves = keeps && (segment->end.angle_rad[l] < constant->stop_upper_rad[l])
                           && (segment->end.angle_rad[l] > constant->stop_lower_rad[l]);
        const bool holds = (ema_max(first_Nm, last_Nm) <= segment->forces.level_forward_Nm[l])
                           && (ema_min(first_Nm, last_Nm) >= -segment->forces.level_backward_Nm[l]);
        const bool smooth = (ema_abs(end_A) <= constant->linear_current_A[l]) && (lanes->done[l] != EMA_R(0.0))
                            && ((motion == EMA_R(0.0)) ? holds : moves);
        lanes->done[l] = ema_flag(smooth);
    }
    if (ema_acts(&lanes->plant[0], EMA_SITE_PRESLIDING)) {
        ema_lane_t share;
        ema_lanes_presliding(lanes, segment->turn_rad, share);
        for (uint32_t l = 0; l < EMA_LANES; ++l) {
            if ((lanes->done[l] != EMA_R(0.0)) && (now->motion[l] == (ema_real)EMA_MOTION_ELASTIC)) {
                ema_site_presliding_keep(&lanes->plant[l], lanes->state[l].effect_memory, share[l]);
            }
        }
    }
    EMA_EACH_LANE
    {
        const bool done = lanes->done[l] != EMA_R(0.0);
        ema_real angle_rad = now->angle_rad[l];
        ema_real low_rad = now->angle_low_rad[l];
        ema_add_compensated(&angle_rad, &low_rad, segment->turn_rad[l]);
        now->current_A[l] = done ? segment->end.current_A[l] : now->current_A[l];
        now->speed_rad_s[l] = done ? segment->end.speed_rad_s[l] : now->speed_rad_s[l];
        now->angle_rad[l] = done ? angle_rad : now->angle_rad[l];
        now->angle_low_rad[l] = done ? low_rad : now->angle_low_rad[l];
    }
}

/* ema_motion_rod in lanes that are done. */
static void ema_lanes_rod(ema_lanes_t* lanes)
{
    for (uint32_t l = 0; l < EMA_LANES; ++l) {
        if (lanes->done[l] != EMA_R(0.0)) {
            ema_state_t* const state = &lanes->state[l];
            ema_lanes_leave(lanes, l, state);
            ema_motion_rod(&lanes->plant[l], state, &lanes->work, state->play_mm, lanes->segment.span_s[l]);
            ema_lanes_return(lanes, l);
        }
    }
}

/* ema_motion_try: sets `done`. */
static void ema_lanes_try(ema_lanes_t* lanes, const ema_lanes_responses_t* responses, bool whole)
{
    const ema_plant_t* const shape = &lanes->plant[0];
    const ema_real mode = ema_flag(shape->drive.current_mode);
    EMA_EACH_LANE
    {
        const bool linear = ema_abs(lanes->now.current_A[l]) < lanes->constant.linear_current_A[l];
        lanes->done[l] = ema_flag(linear && (lanes->applied.current_loop[l] == mode));
    }
    ema_lanes_segment_open(lanes);
    ema_lane_t all;
    EMA_EACH_LANE
    {
        all[l] = EMA_R(1.0);
    }
    ema_lanes_respond(lanes, responses, all, 0U, 4U);
    if (ema_acts_on_motion(shape)) {
        ema_lanes_segment_correct(lanes);
        ema_lanes_respond(lanes, responses, all, 3U, EMA_RESPONSES_EVEN);
        if (whole) {
            ema_lanes_segment_resolve(lanes, responses);
        }
    }
    ema_lanes_commit(lanes);
    if (ema_acts(shape, EMA_SITE_TRANSMISSION)) {
        ema_lanes_rod(lanes);
    }
}

/* Lanes that are not done go through `steps` integration steps of the model's own: of `span_s`, or without effects. */
static void ema_lanes_apart(ema_lanes_t* lanes, uint32_t steps, const ema_real* span_s)
{
    ema_work_t* const work = &lanes->work;
    lanes->lane_steps += EMA_LANES;
    if (ema_lanes_count(lanes->done) < (ema_real)EMA_LANES) {
        for (uint32_t l = 0; l < EMA_LANES; ++l) {
            if (lanes->done[l] == EMA_R(0.0)) {
                ema_state_t* const state = &lanes->state[l];
                const ema_plant_t* const plant = &lanes->plant[l];
                ema_lanes_leave(lanes, l, state);
                work->applied.input = lanes->applied.input[l];
                work->applied.voltage_V = lanes->applied.voltage_V[l];
                work->applied.current_loop = lanes->applied.current_loop[l] != EMA_R(0.0);
                for (uint32_t k = 0; k < steps; ++k) {
                    if (span_s != NULL) {
                        ema_motion_located(plant, state, work, span_s[l]);
                    } else if (!ema_motion_plain(plant, state, &work->applied)) {
                        ema_motion_located(plant, state, work, plant->substep_s);
                    } else {
                        /* the drive has left its mode's circuit: nothing else happens */
                    }
                }
                ema_lanes_return(lanes, l);
                ++lanes->left_spans;
            }
        }
    }
}

void ema_lanes_motion_span(ema_lanes_t* lanes, uint32_t responses, const ema_lane_t span_s)
{
    const ema_plant_t* const shape = &lanes->plant[0];
    ema_lane_t part_s;
    EMA_EACH_LANE
    {
        part_s[l] = span_s[l] / (ema_real)shape->substeps;
    }
    if (shape->tries_whole_step) {
        EMA_EACH_LANE
        {
            lanes->segment.span_s[l] = span_s[l];
        }
        ema_lanes_try(lanes, &lanes->responses[responses], true);
        ema_lanes_apart(lanes, shape->substeps, part_s);
    } else {
        const bool prepared = ema_acts_on_motion(shape) && !shape->drive.delayed;
        for (uint32_t k = 0; k < shape->substeps; ++k) {
            EMA_EACH_LANE
            {
                lanes->segment.span_s[l] = part_s[l];
                lanes->done[l] = EMA_R(0.0);
            }
            if (prepared) {
                ema_lanes_try(lanes, &lanes->responses[0], false);
            }
            ema_lanes_apart(lanes, 1U, part_s);
        }
    }
}

/* ema_motion_plain: sets `done`. */
static void ema_lanes_plain(ema_lanes_t* lanes, const ema_lanes_responses_t* responses)
{
    const ema_lanes_plant_t* const constant = &lanes->constant;
    ema_lanes_state_t* const now = &lanes->now;
    const ema_real mode = ema_flag(lanes->plant[0].drive.current_mode);
    EMA_EACH_LANE
    {
        const ema_response_t current = {.from_current = responses->current[0][l],
                                        .from_speed = responses->current[1][l],
                                        .from_voltage = responses->current[2][l],
                                        .from_torque = responses->current[3][l]};
        const ema_response_t speed = {.from_current = responses->speed[0][l],
                                      .from_speed = responses->speed[1][l],
                                      .from_voltage = responses->speed[2][l],
                                      .from_torque = responses->speed[3][l]};
        const ema_response_t angle = {.from_current = responses->angle[0][l],
                                      .from_speed = responses->angle[1][l],
                                      .from_voltage = responses->angle[2][l],
                                      .from_torque = responses->angle[3][l]};
        const ema_real current_A = now->current_A[l];
        const ema_real speed_rad_s = now->speed_rad_s[l];
        const ema_real input = lanes->applied.input[l];
        const bool stuck = now->motion[l] == EMA_R(0.0);
        const bool forward = now->motion[l] > EMA_R(0.0);
        const ema_real torque_Nm = forward ? constant->forward_torque_Nm[l] : constant->backward_torque_Nm[l];
        const ema_real next_A = ema_response_at(&current, current_A, speed_rad_s, input, torque_Nm);
        const ema_real next_rad_s = ema_response_at(&speed, current_A, speed_rad_s, input, torque_Nm);
        ema_real angle_rad = now->angle_rad[l];
        ema_real low_rad = now->angle_low_rad[l];
        ema_add_compensated(&angle_rad, &low_rad, ema_response_at(&angle, current_A, speed_rad_s, input, torque_Nm));
        const ema_real stuck_A = (responses->stuck[0][l] * current_A) + (responses->stuck[1][l] * input);
        const ema_real stuck_Nm = constant->torque_constant_Nm_per_A[l] * stuck_A;
        const ema_real end_A = stuck ? stuck_A : next_A;
        const bool moves = ((forward ? next_rad_s : -next_rad_s) > EMA_R(0.0))
                           && (angle_rad < constant->stop_upper_rad[l]) && (angle_rad > constant->stop_lower_rad[l]);
        const bool holds = (stuck_Nm <= constant->hold_upper_Nm[l]) && (stuck_Nm >= constant->hold_lower_Nm[l]);
        const bool plain = (lanes->applied.current_loop[l] == mode)
                           && (ema_abs(current_A) < constant->linear_current_A[l])
                           && (ema_abs(end_A) <= constant->linear_current_A[l]) && (stuck ? holds : moves);
        const bool moved = plain && !stuck;
        lanes->done[l] = ema_flag(plain);
        now->current_A[l] = plain ? end_A : current_A;
        now->speed_rad_s[l] = moved ? next_rad_s : speed_rad_s;
        now->angle_rad[l] = moved ? angle_rad : now->angle_rad[l];
        now->angle_low_rad[l] = moved ? low_rad : now->angle_low_rad[l];
    }
}

void ema_lanes_motion_plain(ema_lanes_t* lanes)
{
    for (uint32_t k = 0; k < lanes->plant[0].substeps; ++k) {
        ema_lanes_plain(lanes, &lanes->responses[0]);
        ema_lanes_apart(lanes, 1U, NULL);
    }
}
