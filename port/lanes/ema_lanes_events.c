/* An integration step with its events in several lanes at once: what ema_located.c, ema_events.c and ema_series.c do
 * under the same names, for shafts that come to rest, stay there, turn and break away, and for currents that the drive
 * holds at its limit. Whatever else happens (an end of travel, a current that comes to its limit or leaves it) is left
 * to them: such a lane goes back to where the step began. */
#include "ema_effect_sites.h"
#include "ema_lanes.h"
#include "ema_math.h"
#include "ema_motor.h"

/* As in ema_events.c and ema_series.c. */
#define EMA_LANES_ROOT_FROM EMA_R(0.0625)
#define EMA_LANES_ROOT_STEPS 14U

/* A power series of every lane. */
typedef struct {
    ema_lane_t term[EMA_SERIES_TERMS + 1U];
} ema_lanes_terms_t;

typedef struct {
    ema_lanes_terms_t current_A;
    ema_lanes_terms_t speed_rad_s;
    ema_lanes_terms_t turn_rad;
    ema_lanes_terms_t torque_Nm; /* of lanes at rest */
    ema_lane_t held;             /* a flag: the current stays as it is */
    bool any_held;
} ema_lanes_series_t;

/* ema_event_t; of the kinds only these. */
typedef struct {
    ema_lane_t rest; /* flags */
    ema_lane_t forward;
    ema_lane_t backward;
    ema_lane_t at;
    ema_lane_t at_end_A; /* current, speed and turn at the instant */
    ema_lane_t at_end_rad_s;
    ema_lane_t at_end_rad;
} ema_lanes_event_t;

static void ema_lanes_series_at(const ema_lanes_terms_t* terms, const ema_lane_t at, ema_lane_t sum)
{
    EMA_EACH_LANE
    {
        ema_real value = terms->term[EMA_SERIES_TERMS][l];
        for (uint32_t k = EMA_SERIES_TERMS; k > 0U; --k) {
            value = (value * at[l]) + terms->term[k - 1U][l];
        }
        sum[l] = value;
    }
}

/* Where the series less `bound` crosses zero: ema_series_root, in lanes where `wanted` is set. */
static void ema_lanes_series_root(ema_lanes_terms_t* terms, const ema_lane_t bound, const ema_lane_t lower,
                                  const ema_lane_t wanted, ema_lane_t root)
{
    ema_lane_t keep;
    ema_lane_t open;
    ema_lane_t left;
    ema_lane_t right;
    ema_lane_t value;
    ema_lane_t value_left;
    ema_lane_t value_right;
    ema_lane_t kept;
    EMA_EACH_LANE
    {
        keep[l] = terms->term[0][l];
        terms->term[0][l] = keep[l] - bound[l];
        open[l] = wanted[l];
        left[l] = lower[l];
        right[l] = EMA_R(1.0);
        root[l] = EMA_R(1.0);
        kept[l] = EMA_R(0.0);
    }
    ema_lanes_series_at(terms, left, value_left);
    ema_lanes_series_at(terms, right, value_right);
    for (uint32_t k = 0; k < EMA_LANES_ROOT_STEPS; ++k) {
        ema_lane_bit_t any = 0;
        EMA_EACH_LANE
        {
            const ema_real width = right[l] - left[l];
            const ema_real secant = right[l] - ((value_right[l] * width) / (value_right[l] - value_left[l]));
            const ema_real inside = ema_flag(secant > left[l]) * ema_flag(secant < right[l]);
            const ema_real next = ema_choose(inside, secant, EMA_R(0.5) * (left[l] + right[l]));
            open[l] *= ema_flag(width > EMA_REAL_EPSILON) * ema_flag(value_right[l] != EMA_R(0.0));
            root[l] = ema_choose(open[l], next, root[l]);
            any |= (open[l] != EMA_R(0.0)) ? 1 : 0;
        }
        if (any == 0) {
            break;
        }
        ema_lanes_series_at(terms, root, value);
        EMA_EACH_LANE
        {
            /* on the right end's side of the root, or on it */
            const ema_real apart = ema_flag(value[l] > EMA_R(0.0)) - ema_flag(value_right[l] > EMA_R(0.0));
            const ema_real off = ema_flag(value[l] != EMA_R(0.0)) * ema_flag(apart != EMA_R(0.0));
            const ema_real goes_left = open[l] * off;
            const ema_real goes_right = open[l] * ema_not(off);
            const ema_real half_left = EMA_R(0.5) * value_left[l];
            const ema_real half_right = EMA_R(0.5) * value_right[l];
            const ema_real stays_left = ema_choose(ema_flag(kept[l] > EMA_R(0.0)), half_left, value_left[l]);
            const ema_real stays_right = ema_choose(ema_flag(kept[l] < EMA_R(0.0)), half_right, value_right[l]);
            const ema_real new_left = ema_choose(goes_right, stays_left, value_left[l]);
            const ema_real new_right = ema_choose(goes_left, stays_right, value_right[l]);
            left[l] = ema_choose(goes_left, root[l], left[l]);
            right[l] = ema_choose(goes_right, root[l], right[l]);
            value_left[l] = ema_choose(goes_left, value[l], new_left);
            value_right[l] = ema_choose(goes_right, value[l], new_right);
            kept[l] = ema_choose(goes_right, EMA_R(1.0), ema_choose(goes_left, EMA_R(-1.0), kept[l]));
        }
    }
    EMA_EACH_LANE
    {
        terms->term[0][l] = keep[l];
    }
}

/* The terms from place `k` on of what is linear in those before, for an input and a torque that have such a term:
 * ema_series_build with a circuit that has a time constant and lets the current go. */
static void ema_lanes_series_term(const ema_lanes_t* lanes, ema_lanes_series_t* series, uint32_t k,
                                  const ema_real* input, const ema_real* torque_Nm)
{
    const ema_lanes_plant_t* const constant = &lanes->constant;
    const ema_real inverse = ema_inverse[k + 1U];
    EMA_EACH_LANE
    {
        const ema_real stuck = ema_flag(lanes->now.motion[l] == (ema_real)EMA_MOTION_STUCK);
        const ema_real share_s = lanes->segment.span_s[l] * inverse;
        const ema_real current_A = series->current_A.term[k][l];
        const ema_real speed_rad_s = series->speed_rad_s.term[k][l];
        const ema_real gain = constant->torque_constant_Nm_per_A[l];
        const ema_real moving_rad_s2 =
            ((gain * current_A) - (constant->viscous_Nm_s_per_rad[l] * speed_rad_s) + torque_Nm[l])
            * constant->inverse_inertia_per_kgm2[l];
        const ema_real next_A = share_s
                                * ((constant->rate_current[l] * current_A) + (constant->rate_speed[l] * speed_rad_s)
                                   + (constant->rate_voltage[l] * input[l]));
        series->turn_rad.term[k + 1U][l] = share_s * speed_rad_s;
        series->speed_rad_s.term[k + 1U][l] = share_s * ema_choose(stuck, EMA_R(0.0), moving_rad_s2);
        const ema_real gained_A = ema_choose(series->held[l], EMA_R(0.0), next_A);
        series->current_A.term[k + 1U][l] = gained_A;
        series->torque_Nm.term[k + 1U][l] = gain * gained_A;
    }
}

/* Motion over the segment's span as power series, and its end, under forces that rise as far as they do. */
static void ema_lanes_segment_end(ema_lanes_t* lanes, ema_lanes_series_t* series)
{
    ema_lanes_segment_t* const segment = &lanes->segment;
    /* terms of what drives without bend and twist: even the signs of zeros are those of ema_series_build */
    ema_lane_t input[4];
    ema_lane_t torque_Nm[4];
    ema_lane_t none;
    ema_lane_t whole;
    ema_lane_t turn_rad;
    EMA_EACH_LANE
    {
        const ema_real zero = EMA_R(0.0);
        const ema_real current_A = segment->start.current_A[l];
        const ema_real first_Nm = segment->forces.torque_Nm[l] + zero;
        input[0][l] = segment->forces.input[l];
        input[1][l] = segment->driven[EMA_DRIVEN_INPUT_RISE][l] + zero;
        input[2][l] = -zero;
        input[3][l] = zero;
        torque_Nm[0][l] = first_Nm;
        torque_Nm[1][l] = segment->driven[EMA_DRIVEN_TORQUE_RISE][l] + zero;
        torque_Nm[2][l] = zero;
        torque_Nm[3][l] = -zero;
        none[l] = zero;
        whole[l] = EMA_R(1.0);
        series->current_A.term[0][l] = current_A;
        series->speed_rad_s.term[0][l] = segment->start.speed_rad_s[l];
        series->turn_rad.term[0][l] = zero;
        series->torque_Nm.term[0][l] = (lanes->constant.torque_constant_Nm_per_A[l] * current_A) + first_Nm;
    }
    for (uint32_t k = 0; k < EMA_SERIES_TERMS; ++k) {
        ema_lanes_series_term(lanes, series, k, (k < 4U) ? input[k] : none, (k < 4U) ? torque_Nm[k] : none);
    }
    EMA_EACH_LANE
    {
        series->torque_Nm.term[1][l] += segment->driven[EMA_DRIVEN_TORQUE_RISE][l];
    }
    ema_lanes_series_at(&series->current_A, whole, segment->end.current_A);
    ema_lanes_series_at(&series->speed_rad_s, whole, segment->end.speed_rad_s);
    ema_lanes_series_at(&series->turn_rad, whole, turn_rad);
    EMA_EACH_LANE
    {
        segment->end.angle_rad[l] = turn_rad[l] + lanes->now.angle_rad[l];
    }
}

/* Sets `held` where the drive holds the current at its limit: of ema_regime_update. A lane that is no such lane and yet
 * at a limit is left to it. */
static void ema_lanes_hold(const ema_lanes_t* lanes, ema_lanes_series_t* series)
{
    ema_lane_bit_t any = 0;
    EMA_EACH_LANE
    {
        const ema_real start_A = lanes->segment.start.current_A[l];
        const ema_real rate = (lanes->constant.rate_current[l] * start_A)
                              + (lanes->constant.rate_speed[l] * lanes->now.speed_rad_s[l])
                              + (lanes->constant.rate_voltage[l] * lanes->segment.forces.input[l]);
        const ema_real held =
            ema_flag(ema_abs(start_A) == lanes->constant.held_current_A[l]) * ema_flag((rate * start_A) > EMA_R(0.0));
        series->held[l] = held;
        any |= (held != EMA_R(0.0)) ? 1 : 0;
    }
    series->any_held = any != 0;
}

/* Clears `stays` where a held current is let go: ema_event_release. */
static void ema_lanes_release(const ema_lanes_t* lanes, const ema_lanes_series_t* series, ema_lane_t stays)
{
    const ema_lanes_segment_t* const segment = &lanes->segment;
    ema_lanes_terms_t rate;
    ema_lane_t whole;
    ema_lane_t end;
    for (uint32_t k = 0; k <= EMA_SERIES_TERMS; ++k) {
        EMA_EACH_LANE
        {
            const ema_real stuck = ema_flag(lanes->now.motion[l] == (ema_real)EMA_MOTION_STUCK);
            const ema_real moving = lanes->constant.rate_speed[l] * series->speed_rad_s.term[k][l];
            rate.term[k][l] = ema_choose(stuck, EMA_R(0.0), moving);
        }
    }
    EMA_EACH_LANE
    {
        const ema_real held_A = segment->start.current_A[l];
        rate.term[0][l] +=
            (lanes->constant.rate_current[l] * held_A) + (lanes->constant.rate_voltage[l] * segment->forces.input[l]);
        rate.term[1][l] += lanes->constant.rate_voltage[l] * segment->driven[EMA_DRIVEN_INPUT_RISE][l];
        whole[l] = EMA_R(1.0);
    }
    ema_lanes_series_at(&rate, whole, end);
    EMA_EACH_LANE
    {
        const ema_real held_A = segment->start.current_A[l];
        const ema_real goes =
            ema_flag((end[l] * held_A) < EMA_R(0.0)) * ema_flag((rate.term[0][l] * held_A) > EMA_R(0.0));
        stays[l] *= ema_not(series->held[l] * goes);
    }
}

/* Flags: which way a shaft at rest goes: ema_screw_break_away. */
static inline void ema_lane_break_away(const ema_lanes_t* lanes, uint32_t l, ema_real torque_Nm, ema_real forward_Nm,
                                       ema_real backward_Nm, ema_real* forward, ema_real* backward)
{
    const ema_real angle_rad = lanes->now.angle_rad[l];
    *forward = ema_flag(torque_Nm > forward_Nm) * ema_flag(angle_rad < lanes->constant.stop_upper_rad[l]);
    *backward = ema_flag(torque_Nm < -backward_Nm) * ema_flag(angle_rad > lanes->constant.stop_lower_rad[l])
                * ema_not(*forward);
}

/* The first event in the segment, ema_event_find; clears `stays` in lanes where it is none of these. */
static void ema_lanes_event_find(ema_lanes_t* lanes, ema_lanes_series_t* series, const ema_lane_t active,
                                 ema_lane_t stays, ema_lanes_event_t* event)
{
    const ema_lanes_plant_t* const constant = &lanes->constant;
    const ema_lanes_segment_t* const segment = &lanes->segment;
    ema_lane_t whole;
    ema_lane_t from;
    ema_lane_t speed_rad_s;
    ema_lane_t torque_Nm;
    ema_lane_t bound;
    ema_lane_t rests_at;
    ema_lane_t leaves_at;
    ema_lane_t turns;
    ema_lane_t leaves;
    ema_lane_bit_t any = 0;
    ema_lanes_segment_end(lanes, series);
    if (series->any_held) {
        ema_lanes_release(lanes, series, stays);
    }
    EMA_EACH_LANE
    {
        whole[l] = EMA_R(1.0);
        from[l] = ema_choose(ema_flag(lanes->now.speed_rad_s[l] == EMA_R(0.0)), EMA_LANES_ROOT_FROM, EMA_R(0.0));
    }
    ema_lanes_series_at(&series->speed_rad_s, from, speed_rad_s);
    ema_lanes_series_at(&series->torque_Nm, whole, torque_Nm);
    EMA_EACH_LANE
    {
        const ema_real motion = lanes->now.motion[l];
        const ema_real rests = ema_flag(motion == (ema_real)EMA_MOTION_STUCK);
        const ema_real moves = ema_not(rests);
        const ema_real forward_Nm = segment->forces.level_forward_Nm[l];
        const ema_real backward_Nm = segment->forces.level_backward_Nm[l];
        const ema_real end_rad = segment->end.angle_rad[l];
        const ema_real stops =
            ema_flag(end_rad >= constant->stop_upper_rad[l]) + ema_flag(end_rad <= constant->stop_lower_rad[l]);
        ema_real ahead;
        ema_real behind;
        ema_real later_ahead;
        ema_real later_behind;
        ema_lane_break_away(lanes, l, series->torque_Nm.term[0][l], forward_Nm, backward_Nm, &ahead, &behind);
        ema_lane_break_away(lanes, l, torque_Nm[l], forward_Nm, backward_Nm, &later_ahead, &later_behind);
        const ema_real held = ema_not(ahead) * ema_not(behind);
        const ema_real onward = ema_flag((motion * segment->end.speed_rad_s[l]) > EMA_R(0.0));
        const ema_real reverses = moves * ema_not(onward);
        const ema_real starts_onward = ema_flag((motion * speed_rad_s[l]) > EMA_R(0.0));
        const ema_real linear = ema_flag(ema_abs(segment->start.current_A[l]) < constant->linear_current_A[l])
                                * ema_flag(ema_abs(segment->end.current_A[l]) <= constant->linear_current_A[l]);
        stays[l] *= ema_choose(series->held[l], EMA_R(1.0), linear) * ema_not(moves * ema_flag(stops > EMA_R(0.0)));
        event->rest[l] = reverses;
        event->forward[l] = rests * ema_choose(held, later_ahead, ahead);
        event->backward[l] = rests * ema_choose(held, later_behind, behind);
        turns[l] = active[l] * stays[l] * reverses * starts_onward;
        leaves[l] = active[l] * stays[l] * rests * held * (event->forward[l] + event->backward[l]);
        bound[l] = ema_choose(event->forward[l], forward_Nm, -backward_Nm);
        /* where nothing is sought: the end without an event, the very start of one that is there already */
        leaves_at[l] = ema_choose(rests * ema_not(held), EMA_R(0.0), EMA_R(1.0));
        rests_at[l] = ema_choose(reverses, from[l], EMA_R(1.0));
        any |= ((turns[l] != EMA_R(0.0)) ? 1 : 0) | ((leaves[l] != EMA_R(0.0)) ? 2 : 0);
    }
    if ((any & 1) != 0) {
        ema_lane_t zero;
        ema_lane_t root;
        EMA_EACH_LANE
        {
            zero[l] = EMA_R(0.0);
        }
        ema_lanes_series_root(&series->speed_rad_s, zero, from, turns, root);
        EMA_EACH_LANE
        {
            rests_at[l] = ema_choose(turns[l], root[l], rests_at[l]);
        }
    }
    if ((any & 2) != 0) {
        ema_lane_t zero;
        ema_lane_t root;
        EMA_EACH_LANE
        {
            zero[l] = EMA_R(0.0);
        }
        ema_lanes_series_root(&series->torque_Nm, bound, zero, leaves, root);
        EMA_EACH_LANE
        {
            leaves_at[l] = ema_choose(leaves[l], root[l], leaves_at[l]);
        }
    }
    EMA_EACH_LANE
    {
        const ema_real rests = ema_flag(lanes->now.motion[l] == (ema_real)EMA_MOTION_STUCK);
        event->at[l] = ema_choose(rests, leaves_at[l], rests_at[l]);
    }
    ema_lanes_series_at(&series->current_A, event->at, event->at_end_A);
    ema_lanes_series_at(&series->speed_rad_s, event->at, event->at_end_rad_s);
    ema_lanes_series_at(&series->turn_rad, event->at, event->at_end_rad);
}

/* The speed is zero, in lanes where `rests` is set: ema_motion_rest. */
static void ema_lanes_rest(ema_lanes_t* lanes, const ema_lane_t rests, ema_lane_t stays)
{
    ema_lanes_state_t* const now = &lanes->now;
    EMA_EACH_LANE
    {
        ema_real play_mm;
        ema_real side;
        const ema_real angle_rad = now->angle_rad[l];
        const ema_real beyond = ema_flag(angle_rad > lanes->constant.stop_upper_rad[l])
                                + ema_flag(angle_rad < lanes->constant.stop_lower_rad[l]);
        stays[l] *= ema_not(rests[l] * beyond);
        ema_lane_play(lanes, l, lanes->constant.lead_mm_per_rad[l] * angle_rad, &play_mm, &side);
        now->play_mm[l] = ema_choose(rests[l], play_mm, now->play_mm[l]);
        now->play_side[l] = ema_choose(rests[l], side, now->play_side[l]);
        now->speed_rad_s[l] = ema_choose(rests[l], EMA_R(0.0), now->speed_rad_s[l]);
        now->motion[l] = ema_choose(rests[l], (ema_real)EMA_MOTION_STUCK, now->motion[l]);
        lanes->here.current_A[l] = now->current_A[l];
        lanes->here.speed_rad_s[l] = EMA_R(0.0);
        lanes->here.angle_rad[l] = angle_rad;
    }
    ema_lanes_forces_at(lanes, &lanes->here);
    EMA_EACH_LANE
    {
        const ema_motor_t motor = {.torque_constant_Nm_per_A = lanes->constant.torque_constant_Nm_per_A[l],
                                   .torque_limit_Nm = lanes->constant.torque_limit_Nm[l]};
        const ema_real torque_Nm = lanes->forces.torque_Nm[l] + ema_motor_torque(&motor, now->current_A[l]);
        ema_real forward;
        ema_real backward;
        ema_lane_break_away(lanes, l, torque_Nm, lanes->forces.level_forward_Nm[l], lanes->forces.level_backward_Nm[l],
                            &forward, &backward);
        now->motion[l] = ema_choose(rests[l], forward - backward, now->motion[l]);
    }
}

/* Moves active lanes to their event and lets it happen; clears `active` at the end of the span. */
static bool ema_lanes_event_apply(ema_lanes_t* lanes, const ema_lanes_event_t* event, ema_lane_t active,
                                  ema_lane_t stays)
{
    ema_lanes_state_t* const now = &lanes->now;
    ema_lanes_segment_t* const segment = &lanes->segment;
    ema_lane_t rests;
    ema_lane_bit_t any = 0;
    ema_lane_bit_t goes_on = 0;
    EMA_EACH_LANE
    {
        const ema_real on = active[l] * stays[l];
        const ema_real moves = on * ema_flag(now->motion[l] != (ema_real)EMA_MOTION_STUCK);
        const ema_real leaves = on * (event->forward[l] + event->backward[l]);
        ema_real angle_rad = now->angle_rad[l];
        ema_real low_rad = now->angle_low_rad[l];
        ema_add_compensated(&angle_rad, &low_rad, event->at_end_rad[l]);
        now->current_A[l] = ema_choose(on, event->at_end_A[l], now->current_A[l]);
        now->speed_rad_s[l] = ema_choose(moves, event->at_end_rad_s[l], now->speed_rad_s[l]);
        now->angle_rad[l] = ema_choose(moves, angle_rad, now->angle_rad[l]);
        now->angle_low_rad[l] = ema_choose(moves, low_rad, now->angle_low_rad[l]);
        stays[l] *= ema_not(on * ema_flag(ema_abs(now->current_A[l]) > lanes->constant.linear_current_A[l]));
        rests[l] = on * event->rest[l];
        now->motion[l] = ema_choose(leaves, event->forward[l] - event->backward[l], now->motion[l]);
        segment->span_s[l] -= segment->span_s[l] * event->at[l];
        active[l] = ema_flag((rests[l] + leaves) > EMA_R(0.0)) * ema_flag(segment->span_s[l] > EMA_R(0.0));
        any |= (rests[l] != EMA_R(0.0)) ? 1 : 0;
        goes_on |= (active[l] != EMA_R(0.0)) ? 1 : 0;
    }
    if (any != 0) {
        ema_lanes_rest(lanes, rests, stays);
    }
    return goes_on != 0;
}

void ema_lanes_events(ema_lanes_t* lanes, const ema_real* span_s)
{
    const ema_lanes_state_t before = lanes->now;
    ema_lanes_state_t* const now = &lanes->now;
    ema_lanes_segment_t* const segment = &lanes->segment;
    const bool effects = ema_acts_on_motion(&lanes->plant[0]);
    ema_lanes_series_t series;
    ema_lanes_event_t event;
    ema_lane_t active;
    ema_lane_t stays;
    bool goes_on = true;
    EMA_EACH_LANE
    {
        active[l] = lanes->asked[l];
        stays[l] = EMA_R(1.0);
        segment->span_s[l] = span_s[l];
    }
    for (uint32_t k = 0; goes_on && (k < EMA_EVENTS_MAX); ++k) {
        ema_lanes_segment_open(lanes);
        ema_lanes_hold(lanes, &series);
        if (effects) {
            ema_lanes_segment_end(lanes, &series);
            ema_lanes_forces_at(lanes, &segment->end);
            EMA_EACH_LANE
            {
                segment->driven[EMA_DRIVEN_TORQUE_RISE][l] =
                    (lanes->forces.torque_Nm[l] + EMA_R(0.0)) - segment->forces.torque_Nm[l];
                segment->driven[EMA_DRIVEN_INPUT_RISE][l] = lanes->forces.input[l] - segment->forces.input[l];
            }
        }
        ema_lanes_event_find(lanes, &series, active, stays, &event);
        goes_on = ema_lanes_event_apply(lanes, &event, active, stays);
    }
    EMA_EACH_LANE
    {
        const ema_real done = lanes->asked[l] * stays[l] * ema_not(active[l]);
        lanes->done[l] = done;
        now->motion[l] = ema_choose(done, now->motion[l], before.motion[l]);
        now->play_side[l] = ema_choose(done, now->play_side[l], before.play_side[l]);
        now->current_A[l] = ema_choose(done, now->current_A[l], before.current_A[l]);
        now->speed_rad_s[l] = ema_choose(done, now->speed_rad_s[l], before.speed_rad_s[l]);
        now->angle_rad[l] = ema_choose(done, now->angle_rad[l], before.angle_rad[l]);
        now->angle_low_rad[l] = ema_choose(done, now->angle_low_rad[l], before.angle_low_rad[l]);
        now->play_mm[l] = ema_choose(done, now->play_mm[l], before.play_mm[l]);
    }
}
