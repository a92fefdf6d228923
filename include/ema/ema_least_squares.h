/* Up to eight values at once, by damped least squares: each step takes the sensitivities of every recorded row.
 *
 *     ema_record_init, ema_record_append ...                               the record of the ground test
 *     ema_least_squares_init(&search, &config, &record);
 *     while (ema_least_squares_run(&search, 200) == EMA_OK && !ema_least_squares_done(&search)) { }        in slices
 *     ema_least_squares_result(&search, &result);
 *
 * A search of its own beside the annealer's session: where the session finds CSJ and BLK by the rod position and judges
 * them, this finds several values by several signals, each weighted by its sensor's noise, and says of each how well
 * the record determines it. It gives no verdict. Firmware that does not call it links none of it.
 *
 * How it searches. A march runs the model at the present values and, in lock step, once beside it for each value; it
 * gives J'J, J'r and the sum of squares S = sum of ((measured - simulated) / noise)^2. The step solves
 * (J'J + lambda diag J'J) s = J'r (Levenberg, Quart. Appl. Math. 2, 1944; Marquardt, J. SIAM 11, 1963) inside the
 * bounds: a value at a bound that wants out is held there. One plain run says whether S falls; it is given up as soon
 * as it is more than before. If it falls the next march begins there, and lambda falls or grows by how much of the
 * promise of the linear model the step kept; else lambda grows and the step is taken anew. The runs beside the present
 * one are moved by ten standard errors of the value by itself; the very first march, which does not know them, is
 * made anew where it was far off. Near the end a second march moves them to the other side: sensitivities to one side
 * are off by what bends. A descent ends where the model promises less than a hundredth of what one standard error of
 * one value adds to S, or than its rounding.
 *
 * A descent may end in a wrong valley. Where one ends with a value at the edge of its bounds, another begins with that
 * value in the middle. Where the lowest point leaves more than the sensors' noise explains (adequacy_ratio of the
 * actuator), or a value at an edge, further ones begin at points that fill the box (multiples of the square roots of
 * primes, Richtmyer 1951), until three of them have ended alike, two where they explain the record, or their number is
 * used up. The lowest point of all is the answer. No random numbers: the answer is a function of record and
 * configuration, and does not depend on the slices.
 *
 * What is identifiable is known after the first march, 1 + count model runs: ema_least_squares_result from then on.
 * Call it with a budget of twice these to ask before searching.
 *
 * Values that do the same to the signals are told from each other by no more than rounding. Their sensitivities are
 * allowed for it; in float32 that is enough where no noise is stated below 1/2000 of its signal's spread.
 *
 * Memory: one structure of the caller, 10.5 KiB in float32 for any count, beside record and configuration; a record
 * with all four signals takes 10 bytes a row as int16. Stack: docs/BUDGETS.md. It is a plain value apart from the
 * pointers to configuration and record: a copy is a
 * checkpoint.
 */
#ifndef EMA_LEAST_SQUARES_H
#define EMA_LEAST_SQUARES_H

#include "ema/detail/ema_annealer.h"
#include "ema/detail/ema_levmar.h"
#include "ema/detail/ema_objective.h"
#include "ema/detail/ema_sensitivity.h"
#include "ema/ema_model.h"
#include "ema/ema_record.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Values searched at once: sets the memory. */
#define EMA_LEAST_SQUARES_MAX 8U

/* One value, in its own unit. */
typedef struct {
    ema_value_id_t id;
    ema_value_id_t with; /* another value that moves in the same proportion, as the back-EMF with the torque constant;
                            `id` itself for none */
    ema_real lower;
    ema_real upper;
    ema_real start; /* where the search begins, within the bounds */
} ema_searched_t;

/* Constant during the search and must outlive it. */
typedef struct {
    const ema_actuator_t* actuator; /* everything that is not searched */
    uint32_t count;                 /* 1 to 8 */
    ema_searched_t searched[EMA_LEAST_SQUARES_MAX];
    ema_real noise[EMA_CHANNEL_COUNT]; /* rms of the sensors, mm, mm, A, V, by ema_channel_t; 0: the signal is not
                                          compared */
    uint32_t run_budget;               /* model runs at the most, 1 + count or more; 2500 is plenty for eight */
    uint32_t restarts;                 /* further descents at the most; 8 is plenty */
} ema_least_squares_config_t;

/* Whether a record determines a value: its 95 % interval by the sensors' noise is shorter than half of its bounds, and
 * what no other value makes of the signals is more than rounding may make of it. */
typedef enum {
    EMA_DETERMINED = 0,
    EMA_DETERMINED_TOGETHER = 1, /* only together with others, `partner` foremost: they do the same to the signals */
    EMA_DETERMINED_NOT = 2       /* it does too little to the signals, or nothing */
} ema_determined_t;

typedef struct {
    ema_real estimate;  /* in the value's own unit, as all of these */
    ema_real std;       /* standard error from the residual's own size and the sensitivities: see ema_sensitivity.h;
                           EMA_COST_MAX where the value is not told from the others */
    ema_real bias;      /* how far it may be off besides, for what lasts in the residual: likewise */
    ema_real noise_std; /* standard error by the sensors' stated noise alone */
    ema_determined_t determined;
    uint32_t partner; /* place of the value that is most like it; its own where there is none */
    bool at_bound;
} ema_found_t;

typedef struct {
    ema_found_t value[EMA_LEAST_SQUARES_MAX]; /* in the order of the configuration */
    uint32_t count;
    ema_real misfit_before;        /* rms of the residual over the noise, all signals: at the start */
    ema_real misfit_after;         /* and at the lowest point; about 1 where the noise is all */
    ema_real residual_rms_mm;      /* of the rod position */
    ema_real residual_correlation; /* of its neighbouring rows: 0 is white */
    ema_real outside_ratio;        /* how far a learned table was used outside its range */
    bool crossed;                  /* the rod was pushed both ways; before that a play is not determined */
    bool adequate;                 /* misfit_after is no more than the actuator's adequacy_ratio */
    uint32_t runs;                 /* model runs, those that were given up among them */
    uint32_t starts;               /* descents that were begun */
    uint64_t model_steps;          /* that were made */
    ema_outcome_t outcome; /* EMA_OUTCOME_TOLERANCE: the lowest point was reached; EMA_OUTCOME_BUDGET; ..._ACTIVE */
} ema_least_squares_result_t;

typedef enum {
    EMA_SQUARES_PREPARING = 0, /* models for the next march */
    EMA_SQUARES_MARCHING = 1,
    EMA_SQUARES_DECIDING = 2, /* on the next step */
    EMA_SQUARES_TRYING = 3,
    EMA_SQUARES_DONE = 4
} ema_squares_phase_t;

/* What a march knows of its point. */
typedef struct {
    ema_real x[EMA_LEAST_SQUARES_MAX]; /* in the unit box */
    ema_real square;                   /* S, and what its sum lost */
    ema_real square_low;
    ema_real normal[EMA_LEVMAR_TRIANGLE(EMA_LEAST_SQUARES_MAX)]; /* J'J, a triangle, per unit of x */
    ema_real part[EMA_LEVMAR_TRIANGLE(EMA_LEAST_SQUARES_MAX)]; /* of J'J, over the last rows: a long sum loses digits */
    ema_real gradient[EMA_LEAST_SQUARES_MAX];                  /* J'r, and what its sums lost */
    ema_real gradient_low[EMA_LEAST_SQUARES_MAX];
    ema_residual_t residual;
    ema_real size_square; /* of the measured signals over their noise, summed: what rounding grows with */
    ema_real reach[EMA_LEAST_SQUARES_MAX]; /* how far the runs beside it were moved */
    ema_real outside_ratio;
    bool pushed[2];
} ema_squares_point_t;

typedef struct {
    const ema_least_squares_config_t* config;
    ema_squares_phase_t phase;
    ema_outcome_t outcome;
    bool from_edge;  /* the descent began where another had ended on a bound */
    bool tried;      /* a trial has ended and is to be decided on */
    bool other_side; /* the march takes the sensitivities to the other side, after those to one */
    bool known;      /* a march has ended: there is a lowest point so far */
    bool failed;     /* of the present point no model can be made */
    ema_cursor_t cursor;
    uint32_t next_run; /* whose turn it is */
    uint32_t runs;
    uint32_t starts;
    uint32_t ended_alike; /* descents that have ended where the lowest did */
    uint64_t model_steps;
    uint32_t channels;
    ema_real inverse_noise[EMA_CHANNEL_COUNT]; /* 0: not compared */
    ema_real start_mm;
    ema_real damping;
    ema_real promised;                     /* fall of S by the step that is tried */
    ema_real first_square;                 /* S at the start */
    ema_real ended_square;                 /* lowest S at the end of an earlier descent */
    ema_real trial[EMA_LEAST_SQUARES_MAX]; /* in the unit box */
    ema_real trial_square;
    ema_real trial_square_low;
    ema_real reach[EMA_LEAST_SQUARES_MAX]; /* how far each run beside the present one is moved, in the unit box */
    ema_real
        delta[EMA_LEAST_SQUARES_MAX]; /* of the runs beside the present one, in the unit box; 0: none was possible */
    ema_levmar_t solver;
    ema_squares_point_t present;
    ema_squares_point_t best;
    ema_actuator_t actuator; /* with the values of the run that is prepared */
    ema_real command_mm;     /* of the present model step, for all runs */
    ema_output_t row_output[1U + EMA_LEAST_SQUARES_MAX];
    ema_step_scratch_t work; /* one for all of them */
    ema_state_t state[1U + EMA_LEAST_SQUARES_MAX];
    ema_plant_t plant[1U + EMA_LEAST_SQUARES_MAX];
} ema_least_squares_t;

/* Starts a search on `record`, which must outlive it and not grow meanwhile. Errors, `self` then not to be used:
 * EMA_ERR_NULL, also for the configuration's actuator; EMA_ERR_SHORT for fewer compared numbers in the record than
 * values; EMA_ERR_RANGE for a count, an id or a companion that is none or belongs to a learned table or an effect that
 * the build leaves out, bounds wider than a value's own range or its companion's, a companion of a value that is zero,
 * a start outside the bounds, a noise that is neither 0 nor within 1e-9..1e9, or is given for a signal that is not
 * recorded, or for none, or a budget below 1 + count; EMA_ERR_BOUNDS; those of ema_model_init at the start. Cost:
 * preparing one model. */
ema_status_t ema_least_squares_init(ema_least_squares_t* self, const ema_least_squares_config_t* config,
                                    const ema_record_t* record);

/* Runs for `steps` plain steps of work (ema_objective_run). Preparing a model, and deciding on a step, count as 160 of
 * them each, about what they take, and are not divided: a slice that has less left leaves them to the next one. A value
 * of which no model can be made costs the most and is left. Errors: EMA_ERR_NULL, also of one that was never begun;
 * EMA_ERR_RANGE for no steps. Once done, a call does nothing. */
ema_status_t ema_least_squares_run(ema_least_squares_t* self, uint32_t steps);

bool ema_least_squares_done(const ema_least_squares_t* self);

/* What is known now, at the lowest point that a march has passed. Errors: EMA_ERR_NULL; EMA_ERR_ORDER before the first
 * march has ended, 1 + count model runs; EMA_ERR_DIVERGED where it has ended and no march left finite numbers. Cost:
 * one Cholesky factor for each value. */
ema_status_t ema_least_squares_result(const ema_least_squares_t* self, ema_least_squares_result_t* result);

#ifdef __cplusplus
}
#endif

#endif
