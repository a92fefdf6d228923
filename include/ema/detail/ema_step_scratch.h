/* The memory in which a model step is worked out: what acts over a span of the motion, its power series, and what
 * happens in it.
 *
 * Preparing a model uses it too. It lies with the caller so that a step needs little stack. One serves any number of
 * models whose steps follow each other. It means nothing between two steps: there is nothing to set beforehand, and
 * nothing to keep with a checkpoint.
 */
#ifndef EMA_STEP_SCRATCH_H
#define EMA_STEP_SCRATCH_H

#include "ema/detail/ema_plant.h"

/* Terms of a power series beyond the constant one. */
#if EMA_REAL64
#define EMA_SERIES_TERMS 24U
#else
#define EMA_SERIES_TERMS 14U
#endif

/* What the drive applies over one step. */
typedef struct {
    ema_real input;     /* voltage on the motor circuit in V, or reference of the current loop in A */
    ema_real voltage_V; /* as it is recorded */
    bool current_loop;  /* which of the two circuits the input drives */
} ema_drive_output_t;

/* A point of the motion. */
typedef struct {
    ema_real current_A;
    ema_real speed_rad_s;
    ema_real angle_rad;
} ema_point_t;

/* What acts on circuit and shaft at a point of the motion, beside the motor's own torque; and what holds the shaft at
 * rest. */
typedef struct {
    ema_real input; /* of the circuit */
    ema_real torque_Nm;
    ema_real level_forward_Nm; /* dry friction at rest against each direction; of a moving shaft its torque */
    ema_real level_backward_Nm;
} ema_forces_t;

/* A span of the motion without events: what its ends are. */
typedef struct {
    ema_point_t start;
    ema_point_t end;
    ema_point_t between; /* a node on the way */
    ema_forces_t forces; /* at the start */
    ema_real turn_rad;   /* from start to end */
    ema_real bend_A;     /* of the current between its ends */
    ema_real bend_rad_s; /* and of the speed */
    ema_real working_Nm; /* what friction and motor are worth there, which what is left over is held against */
} ema_segment_t;

/* What the current does over a segment that is located. */
typedef struct {
    bool held;             /* the drive holds it at its limit */
    ema_real saturated_Nm; /* motor torque while it is saturated, else zero */
} ema_regime_t;

typedef enum {
    EMA_EVENT_NONE,
    EMA_EVENT_REST,    /* the speed reaches zero */
    EMA_EVENT_STOP,    /* an end of travel */
    EMA_EVENT_CURRENT, /* the current reaches a limit of drive or torque */
    EMA_EVENT_RELEASE, /* the drive need not hold the current any longer */
    EMA_EVENT_FORWARD, /* the torque leaves what dry friction holds */
    EMA_EVENT_BACKWARD
} ema_event_kind_t;

typedef struct {
    ema_event_kind_t kind;
    ema_real at;        /* fraction of the span */
    ema_real value;     /* of the quantity that reached its bound */
    ema_real current_A; /* at this instant, on the way that was assumed */
    ema_real speed_rad_s;
    ema_real turn_rad; /* from the start of the span */
} ema_event_t;

/* What lies behind the play, over an integration step. */
typedef struct {
    ema_real rod_mm; /* rod position and speed at the end of the step */
    ema_real rod_speed_mm_s;
    ema_real reaction_start_Nm; /* on the motor shaft */
    ema_real reaction_end_Nm;
} ema_rod_t;

/* What moves current and speed over a span; the first nine in the order of ema_response_t. */
typedef struct {
    ema_real current_A;
    ema_real speed_rad_s;
    ema_real input;      /* of the circuit: V or A */
    ema_real torque_Nm;  /* on the shaft beside the motor's */
    ema_real input_rise; /* over the span */
    ema_real torque_rise_Nm;
    ema_real input_bend;
    ema_real torque_bend_Nm;
    ema_real torque_twist_Nm;
    ema_real span_s;
    ema_real torque_gain_Nm_per_A; /* of the current; zero while the motor's torque is saturated */
    bool at_rest;                  /* the shaft does not move */
    bool current_held;             /* the drive holds the current */
} ema_span_t;

/* Current and speed over a span, as power series in the fraction of the span. */
typedef struct {
    ema_real current_A[EMA_SERIES_TERMS + 1U];
    ema_real speed_rad_s[EMA_SERIES_TERMS + 1U];
} ema_series_t;

/* Work is counted in plain steps, as slices are: a model step in which nothing happens and no effect acts is one (each
 * of its substeps, where the plant needs several), and these count besides what they take, as counted on the target. */
#define EMA_WORK_SERIES 5U /* the end of a segment that an event may cut short, and the search for that */

/* What `effects` that act on the motion say at a point of it: each takes a fifth to a third of what asking for none
 * does. */
#define EMA_WORK_FORCES(effects) (1U + (((uint32_t)(effects) + 1U) / 3U))
#define EMA_WORK_FORCES_MAX EMA_WORK_FORCES(EMA_EFFECT_COUNT)

/* What watching learned tables, or adding to the rod sensor's reading, takes in a model step. */
#define EMA_WORK_READING 1U

/* The most that one model step counts, by its structure: itself, a try of the whole and, for each substep, a try and
 * EMA_EVENTS_MAX events, with `forces` of the plant's forces_work; twice that with a delay of the output. What was
 * found by looking is a quarter of it and less: docs/BUDGETS.md. */
#define EMA_STEP_WORK_MAX(substeps, forces)                                                                            \
    (2U                                                                                                                \
     * (1U + EMA_WORK_READING + (6U * (forces))                                                                        \
        + ((substeps) * (1U + (2U * (forces)) + (EMA_EVENTS_MAX * ((3U * (forces)) + (2U * EMA_WORK_SERIES)))))))

typedef struct {
    uint32_t spent;                   /* by the slice so far, in plain steps; only whoever runs one reads it */
    const ema_circuit_t* circuit;     /* that it drives */
    const ema_responses_t* responses; /* of it over the span, where they are prepared */
    ema_real span_s;                  /* of the segment */
    ema_drive_output_t applied;
    ema_regime_t regime;
    ema_event_t event; /* the last one of the step */
    ema_segment_t segment;
    ema_forces_t forces;  /* at the point that was asked for last */
    ema_real winding_ohm; /* that the winding has gained since the record began, over the step */
    ema_rod_t rod;
    ema_span_t span;
    union {
        ema_params_t params; /* as the effects leave them: while a model is prepared */
        ema_series_t series; /* while it runs */
    };
    ema_real
        terms[EMA_SERIES_TERMS + 1U]; /* of the series that is made of these: the angle's, or that of what is sought */
} ema_step_scratch_t;

#endif
