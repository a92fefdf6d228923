/* Models that run side by side: EMA_LANES actuators under one command, their numbers next to each other, so that the
 * compiler works on several at once. Each lane has the very bits of a model that runs alone.
 *
 * What all steps do is done here for all lanes; where a lane leaves that (a reversal, a break-away, an end of travel, a
 * limit of the current, effects that one step does not resolve) it goes through the model's own functions and comes
 * back. All lanes have the same shape: see ema_lanes_alike.
 */
#ifndef EMA_LANES_H
#define EMA_LANES_H

#include "ema/ema_work.h"

/* Two vectors of float32, four of float64, where a vector has 32 bytes: some work while others wait. Few runs are
 * sooner done in half of it; the builder says so. */
#ifndef EMA_LANES
#define EMA_LANES 16U
#endif

/* Rows that are kept together before each lane's go to a place of their own. */
#define EMA_LANES_ROWS 64U

/* No lane looks at another, so the compiler is free to work on as many at once as it can: it is told. */
#if defined(__clang__)
#define EMA_LANES_APART _Pragma("clang loop vectorize(assume_safety)")
#elif defined(__GNUC__)
#define EMA_LANES_APART _Pragma("GCC ivdep")
#else
#define EMA_LANES_APART
#endif
#define EMA_EACH_LANE EMA_LANES_APART for (uint32_t l = 0; l < EMA_LANES; ++l)

/* One number of every lane; as a flag 1 or 0, of the numbers' own size so that it needs no conversion. */
typedef ema_real ema_lane_t[EMA_LANES];

/* Whole numbers of the same size, for what is asked of all lanes together. */
#if EMA_REAL64
typedef int64_t ema_lane_bit_t;
#else
typedef int32_t ema_lane_bit_t;
#endif

/* Effects of the user's own are the last of the list; nothing is known of what they look at. */
enum {
    EMA_LANES_OWN_EFFECTS = 0
#ifdef EMA_OWN_EFFECTS
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters) +1
#include EMA_OWN_EFFECTS
#undef EMA_EFFECT
#endif
};

/* ema_responses_t */
typedef struct {
    ema_lane_t current[EMA_RESPONSES];
    ema_lane_t speed[EMA_RESPONSES];
    ema_lane_t angle[EMA_RESPONSES];
    ema_lane_t stuck[(EMA_RESPONSES - 1U) / 2U];
} ema_lanes_responses_t;

/* What of the plant every step looks at, by the names it has there. */
typedef struct {
    ema_lane_t period_s;
    ema_lane_t gain;
    ema_lane_t integral_gain;
    ema_lane_t anti_windup_per_s;
    ema_lane_t output_limit;
    ema_lane_t supply_V;
    ema_lane_t torque_constant_Nm_per_A;
    ema_lane_t back_emf_V_s_per_rad;
    ema_lane_t torque_limit_Nm;
    ema_lane_t lead_mm_per_rad;
    ema_lane_t loss_opposing;
    ema_lane_t loss_aiding;
    ema_lane_t inverse_inertia_per_kgm2;
    ema_lane_t viscous_Nm_s_per_rad;
    ema_lane_t static_Nm;
    ema_lane_t dynamic_Nm;
    ema_lane_t asymmetry;
    ema_lane_t load_torque_Nm;
    ema_lane_t forward_torque_Nm;
    ema_lane_t backward_torque_Nm;
    ema_lane_t hold_lower_Nm;
    ema_lane_t hold_upper_Nm;
    ema_lane_t stop_lower_rad;
    ema_lane_t stop_upper_rad;
    ema_lane_t half_play_mm;
    ema_lane_t rod_gain;
    ema_lane_t rod_offset_mm;
    ema_lane_t lead_mm;
    ema_lane_t resistance_ohm;
    ema_lane_t algebraic; /* of the circuit of the drive's mode; a flag */
    ema_lane_t rate_current;
    ema_lane_t rate_speed;
    ema_lane_t rate_voltage;
    ema_lane_t linear_current_A;
    ema_lane_t held_current_A; /* the drive's limit where it lies below the torque's, else negative */
    ema_lane_t step_s;
} ema_lanes_plant_t;

/* What of the state every step changes, by the names it has there. The rest stays in the lanes' own states. */
typedef struct {
    ema_lane_t motion; /* an ema_motion_t */
    ema_lane_t play_side;
    ema_lane_t current_A;
    ema_lane_t speed_rad_s;
    ema_lane_t angle_rad;
    ema_lane_t angle_low_rad;
    ema_lane_t motor_mm;
    ema_lane_t play_mm;
    ema_lane_t rod_mm;
    ema_lane_t rod_speed_mm_s;
    ema_lane_t integral;
    ema_lane_t output;
    ema_lane_t effect_memory[EMA_EFFECT_MEMORY_LENGTH];
} ema_lanes_state_t;

/* ema_output_t */
typedef struct {
    ema_lane_t position_mm;
    ema_lane_t motor_position_mm;
    ema_lane_t current_A;
    ema_lane_t voltage_V;
    ema_lane_t speed_mm_s;
} ema_lanes_output_t;

/* ema_drive_output_t */
typedef struct {
    ema_lane_t input;
    ema_lane_t voltage_V;
    ema_lane_t current_loop;
} ema_lanes_applied_t;

/* ema_point_t */
typedef struct {
    ema_lane_t current_A;
    ema_lane_t speed_rad_s;
    ema_lane_t angle_rad;
} ema_lanes_point_t;

/* ema_forces_t */
typedef struct {
    ema_lane_t input;
    ema_lane_t torque_Nm;
    ema_lane_t level_forward_Nm;
    ema_lane_t level_backward_Nm;
} ema_lanes_forces_t;

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

/* A span of the motion without events: ema_segment_t, and what of ema_span_t it takes. `driven` stands in the order of
 * ema_response_t. */
typedef struct {
    ema_lanes_point_t start;
    ema_lanes_point_t end;
    ema_lanes_forces_t forces;
    ema_lane_t turn_rad;
    ema_lane_t driven[EMA_RESPONSES];
    ema_lane_t span_s;
    ema_lane_t reaction_start_Nm;
    ema_lane_t reaction_end_Nm;
} ema_lanes_segment_t;

/* ema_rod_t, and the memory of the effects there. */
typedef struct {
    ema_lane_t rod_mm;
    ema_lane_t rod_speed_mm_s;
    ema_lane_t reaction_start_Nm;
    ema_lane_t reaction_end_Nm;
    ema_lane_t effect_memory[EMA_EFFECT_MEMORY_LENGTH];
} ema_lanes_rod_t;

typedef struct {
    _Alignas(64) ema_lanes_plant_t constant;
    ema_lanes_responses_t responses[2];
    ema_lane_t held[sizeof(ema_held_effects_t) / sizeof(ema_real)]; /* the values of ema_held_effects_t */
    ema_lanes_state_t now;
    ema_lanes_output_t rows[EMA_LANES_ROWS + 1U];
    ema_lanes_output_t* row; /* where the next step shows itself: one of them */
    ema_lanes_applied_t applied;
    ema_lanes_segment_t segment;
    ema_lanes_point_t here;    /* between its ends */
    ema_lanes_forces_t forces; /* at the point that was asked for last */
    ema_lane_t feedback_mm;
    ema_lane_t substep_s;
    ema_lane_t asked; /* which lanes the next span is for: all, but where some of them go on apart */
    ema_lane_t done;  /* whether the last span was taken in one */
    uint32_t count;   /* lanes with a run: the first of them; the others do what the first does */
    uint32_t step;
    uint64_t lane_spans; /* spans of all lanes, and how many of them were left to the model's own functions */
    uint64_t left_spans;
    ema_work_t work; /* of the lanes that leave, one after the other */
    ema_plant_t plant[EMA_LANES];
    ema_state_t state[EMA_LANES];
} ema_lanes_t;

/* Questions and choices without a branch: all sides are worked out, and flags are multiplied. */
static inline ema_real ema_flag(bool holds)
{
    return holds ? EMA_R(1.0) : EMA_R(0.0);
}

static inline ema_real ema_not(ema_real flag)
{
    return EMA_R(1.0) - flag;
}

static inline ema_real ema_choose(ema_real flag, ema_real set, ema_real unset)
{
    return (flag != EMA_R(0.0)) ? set : unset;
}

/* Output of the play for the motor position `input_mm`, and the side in contact: ema_screw_play. */
static inline void ema_lane_play(const ema_lanes_t* lanes, uint32_t l, ema_real input_mm, ema_real* play_mm,
                                 ema_real* side)
{
    const ema_real half_mm = lanes->constant.half_play_mm[l];
    const ema_real before_mm = lanes->now.play_mm[l];
    const ema_real gap_mm = input_mm - before_mm;
    const ema_real ahead = ema_flag(gap_mm > half_mm);
    const ema_real behind = ema_flag(gap_mm < -half_mm);
    *play_mm = ema_choose(ahead, input_mm - half_mm, ema_choose(behind, input_mm + half_mm, before_mm));
    *side = ema_choose(ahead, EMA_R(1.0), ema_choose(behind, EMA_R(-1.0), EMA_R(0.0)));
}

/* Whether two plants differ in numbers alone: the same effects act during the run, and the same blocks have the same
 * form. Lanes run together where this holds. */
bool ema_lanes_alike(const ema_plant_t* one, const ema_plant_t* other);

/* Starts the lanes at their plants and states, which are set before. */
void ema_lanes_start(ema_lanes_t* lanes);

/* One model step of every lane, ema_model_step; what it shows goes to `row`. False when one has left the finite
 * numbers. */
bool ema_lanes_step(ema_lanes_t* lanes, ema_real command_mm);

/* Whether this one has not. */
bool ema_lanes_finite(const ema_lanes_t* lanes, uint32_t lane);

/* One lane between the numbers side by side and its own state. */
void ema_lanes_leave(const ema_lanes_t* lanes, uint32_t lane, ema_state_t* state);
void ema_lanes_return(ema_lanes_t* lanes, uint32_t lane);

/* The forces at a point of the motion, into the lanes' `forces`: ema_forces_at. */
void ema_lanes_forces_at(ema_lanes_t* lanes, const ema_lanes_point_t* point);

/* Share of dry friction that the contact carries after a turn: ema_site_presliding. */
void ema_lanes_presliding(const ema_lanes_t* lanes, const ema_lane_t turn_rad, ema_lane_t share);

/* What lies behind the play, whose output goes from `play_mm` of the state to `play_end_mm` over the segment's span:
 * ema_site_transmission. */
void ema_lanes_transmission(const ema_lanes_t* lanes, const ema_lane_t play_end_mm, ema_lanes_rod_t* rod);

/* ema_site_warm, after a step in which the current began at `start_A`. */
void ema_lanes_warm(ema_lanes_t* lanes, const ema_lane_t start_A);

/* Keeps that share in elastic lanes that are done. */
void ema_lanes_presliding_keep(ema_lanes_t* lanes, const ema_lane_t share);

/* A span of the motion with effects, or behind a late drive: ema_motion_span. */
void ema_lanes_motion_span(ema_lanes_t* lanes, uint32_t responses, const ema_lane_t span_s);

/* The forces at the start of the segment: ema_segment_open. */
void ema_lanes_segment_open(ema_lanes_t* lanes);

/* An integration step with its events in the lanes that are asked: ema_motion_events. Sets `done` where it could be
 * taken; the other lanes are left as they were. */
void ema_lanes_events(ema_lanes_t* lanes, const ema_real* span_s);

/* A model step without effects: ema_motion_step. */
void ema_lanes_motion_plain(ema_lanes_t* lanes);

#endif
