/* What a model is made of: the state that changes while it runs, and the six blocks prepared from an actuator.
 *
 * Plain structures; ema_model.h says what is done with them. Equations: docs/DESIGN.md.
 */
#ifndef EMA_PLANT_H
#define EMA_PLANT_H

#include <stdbool.h>
#include <stdint.h>

#include "ema/ema_actuator.h"

/* Samples of feedback that the encoder keeps for its delay; a power of two. */
#define EMA_DELAY_SAMPLES 16U

/* Reversals, break-aways, saturations and end stops that are located in one integration step. */
#define EMA_EVENTS_MAX 8U

/* Reals of state of all effects together, and the length of their array: at least one so that it exists. */
enum {
    EMA_EFFECT_MEMORY_COUNT = 0
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters) +(memory)
#include "ema/ema_effects.def"
    ,
    EMA_EFFECT_MEMORY_LENGTH = (EMA_EFFECT_MEMORY_COUNT > 0) ? EMA_EFFECT_MEMORY_COUNT : 1
};

typedef enum {
    EMA_MOTION_BACKWARD = -1,
    EMA_MOTION_STUCK = 0,
    EMA_MOTION_FORWARD = 1,
    EMA_MOTION_ELASTIC =
        2 /* with presliding the shaft rests at an end of travel alone: dry friction is a spring that slips */
} ema_motion_t;

/* Everything that changes while the model runs: a plain value without pointers. A copy is a checkpoint; writing it back
 * resumes, on the same or on another model of the same actuator. */
typedef struct {
    int32_t motion;    /* an ema_motion_t */
    int32_t play_side; /* -1 or 1 in contact, 0 inside the play */
    uint32_t step;
    uint32_t unlocated_event_steps; /* steps with more events than are located; the last of them stopped the shaft */
    ema_real current_A;
    ema_real speed_rad_s;    /* at the motor shaft */
    ema_real angle_rad;      /* of the motor */
    ema_real angle_low_rad;  /* what angle_rad cannot hold */
    ema_real motor_mm;       /* the same expressed at the rod */
    ema_real play_mm;        /* output of the play */
    ema_real rod_mm;         /* behind what lies after the play */
    ema_real rod_speed_mm_s; /* of a rod that does not simply follow the play */
    ema_real integral;       /* of the control law, in output units */
    ema_real previous_error_m;
    ema_real previous_feedback_mm;
    ema_real previous_measure_mm;
    ema_real output;                          /* held between control instants */
    ema_real delay_output[EMA_DELAY_SAMPLES]; /* earlier outputs, while the drive delays them */
    ema_real effect_memory[EMA_EFFECT_MEMORY_LENGTH];
    ema_real delay_mm[EMA_DELAY_SAMPLES];
    ema_real
        outside_ratio; /* farthest that a learned table was used outside the range it was seen in, over that range */
} ema_state_t;

/* What one step shows: positions, current and speed at its start, the voltage applied from then on. */
typedef struct {
    ema_real position_mm;       /* rod, as the rod sensor reads it */
    ema_real motor_position_mm; /* motor encoder expressed at the rod */
    ema_real current_A;
    ema_real voltage_V;
    ema_real speed_mm_s; /* rod; zero while it rests in the play */
} ema_output_t;

/* Exact response of current, speed and angle over a span: to themselves, to an input that is constant, that rises as
 * the fraction s of the span, that bends as s (1 - s) and that twists as s (1 - s) (2 s - 1). */
typedef struct {
    ema_real from_current;
    ema_real from_speed;
    ema_real from_voltage;
    ema_real from_torque;
    ema_real from_voltage_rise;
    ema_real from_torque_rise;
    ema_real from_voltage_bend;
    ema_real from_torque_bend;
    ema_real from_torque_twist;
} ema_response_t;

#define EMA_RESPONSES 9U
#define EMA_RESPONSES_EVEN 6U /* of an input that rises evenly */

/* The responses of one circuit over one span. */
typedef struct {
    ema_response_t current;
    ema_response_t speed;
    ema_response_t angle;
    ema_real stuck_from_current; /* at rest: the current is its own and the voltage's response alone */
    ema_real stuck_from_voltage;
    ema_real stuck_from_voltage_rise;
    ema_real stuck_from_voltage_bend;
} ema_responses_t;

/* One electrical law: lag di/dt = a_i i + a_w w + a_v v, or algebraic i = a_w w + a_v v. */
typedef struct {
    bool algebraic;
    ema_real rate_current;
    ema_real rate_speed;
    ema_real rate_voltage;
} ema_circuit_t;

/* The six blocks, prepared from an actuator: constant while the model runs. */
typedef struct {
    bool cascade;
    bool derivative_on_speed;
    bool average_speed;
    bool plain; /* proportional and integral action only */
    ema_real period_s;
    ema_real gain;          /* kp, 1/m; of a cascade the speed's, s/m */
    ema_real integral_gain; /* ki, 1/(m s); of a cascade the speed's, 1/m */
    ema_real outer_gain;    /* kd, s/m; of a cascade the position's, 1/s */
    ema_real anti_windup_per_s;
    ema_real output_limit;
    ema_real speed_limit_m_s; /* largest finite number when there is none */
    uint32_t every_steps;
} ema_pid_t;

typedef struct {
    bool current_mode;
    bool delayed;
    uint16_t delay_steps;
    ema_real supply_V;
    ema_real current_scale_A;
    ema_real command_scale_V;
    ema_real current_limit_A; /* largest finite number when there is none */
    ema_real loop_s;
    ema_real delay_part;
} ema_drive_t;

typedef struct {
    ema_real torque_constant_Nm_per_A;
    ema_real back_emf_V_s_per_rad;
    ema_real resistance_ohm;
    ema_real inductance_H;
    ema_real torque_limit_Nm; /* largest finite number when there is none */
} ema_motor_t;

typedef struct {
    ema_real lead_mm;         /* rod travel per screw turn */
    ema_real lead_mm_per_rad; /* rod travel per motor angle */
    ema_real loss_opposing;   /* dry friction per load torque that opposes the motion */
    ema_real loss_aiding;     /* and per load torque that aids it */
} ema_gearbox_t;

typedef struct {
    ema_real inverse_inertia_per_kgm2;
    ema_real viscous_Nm_s_per_rad;
    ema_real static_Nm;
    ema_real dynamic_Nm;
    ema_real asymmetry;
    ema_real load_torque_Nm;
    ema_real forward_torque_Nm; /* constant torque on the shaft while it slides forward: load and dry friction */
    ema_real backward_torque_Nm;
    ema_real hold_lower_Nm; /* motor torques between these two leave a shaft at rest where it is */
    ema_real hold_upper_Nm;
    ema_real stop_lower_rad;
    ema_real stop_upper_rad;
    ema_real half_play_mm;
} ema_screw_t;

typedef struct {
    bool at_rod;
    bool plain; /* no delay and no resolution */
    uint16_t delay_steps;
    ema_real rod_gain;
    ema_real rod_offset_mm;
    ema_real resolution_mm;
    ema_real steps_per_mm;
    ema_real delay_part;
} ema_encoder_t;

/* A set of effects: one bit per row of ema_effects.def. */
typedef uint64_t ema_effect_set_t;

#define EMA_EFFECT_WORDS (((uint32_t)EMA_EFFECT_COUNT + 31U) / 32U)

/* Where an effect acts. */
typedef enum {
    EMA_SITE_PARAMETER = 0,
    EMA_SITE_FRICTION = 1,
    EMA_SITE_TORQUE = 2,
    EMA_SITE_LOAD = 3,
    EMA_SITE_VOLTAGE = 4,
    EMA_SITE_MOTOR = 5,
    EMA_SITE_PRESLIDING = 6,
    EMA_SITE_TRANSMISSION = 7,
    EMA_SITE_READING = 8,
    EMA_SITE_WINDING = 9,
    EMA_SITE_GREASE = 10
} ema_effect_site_t;

#define EMA_SITE_COUNT 11U

#define EMA_TABLES_BIT 15U

/* Which effects act while the model runs. */
typedef struct {
    bool any;         /* one that acts on the motion */
    uint8_t substeps; /* integration steps in a model step that they need */
    uint16_t sites;   /* at which one acts, a bit for each ema_effect_site_t; EMA_TABLES_BIT: a learned table does */
    uint32_t present[EMA_EFFECT_WORDS]; /* a bit for each effect that differs from zero, in the order of the list */
} ema_active_t;

/* The values that effects look at while the model runs. Those at site PARAMETER have done their work before, and tables
 * stay where they lie. */
typedef struct {
#define EMA_HELD_MEMBER(name) ema_effect_##name##_t name; /* EMA-D1 */
#define EMA_EFFECT_AT_FRICTION(name) EMA_HELD_MEMBER(name)
#define EMA_EFFECT_AT_TORQUE(name) EMA_HELD_MEMBER(name)
#define EMA_EFFECT_AT_LOAD(name) EMA_HELD_MEMBER(name)
#define EMA_EFFECT_AT_VOLTAGE(name) EMA_HELD_MEMBER(name)
#define EMA_EFFECT_AT_MOTOR(name) EMA_HELD_MEMBER(name)
#define EMA_EFFECT_AT_PRESLIDING(name) EMA_HELD_MEMBER(name)
#define EMA_EFFECT_AT_TRANSMISSION(name) EMA_HELD_MEMBER(name)
#define EMA_EFFECT_AT_READING(name) EMA_HELD_MEMBER(name)
#define EMA_EFFECT_AT_WINDING(name) EMA_HELD_MEMBER(name)
#define EMA_EFFECT_AT_GREASE(name) EMA_HELD_MEMBER(name)
#include "ema/ema_effects.def"
#undef EMA_HELD_MEMBER
} ema_held_effects_t;

typedef struct {
    bool tries_whole_step; /* a model step, or each part of a late one, is tried in one before it is divided */
    uint8_t substeps;
    uint8_t step_work;   /* what a model step, or a part of a late one, counts in plain steps before anything happens */
    uint8_t forces_work; /* and asking once for what acts: see ema_step_scratch.h */
    ema_active_t active;
    const ema_effects_t* learned; /* where the tables lie; NULL while none acts */
    ema_pid_t pid;
    ema_drive_t drive;
    ema_motor_t motor;
    ema_gearbox_t gearbox;
    ema_screw_t screw;
    ema_encoder_t encoder;
    ema_held_effects_t effects;
    ema_circuit_t motor_circuit;
    ema_circuit_t current_loop;
    /* [0] the circuit of the drive's mode over an integration step, [1] the same over a whole model step; where none is
     * tried, the other circuit over an integration step; with a delayed output both over the parts of the model step */
    ema_responses_t responses[2];
    ema_real linear_current_A; /* below it neither the drive nor the motor's torque saturates */
    ema_real torque_limit_A;   /* current at which the motor's torque saturates */
    ema_real start_mm;
    ema_real step_s;
    ema_real substep_s;
    ema_real warming_ahead_ratio; /* share of a step's change of current by which its mean lies beyond the middle; where
                                   * something warms */
} ema_plant_t;

#endif
