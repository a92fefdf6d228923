/* A span of the motion for all lanes at once, by the prepared responses: what ema_motion.c and ema_forces.c do under
 * the same names. Where nothing else is said, a lane that fails on its way is worked on to the end all the same: its
 * numbers are thrown away. */
#include <stddef.h>

#include "ema_effect_sites.h"
#include "ema_lanes.h"
#include "ema_motion.h"
#include "ema_motor.h"
#include "ema_resolve.h"
#include "ema_screw.h"

/* Whether a flag is set in any lane. */
static bool ema_lanes_any(const ema_lane_t flag)
{
    ema_lane_bit_t any = 0;
    EMA_EACH_LANE
    {
        any |= (flag[l] != EMA_R(0.0)) ? 1 : 0;
    }
    return any != 0;
}

/* Adds what drives by the responses in the columns `from` to `to`: ema_segment_respond. */
static inline void ema_lane_respond(ema_lanes_t* lanes, uint32_t l, uint32_t which, uint32_t from, uint32_t to,
                                    ema_real wanted)
{
    const ema_lanes_responses_t* const responses = &lanes->responses[which];
    ema_lanes_segment_t* const segment = &lanes->segment;
    const ema_real stuck = ema_flag(lanes->now.motion[l] == (ema_real)EMA_MOTION_STUCK);
    const ema_real before_A = segment->end.current_A[l];
    const ema_real before_rad_s = segment->end.speed_rad_s[l];
    const ema_real before_rad = segment->turn_rad[l];
    ema_real current_A = before_A;
    ema_real stuck_A = before_A;
    ema_real speed_rad_s = before_rad_s;
    ema_real turn_rad = before_rad;
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
    const ema_real moved = wanted * ema_not(stuck);
    const ema_real end_rad = ema_choose(moved, turn_rad, before_rad);
    segment->end.current_A[l] = ema_choose(wanted, ema_choose(stuck, stuck_A, current_A), before_A);
    segment->end.speed_rad_s[l] = ema_choose(moved, speed_rad_s, before_rad_s);
    segment->turn_rad[l] = end_rad;
    segment->end.angle_rad[l] = segment->start.angle_rad[l] + end_rad;
}

/* The point of the segment at the node. */
static inline void ema_lane_point(ema_lanes_t* lanes, uint32_t l, const ema_node_t* node)
{
    const ema_lanes_plant_t* const constant = &lanes->constant;
    const ema_lanes_segment_t* const segment = &lanes->segment;
    const ema_real gained_A = segment->end.current_A[l] - segment->start.current_A[l];
    const ema_real gained_rad_s = segment->end.speed_rad_s[l] - segment->start.speed_rad_s[l];
    const ema_real half_s = EMA_R(0.5) * segment->span_s[l];
    const ema_real moving_rad_s =
        (half_s * constant->inverse_inertia_per_kgm2[l])
        * ((constant->viscous_Nm_s_per_rad[l] * gained_rad_s) - (constant->torque_constant_Nm_per_A[l] * gained_A)
           - segment->driven[EMA_DRIVEN_TORQUE_RISE][l]);
    const ema_real stuck = ema_flag(lanes->now.motion[l] == (ema_real)EMA_MOTION_STUCK);
    const ema_real bend_rad_s = ema_choose(stuck, EMA_R(0.0), moving_rad_s);
    const ema_real lags_A = -half_s
                            * ((constant->rate_current[l] * gained_A) + (constant->rate_speed[l] * gained_rad_s)
                               + (constant->rate_voltage[l] * segment->driven[EMA_DRIVEN_INPUT_RISE][l]));
    const ema_real bend_A = ema_choose(constant->algebraic[l], constant->rate_speed[l] * bend_rad_s, lags_A);
    lanes->here.current_A[l] = segment->start.current_A[l] + (node->at * gained_A) + (node->bubble * bend_A);
    lanes->here.speed_rad_s[l] =
        segment->start.speed_rad_s[l] + (node->at * gained_rad_s) + (node->bubble * bend_rad_s);
    lanes->here.angle_rad[l] =
        segment->start.angle_rad[l]
        + (segment->span_s[l]
           * ((node->at * (segment->start.speed_rad_s[l] + (EMA_R(0.5) * node->at * gained_rad_s)))
              + (node->turn * bend_rad_s)));
}

/* What the forces there are off an even rise. */
typedef struct {
    ema_real input;
    ema_real torque_Nm;
} ema_off_t;

static inline ema_off_t ema_lane_off(const ema_lanes_t* lanes, uint32_t l, const ema_node_t* node, ema_real transmits)
{
    const ema_lanes_segment_t* const segment = &lanes->segment;
    const ema_real start_Nm = segment->reaction_start_Nm[l];
    const ema_real alone_Nm = lanes->forces.torque_Nm[l];
    const ema_real both_Nm = alone_Nm + (start_Nm + (node->at * (segment->reaction_end_Nm[l] - start_Nm)));
    const ema_real torque_Nm = ema_choose(transmits, both_Nm, alone_Nm);
    const ema_off_t off = {
        lanes->forces.input[l] - (segment->forces.input[l] + (node->at * segment->driven[EMA_DRIVEN_INPUT_RISE][l])),
        torque_Nm - (segment->forces.torque_Nm[l] + (node->at * segment->driven[EMA_DRIVEN_TORQUE_RISE][l])),
    };
    return off;
}

/* A flag: ema_segment_within. */
static inline ema_real ema_lane_within(const ema_lanes_t* lanes, uint32_t l, ema_real input, ema_real torque_Nm,
                                       ema_real share)
{
    const ema_real working_Nm =
        lanes->constant.static_Nm[l]
        + ema_abs(lanes->constant.torque_constant_Nm_per_A[l] * lanes->segment.start.current_A[l]);
    return ema_flag(ema_abs(torque_Nm) <= (share * working_Nm))
           * ema_flag(ema_abs(input) <= (EMA_SHARE_OF_INPUT * share * ema_abs(lanes->applied.input[l])));
}

/* The forces where the lanes are. */
static void ema_lanes_forces_now(ema_lanes_t* lanes)
{
    EMA_EACH_LANE
    {
        lanes->here.current_A[l] = lanes->now.current_A[l];
        lanes->here.speed_rad_s[l] = lanes->now.speed_rad_s[l];
        lanes->here.angle_rad[l] = lanes->now.angle_rad[l];
    }
    ema_lanes_forces_at(lanes, &lanes->here);
}

static inline void ema_lane_segment_open(ema_lanes_t* lanes, uint32_t l)
{
    ema_lanes_segment_t* const segment = &lanes->segment;
    segment->start.current_A[l] = lanes->now.current_A[l];
    segment->start.speed_rad_s[l] = lanes->now.speed_rad_s[l];
    segment->start.angle_rad[l] = lanes->now.angle_rad[l];
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

void ema_lanes_segment_open(ema_lanes_t* lanes)
{
    ema_lanes_forces_now(lanes);
    EMA_EACH_LANE
    {
        ema_lane_segment_open(lanes, l);
    }
}

/* Opens the segment and goes to its end under the forces at its start. */
static void ema_lanes_open(ema_lanes_t* lanes, uint32_t which)
{
    ema_lanes_forces_now(lanes);
    EMA_EACH_LANE
    {
        ema_lane_segment_open(lanes, l);
        ema_lane_respond(lanes, l, which, 0U, 4U, EMA_R(1.0));
    }
}

/* Where the play's output goes as the shaft goes to `angle_rad`. */
static void ema_lanes_play(const ema_lanes_t* lanes, const ema_lane_t angle_rad, ema_lane_t end_mm, ema_lane_t side)
{
    EMA_EACH_LANE
    {
        ema_lane_play(lanes, l, lanes->constant.lead_mm_per_rad[l] * angle_rad[l], &end_mm[l], &side[l]);
    }
}

/* What lies behind the play, tried over the span. */
static void ema_lanes_reaction(ema_lanes_t* lanes)
{
    ema_lanes_segment_t* const segment = &lanes->segment;
    ema_lanes_rod_t rod;
    ema_lane_t end_mm;
    ema_lane_t side;
    ema_lanes_play(lanes, segment->end.angle_rad, end_mm, side);
    ema_lanes_transmission(lanes, end_mm, &rod);
    EMA_EACH_LANE
    {
        segment->reaction_start_Nm[l] = rod.reaction_start_Nm[l];
        segment->reaction_end_Nm[l] = rod.reaction_end_Nm[l];
        segment->forces.torque_Nm[l] += rod.reaction_start_Nm[l];
    }
}

/* Lets the forces rise evenly to those at the predicted end, ema_segment_correct, and points to the first node. */
static void ema_lanes_correct(ema_lanes_t* lanes, uint32_t which)
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
        ema_lane_respond(lanes, l, which, 3U, EMA_RESPONSES_EVEN, EMA_R(1.0));
        ema_lane_point(lanes, l, &ema_nodes[0]);
    }
}

/* Looks at a third or fourth node in lanes where `looks` is set, and points to the next. */
static void ema_lanes_look(ema_lanes_t* lanes, const ema_node_t* node, const ema_node_t* next, const ema_lane_t looks,
                           ema_real transmits)
{
    const ema_lanes_segment_t* const segment = &lanes->segment;
    ema_lanes_forces_at(lanes, &lanes->here);
    EMA_EACH_LANE
    {
        const ema_off_t off = ema_lane_off(lanes, l, node, transmits);
        const ema_real bent_Nm =
            segment->driven[EMA_DRIVEN_TORQUE_BEND][l]
            + (((EMA_R(2.0) * node->at) - EMA_R(1.0)) * segment->driven[EMA_DRIVEN_TORQUE_TWIST][l]);
        const ema_real within =
            ema_lane_within(lanes, l, off.input - (node->bubble * segment->driven[EMA_DRIVEN_INPUT_BEND][l]),
                            off.torque_Nm - (node->bubble * bent_Nm), EMA_UNRESOLVED);
        lanes->done[l] *= ema_not(looks[l] * ema_not(within));
        ema_lane_point(lanes, l, next);
    }
}

/* Clears `done` where the effects are not resolved over the span: ema_segment_resolve. */
static void ema_lanes_resolve(ema_lanes_t* lanes, uint32_t which)
{
    ema_lanes_segment_t* const segment = &lanes->segment;
    const ema_real transmits = ema_flag(ema_acts(&lanes->plant[0], EMA_SITE_TRANSMISSION));
    ema_lane_t first_input;
    ema_lane_t first_Nm;
    ema_lane_t asks;
    ema_lane_t uneven;
    ema_lane_t third;
    ema_lane_t fourth;
    /* ema_segment_steady */
    const ema_real friction = ema_flag(ema_friction_alone(&lanes->plant[0]));
    EMA_EACH_LANE
    {
        const ema_real steady =
            friction * ema_lane_within(lanes, l, EMA_R(0.0), segment->driven[EMA_DRIVEN_TORQUE_RISE][l], EMA_UNEVEN);
        asks[l] = lanes->done[l] * ema_not(steady);
    }
    if (!ema_lanes_any(asks)) {
        return;
    }
    ema_lanes_forces_at(lanes, &lanes->here);
    EMA_EACH_LANE
    {
        const ema_off_t off = ema_lane_off(lanes, l, &ema_nodes[0], transmits);
        const ema_real turns =
            ema_flag(lanes->now.motion[l] == (ema_real)EMA_MOTION_ELASTIC)
            * ema_not(ema_flag((segment->start.speed_rad_s[l] * segment->end.speed_rad_s[l]) > EMA_R(0.0)));
        const ema_real even = ema_lane_within(lanes, l, off.input, off.torque_Nm, EMA_UNEVEN);
        const ema_real tame =
            ema_lane_within(lanes, l, EMA_R(0.0), segment->driven[EMA_DRIVEN_TORQUE_RISE][l], EMA_TAME);
        const ema_real done = lanes->done[l] * ema_not(turns);
        first_input[l] = off.input;
        first_Nm[l] = off.torque_Nm;
        lanes->done[l] = done;
        uneven[l] = asks[l] * done * ema_not(even * tame);
        ema_lane_point(lanes, l, &ema_nodes[1]);
    }
    if (ema_lanes_any(uneven)) {
        ema_lanes_forces_at(lanes, &lanes->here);
        EMA_EACH_LANE
        {
            const ema_off_t off = ema_lane_off(lanes, l, &ema_nodes[1], transmits);
            const ema_real twists_Nm = off.torque_Nm - first_Nm[l];
            const ema_real tame = ema_lane_within(lanes, l, EMA_R(0.0), twists_Nm, EMA_TAME);
            const ema_real gentle =
                ema_flag(ema_abs(off.torque_Nm) <= (EMA_GENTLE * ema_abs(segment->driven[EMA_DRIVEN_TORQUE_RISE][l])))
                * ema_lane_within(lanes, l, ema_max(ema_abs(first_input[l]), ema_abs(off.input)),
                                  EMA_LEFT_OF_BEND * off.torque_Nm, EMA_UNRESOLVED)
                * ema_flag(lanes->now.motion[l] != (ema_real)EMA_MOTION_ELASTIC);
            segment->driven[EMA_DRIVEN_INPUT_BEND][l] = EMA_BEND_OF_SUM * (first_input[l] + off.input);
            segment->driven[EMA_DRIVEN_TORQUE_BEND][l] = EMA_BEND_OF_SUM * (first_Nm[l] + off.torque_Nm);
            segment->driven[EMA_DRIVEN_TORQUE_TWIST][l] = EMA_TWIST_OF_DIFFERENCE * twists_Nm;
            third[l] = uneven[l] * ema_not(tame * gentle);
            fourth[l] = uneven[l] * ema_not(tame);
            ema_lane_respond(lanes, l, which, EMA_RESPONSES_EVEN, EMA_RESPONSES, uneven[l]);
            ema_lane_point(lanes, l, &ema_nodes[2]);
        }
        if (ema_lanes_any(third)) {
            ema_lanes_look(lanes, &ema_nodes[2], &ema_nodes[3], third, transmits);
            if (ema_lanes_any(fourth)) {
                ema_lanes_look(lanes, &ema_nodes[3], &ema_nodes[3], fourth, transmits);
            }
        }
    }
}

/* Clears `done` where something happens in the span, and moves the other lanes to its end. */
static void ema_lanes_move(ema_lanes_t* lanes)
{
    const ema_lanes_plant_t* const constant = &lanes->constant;
    ema_lanes_segment_t* const segment = &lanes->segment;
    ema_lanes_state_t* const now = &lanes->now;
    if (ema_acts(&lanes->plant[0], EMA_SITE_PRESLIDING)) {
        ema_lanes_presliding(lanes, segment->turn_rad, lanes->here.angle_rad);
    }
    EMA_EACH_LANE
    {
        const ema_real motion = now->motion[l];
        const ema_real end_A = segment->end.current_A[l];
        const ema_real gain = constant->torque_constant_Nm_per_A[l];
        const ema_real first_Nm = segment->forces.torque_Nm[l] + (gain * segment->start.current_A[l]);
        const ema_real last_Nm =
            segment->forces.torque_Nm[l] + segment->driven[EMA_DRIVEN_TORQUE_RISE][l] + (gain * end_A);
        const ema_real end_rad_s = segment->end.speed_rad_s[l];
        const ema_real end_rad = segment->end.angle_rad[l];
        /* an elastic contact has no direction to keep */
        const ema_real elastic = ema_flag(motion == (ema_real)EMA_MOTION_ELASTIC);
        const ema_real onward = ema_choose(elastic, EMA_R(1.0), motion * end_rad_s);
        const ema_real moves = ema_flag(onward > EMA_R(0.0)) * ema_flag(end_rad < constant->stop_upper_rad[l])
                               * ema_flag(end_rad > constant->stop_lower_rad[l]);
        const ema_real holds = ema_flag(ema_max(first_Nm, last_Nm) <= segment->forces.level_forward_Nm[l])
                               * ema_flag(ema_min(first_Nm, last_Nm) >= -segment->forces.level_backward_Nm[l]);
        const ema_real stuck = ema_flag(motion == (ema_real)EMA_MOTION_STUCK);
        const ema_real done = lanes->done[l] * ema_flag(ema_abs(end_A) <= constant->linear_current_A[l])
                              * ema_choose(stuck, holds, moves);
        ema_real angle_rad = now->angle_rad[l];
        ema_real low_rad = now->angle_low_rad[l];
        ema_add_compensated(&angle_rad, &low_rad, segment->turn_rad[l]);
        lanes->done[l] = done;
        now->current_A[l] = ema_choose(done, end_A, now->current_A[l]);
        now->speed_rad_s[l] = ema_choose(done, end_rad_s, now->speed_rad_s[l]);
        now->angle_rad[l] = ema_choose(done, angle_rad, now->angle_rad[l]);
        now->angle_low_rad[l] = ema_choose(done, low_rad, now->angle_low_rad[l]);
    }
    if (ema_acts(&lanes->plant[0], EMA_SITE_PRESLIDING)) {
        ema_lanes_presliding_keep(lanes, lanes->here.angle_rad);
    }
}

/* ema_motion_rod in lanes that are done. */
static void ema_lanes_follow_play(ema_lanes_t* lanes)
{
    ema_lanes_state_t* const now = &lanes->now;
    ema_lanes_rod_t rod;
    ema_lane_t end_mm;
    ema_lane_t side;
    ema_lanes_play(lanes, now->angle_rad, end_mm, side);
    ema_lanes_transmission(lanes, end_mm, &rod);
    for (uint32_t k = 0; k < (uint32_t)EMA_EFFECT_MEMORY_COUNT; ++k) {
        EMA_EACH_LANE
        {
            now->effect_memory[k][l] = ema_choose(lanes->done[l], rod.effect_memory[k][l], now->effect_memory[k][l]);
        }
    }
    EMA_EACH_LANE
    {
        const ema_real done = lanes->done[l];
        now->play_mm[l] = ema_choose(done, end_mm[l], now->play_mm[l]);
        now->play_side[l] = ema_choose(done, side[l], now->play_side[l]);
        now->rod_mm[l] = ema_choose(done, rod.rod_mm[l], now->rod_mm[l]);
        now->rod_speed_mm_s[l] = ema_choose(done, rod.rod_speed_mm_s[l], now->rod_speed_mm_s[l]);
    }
}

/* ema_motion_try: sets `done`. */
static void ema_lanes_try(ema_lanes_t* lanes, uint32_t which, bool whole)
{
    const ema_plant_t* const shape = &lanes->plant[0];
    const ema_real mode = ema_flag(shape->drive.current_mode);
    EMA_EACH_LANE
    {
        lanes->done[l] = lanes->asked[l]
                         * ema_flag(ema_abs(lanes->now.current_A[l]) < lanes->constant.linear_current_A[l])
                         * ema_flag(lanes->applied.current_loop[l] == mode);
    }
    ema_lanes_open(lanes, which);
    if (ema_acts_on_motion(shape)) {
        ema_lanes_correct(lanes, which);
        if (whole) {
            ema_lanes_resolve(lanes, which);
        }
    }
    ema_lanes_move(lanes);
    if (ema_acts(shape, EMA_SITE_TRANSMISSION)) {
        ema_lanes_follow_play(lanes);
    }
}

/* So few that going on alone costs less than taking the others along. */
#define EMA_LANES_TOGETHER 3

/* Whether events are found in several lanes at once. */
static bool ema_lanes_share_events(const ema_plant_t* shape)
{
    return !ema_acts(shape, EMA_SITE_PRESLIDING) && !ema_acts(shape, EMA_SITE_TRANSMISSION)
           && !shape->motor_circuit.algebraic && !shape->drive.current_mode;
}

/* A lane goes through `steps` integration steps by the model's own functions: of `span_s`, or without effects. */
static void ema_lanes_alone(ema_lanes_t* lanes, uint32_t lane, uint32_t steps, const ema_real* span_s)
{
    ema_work_t* const work = &lanes->work;
    ema_state_t* const state = &lanes->state[lane];
    const ema_plant_t* const plant = &lanes->plant[lane];
    ema_lanes_leave(lanes, lane, state);
    work->applied.input = lanes->applied.input[lane];
    work->applied.voltage_V = lanes->applied.voltage_V[lane];
    work->applied.current_loop = lanes->applied.current_loop[lane] != EMA_R(0.0);
    for (uint32_t k = 0; k < steps; ++k) {
        if (span_s != NULL) {
            ema_motion_located(plant, state, work, span_s[lane]);
        } else if (!ema_motion_plain(plant, state, &work->applied)) {
            ema_motion_located(plant, state, work, plant->substep_s);
        } else {
            /* the drive has left its mode's circuit: nothing else happens */
        }
    }
    ema_lanes_return(lanes, lane);
    ++lanes->left_spans;
}

/* The same in the lanes that are asked and not done; those without a run take what the first has come to. */
static void ema_lanes_alone_each(ema_lanes_t* lanes, uint32_t steps, const ema_real* span_s)
{
    for (uint32_t l = 0; l < EMA_LANES; ++l) {
        if ((lanes->asked[l] != EMA_R(0.0)) && (lanes->done[l] == EMA_R(0.0))) {
            if (l < lanes->count) {
                ema_lanes_alone(lanes, l, steps, span_s);
            } else {
                lanes->state[l] = lanes->state[0];
                ema_lanes_return(lanes, l);
            }
        }
    }
}

/* Lanes that are not done go through `steps` integration steps, of `span_s` or without effects. With `tried` the step,
 * of which there is one, has been tried. */
static void ema_lanes_apart(ema_lanes_t* lanes, uint32_t steps, const ema_real* span_s, bool tried)
{
    const ema_plant_t* const shape = &lanes->plant[0];
    const ema_real* const part_s = (span_s != NULL) ? span_s : lanes->substep_s;
    const bool tries = ema_acts_on_motion(shape) && !shape->drive.delayed && !tried;
    const bool shares = ema_lanes_share_events(shape);
    int32_t leaves = 0;
    ema_lane_bit_t any = 0;
    lanes->lane_spans += lanes->count;
    EMA_EACH_LANE
    {
        any |= (lanes->done[l] == EMA_R(0.0)) ? 1 : 0;
    }
    if (any == 0) {
        return;
    }
    for (uint32_t l = 0; l < EMA_LANES; ++l) {
        leaves += (lanes->done[l] == EMA_R(0.0)) ? 1 : 0;
    }
    if ((leaves < EMA_LANES_TOGETHER) || !(shares || tries)) {
        ema_lanes_alone_each(lanes, steps, span_s);
    } else {
        ema_lane_t leave;
        EMA_EACH_LANE
        {
            leave[l] = ema_not(lanes->done[l]);
        }
        for (uint32_t k = 0; k < steps; ++k) {
            EMA_EACH_LANE
            {
                lanes->asked[l] = leave[l];
                lanes->done[l] = EMA_R(0.0);
                lanes->segment.span_s[l] = part_s[l];
            }
            if (tries) {
                ema_lanes_try(lanes, 0U, false);
            }
            EMA_EACH_LANE
            {
                lanes->asked[l] = leave[l] * ema_not(lanes->done[l]);
            }
            if (ema_lanes_any(lanes->asked)) {
                EMA_EACH_LANE
                {
                    lanes->done[l] = EMA_R(0.0);
                }
                if (shares) {
                    ema_lanes_events(lanes, part_s);
                }
                ema_lanes_alone_each(lanes, 1U, span_s);
            }
        }
        EMA_EACH_LANE
        {
            lanes->asked[l] = EMA_R(1.0);
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
        ema_lanes_try(lanes, responses, true);
        ema_lanes_apart(lanes, shape->substeps, part_s, false);
    } else {
        const bool prepared = ema_acts_on_motion(shape) && !shape->drive.delayed;
        for (uint32_t k = 0; k < shape->substeps; ++k) {
            EMA_EACH_LANE
            {
                lanes->segment.span_s[l] = part_s[l];
                lanes->done[l] = EMA_R(0.0);
            }
            if (prepared) {
                ema_lanes_try(lanes, 0U, false);
            }
            ema_lanes_apart(lanes, 1U, part_s, prepared);
        }
    }
}

/* ema_motion_plain: sets `done`. */
static void ema_lanes_plain(ema_lanes_t* lanes)
{
    const ema_lanes_responses_t* const responses = &lanes->responses[0];
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
        const ema_real stuck = ema_flag(now->motion[l] == (ema_real)EMA_MOTION_STUCK);
        const ema_real forward = ema_flag(now->motion[l] > EMA_R(0.0));
        const ema_real torque_Nm = ema_choose(forward, constant->forward_torque_Nm[l], constant->backward_torque_Nm[l]);
        const ema_real next_A = ema_response_at(&current, current_A, speed_rad_s, input, torque_Nm);
        const ema_real next_rad_s = ema_response_at(&speed, current_A, speed_rad_s, input, torque_Nm);
        const ema_real turn_rad = ema_response_at(&angle, current_A, speed_rad_s, input, torque_Nm);
        ema_real angle_rad = now->angle_rad[l];
        ema_real low_rad = now->angle_low_rad[l];
        ema_add_compensated(&angle_rad, &low_rad, turn_rad);
        const ema_real stuck_A = (responses->stuck[0][l] * current_A) + (responses->stuck[1][l] * input);
        const ema_real stuck_Nm = constant->torque_constant_Nm_per_A[l] * stuck_A;
        const ema_real end_A = ema_choose(stuck, stuck_A, next_A);
        const ema_real onward_rad_s = ema_choose(forward, next_rad_s, -next_rad_s);
        const ema_real moves = ema_flag(onward_rad_s > EMA_R(0.0)) * ema_flag(angle_rad < constant->stop_upper_rad[l])
                               * ema_flag(angle_rad > constant->stop_lower_rad[l]);
        const ema_real holds =
            ema_flag(stuck_Nm <= constant->hold_upper_Nm[l]) * ema_flag(stuck_Nm >= constant->hold_lower_Nm[l]);
        const ema_real plain = ema_flag(lanes->applied.current_loop[l] == mode)
                               * ema_flag(ema_abs(current_A) < constant->linear_current_A[l])
                               * ema_flag(ema_abs(end_A) <= constant->linear_current_A[l])
                               * ema_choose(stuck, holds, moves);
        const ema_real moved = plain * ema_not(stuck);
        lanes->done[l] = plain;
        now->current_A[l] = ema_choose(plain, end_A, current_A);
        now->speed_rad_s[l] = ema_choose(moved, next_rad_s, speed_rad_s);
        now->angle_rad[l] = ema_choose(moved, angle_rad, now->angle_rad[l]);
        now->angle_low_rad[l] = ema_choose(moved, low_rad, now->angle_low_rad[l]);
    }
}

void ema_lanes_motion_plain(ema_lanes_t* lanes)
{
    for (uint32_t k = 0; k < lanes->plant[0].substeps; ++k) {
        ema_lanes_plain(lanes);
        ema_lanes_apart(lanes, 1U, NULL, false);
    }
}
