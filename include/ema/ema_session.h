/* The whole module behind four calls: init, feed, run, result.
 *
 *     ema_session_init(&session, &config);
 *     ema_session_feed(&session, &sample);                 at every recorded instant of the ground chirp
 *     while (ema_session_run(&session, 200) == EMA_OK && ema_session_phase(&session) != EMA_PHASE_DONE) { }   in slices
 *     ema_session_result(&session, &result);
 *
 * The session is one structure of the caller; with the record's buffer it is all the memory there is: under 9 KiB and 4
 * bytes a row of command and rod position as int16. The deepest call takes half a KiB of stack in float32:
 * docs/BUDGETS.md. It is a plain value apart from the pointers to the configuration and the buffer: a copy is a
 * checkpoint. The result does not depend on the slices.
 *
 * The search has two stages, EMA_SEARCH_TWO_STAGES, the default. The first is a damped Gauss-Newton descent (Marquardt,
 * J. SIAM 11, 1963) from the start over all searched values. Each step takes 1 + identified_count model runs side by
 * side; a step by which the cost does not fall is shortened up to three times. The descent ends when the linear model
 * promises less than a hundredth of the fall that one standard error makes, or than the annealer's function_tolerance.
 * Its end is the answer when the sensor's noise explains the residual and no value lies on a bound. Otherwise a second
 * descent starts half a healthy value away in each value, and its end is the answer when it has the same cost within
 * 1e-4. In all other cases the annealer goes on from the best point, at a temperature of a thousandth of the cost at
 * the healthy values, with the evaluations of `annealer.evaluation_budget` that are left. ema_result_t says which stage
 * gave the answer. With EMA_SEARCH_ANNEALER the annealer searches alone, from the start.
 */
#ifndef EMA_SESSION_H
#define EMA_SESSION_H

#include "ema/detail/ema_annealer.h"
#include "ema/detail/ema_objective.h"
#include "ema/detail/ema_onboard.h"
#include "ema/detail/ema_sensitivity.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Fewest rows that are identified from. */
#define EMA_ROWS_MIN 100U

/* One parameter to identify and its bounds; its healthy value is the actuator's and must not be zero. */
typedef struct {
    ema_value_id_t id;
    ema_real lower;
    ema_real upper;
    ema_real min_shift_percent; /* smallest shift, in % of the healthy value, that is called a fault */
} ema_identified_t;

/* How the best point is searched; any other value is the first. */
typedef enum {
    EMA_SEARCH_ANNEALER = 0,  /* by the annealer alone, as in Dalla Vedova et al. */
    EMA_SEARCH_TWO_STAGES = 1 /* by least squares first, and by the annealer where that does not settle it */
} ema_search_t;

/* Which stage gave the best point. */
typedef enum { EMA_STAGE_ANNEALER = 0, EMA_STAGE_LEAST_SQUARES = 1 } ema_stage_t;

/* Constant during the session and must outlive it. */
typedef struct {
    ema_search_t search;
    bool start_at_healthy; /* else at `annealer.start` */
    bool abandon;          /* give a run up once it exceeds what the annealer could use; changes no decision */
    uint32_t identified_count;
    const ema_actuator_t* actuator; /* healthy */
    ema_identified_t identified[EMA_IDENTIFIED_MAX];
    ema_record_config_t record;
    ema_real weight[EMA_CHANNEL_COUNT]; /* of the objective, by ema_channel_t */
    ema_annealer_config_t annealer;     /* dimension and start are set by the session */
} ema_session_config_t;

typedef enum {
    EMA_PHASE_FEEDING = 0,
    EMA_PHASE_SEARCHING = 1,
    EMA_PHASE_ASSESSING = 2, /* standard errors and adequacy at the best point */
    EMA_PHASE_DONE = 3
} ema_phase_t;

typedef enum { EMA_VERDICT_HEALTHY = 0, EMA_VERDICT_FAULT = 1, EMA_VERDICT_UNDECIDED = 2 } ema_verdict_t;

/* Why a verdict is undecided; a set of bits. A shift is near its threshold when they are closer than standard errors at
 * the stated confidence and bias together, or when it lies beyond it and within as many standard deviations of what the
 * actuator says that healthy runs are read apart (csj_scatter_percent, blk_scatter_percent); a record does not
 * determine the parameters when there is too much doubt about one, or the rod was never pushed both ways.
 * EMA_REASON_EFFECT is of ema_guarded.h. */
/* EMA-D1 */
#define EMA_REASON_LIST(X)                                                                                             \
    X(EMA_REASON_NOT_FINISHED, 1, "the search has not ended")                                                          \
    X(EMA_REASON_INADEQUATE, 2,                                                                                        \
      "the residual is larger than the sensor noise explains: an effect is missing from the model")                    \
    X(EMA_REASON_AT_BOUND, 4, "an estimate lies on a bound of its search")                                             \
    X(EMA_REASON_NOT_CONVERGED, 8, "the evaluations were used up while the cost still fell")                           \
    X(EMA_REASON_NEAR_THRESHOLD, 16, "a shift cannot be told from its threshold with the stated confidence")           \
    X(EMA_REASON_NOT_SENSITIVE, 32, "the record does not determine the parameters")                                    \
    X(EMA_REASON_BELOW_HEALTHY, 64, "a parameter fell by more than its threshold, which wear does not do")             \
    X(EMA_REASON_LEARNED_RANGE, 128, "a learned table was used outside the range it was seen in")                      \
    X(EMA_REASON_EFFECT, 256, "the table of signatures shows an effect that is missing from the model")                \
    X(EMA_REASON_OTHER_COMMAND, 512,                                                                                   \
      "the record runs another command than the ground test, for which table and thresholds hold")                     \
    X(EMA_REASON_GAP, 1024, "samples of the record were missed: run the ground test again")

enum {
#define EMA_REASON_ENUM(name, bit, text) name = (bit), /* EMA-D1 */
    EMA_REASON_LIST(EMA_REASON_ENUM)
#undef EMA_REASON_ENUM
};

typedef struct {
    ema_real estimate; /* in the parameter's own unit; CSJ as at the temperature of the healthy runs, where the actuator
                          says what a degree does to it and grease and winding are searched beside it */
    ema_real today;    /* as the search reads it: the model's own value on the record's day */
    ema_real std;      /* standard error from the residual and the sensitivities */
    ema_real bias;     /* how far it may be off besides, for what lasts in the residual: see ema_sensitivity.h */
    ema_real scatter_percent; /* how far a sound machine is read apart today, standard deviation in % of the healthy
                                 value; 0 of what the actuator says nothing of */
    ema_real shift_percent;   /* (estimate - healthy) / healthy * 100 */
    bool at_bound;
} ema_estimate_t;

typedef struct {
    ema_estimate_t identified[EMA_IDENTIFIED_MAX]; /* in the order of the configuration */
    uint32_t identified_count;
    ema_real objective_before;     /* at the healthy values */
    ema_real objective_after;      /* at the best point */
    ema_real residual_rms_mm;      /* of the rod position at the best point */
    ema_real residual_correlation; /* of neighbouring rows: 0 is white */
    ema_real
        outside_ratio;    /* farthest that a learned table was used outside the range it was seen in, over that range */
    uint32_t evaluations; /* model runs: the search's, plus those before and after it */
    uint64_t model_steps; /* in all of them, counting only steps that were made */
    ema_annealer_info_t search; /* of the annealer: zero where the first stage gave the answer */
    ema_random_t random;        /* final state of the random numbers: equal on every machine */
    ema_outcome_t outcome;      /* why the search stopped */
    ema_stage_t stage;          /* that gave the best point; before the end: that runs */
    ema_verdict_t verdict;
    bool adequate;
    uint32_t reasons; /* EMA_REASON_ bits */
} ema_result_t;

typedef struct {
    ema_phase_t phase;
    ema_stage_t stage;
    bool gap;             /* samples were missed or refused */
    bool starts_healthy;  /* the search starts at the healthy values */
    bool starts_cool;     /* the annealer's start is known to be near: its temperature follows from the healthy cost */
    bool healthy_done;    /* the cost at the healthy values is known */
    bool assessed;        /* models beside the estimate could be made */
    bool settled;         /* least squares: the present point is evaluated once more, for its sums */
    bool second_start;    /* least squares: from the other place */
    uint8_t failed_steps; /* least squares: in a row */
    const ema_session_config_t* config;
    uint32_t evaluations;
    uint64_t model_steps;
    ema_record_t record;
    ema_annealer_t annealer;
    ema_actuator_t actuator;           /* with the identified values where the present run has them */
    ema_real healthy_cost;             /* here, so that the 64-bit members leave no gap */
    ema_real promised;                 /* least squares: fall of the cost by the step that is tried, over that of one
                                          standard error */
    ema_real ended_cost;               /* least squares: where the first descent ended */
    union {                            /* one after the other */
        ema_sensitivity_t sensitivity; /* the model runs of the search and at its end, one or side by side */
        ema_onboard_t
            scoring; /* beside a table of signatures, before the search and after the assessment: ema_guarded.h */
    };
} ema_session_t;

/* Fills `config` for the two parameters of the actuator's [search] table, CSJ and BLK, the rod position alone, both
 * stages of the search and the given record. */
ema_status_t ema_session_config_default(ema_session_config_t* config, const ema_actuator_t* actuator,
                                        const ema_record_config_t* record);

/* Where the actuator's [search] day_values says so, adds what differs from day to day to what `config` identifies: the
 * screw's viscous friction and the winding's resistance, those that the actuator has. They are searched within what
 * temperatures make of them and are never a fault; without them CSJ and BLK take up what grease and winding do. Where
 * the actuator says what a degree makes of a sound machine's CSJ (csj_per_degC_percent), the two tell how warm it is,
 * and CSJ is stated as at the temperature of the healthy runs. Where they contradict each other by day_apart_degC,
 * one of them has changed by something else: CSJ is stated as read, and scatters as on any day and by all that the
 * temperature which both allow may make of it. In a configuration of one's own that goes for values that stand behind
 * CSJ. Costs about half as many model runs again, and up to two more in each step of the first stage. To be called
 * after ema_session_config_default. Errors, nothing changed: EMA_ERR_NULL; EMA_ERR_RANGE when there is no room for
 * them. */
ema_status_t ema_session_config_day(ema_session_config_t* config);

/* Whether the search can work as `config` has it: ema_annealer_check with the session's own start, and the sensor's
 * noise where the rod position alone is weighted. EMA_WARNING_ bits, 0 for none, and for a configuration without
 * actuator. Nothing but a warning: a search with any of them runs, and its verdict is as sound as it says. Cost: that
 * of ema_annealer_check. */
uint32_t ema_session_check(const ema_session_config_t* config);

/* Starts an empty session. Errors: EMA_ERR_NULL; those of ema_actuator_check, ema_record_init and ema_annealer_init;
 * EMA_ERR_BOUNDS; EMA_ERR_RANGE for a number of parameters, an id (a value of a learned table, or of an effect that the
 * build leaves out, is none) or the same one twice, bounds wider than the parameter's own range, a healthy value
 * outside its bounds, a weight that is negative, not finite or on a channel that is not kept, no weight at all, or a
 * least shift that is negative (one so large that nothing exceeds it makes a value that is never a fault). */
ema_status_t ema_session_init(ema_session_t* session, const ema_session_config_t* config);

/* Takes one recorded row: what was commanded from that instant on, and what the sensors said at it. Errors, nothing
 * changed: EMA_ERR_NULL; EMA_ERR_ORDER once the search runs, and for zeroed memory that was never started;
 * EMA_ERR_FULL. The other errors of ema_record_append leave the record unchanged, but the refused row is missing in it:
 * as after ema_session_gap the verdict will be UNDECIDED with EMA_REASON_GAP. */
ema_status_t ema_session_feed(ema_session_t* session, const ema_sample_t* sample);

/* Takes `rows` rows that lie in the record's buffer already, as ema_record_adopt. Errors, nothing changed:
 * EMA_ERR_NULL; EMA_ERR_ORDER as of ema_session_feed; those of ema_record_adopt. */
ema_status_t ema_session_adopt(ema_session_t* session, uint32_t rows);

/* Says that samples between the last row and the next were missed, or that rows lie in another order than they were
 * measured: rows have one period, so the record is another one, and the verdict will be UNDECIDED with EMA_REASON_GAP.
 * Once is enough, and it is forgotten by ema_session_init alone. Errors, nothing changed: EMA_ERR_NULL; EMA_ERR_ORDER
 * as of ema_session_feed. */
ema_status_t ema_session_gap(ema_session_t* session);

/* Runs for `steps` plain steps of work: so many model steps where nothing happens and no effect acts, fewer otherwise,
 * so that a slice takes about as long whatever the machine does (ema_step_scratch.h); the first call ends the feeding.
 * Errors: EMA_ERR_NULL; EMA_ERR_ORDER for zeroed memory that was never started; EMA_ERR_RANGE for no steps, by which a
 * loop would never end, and when the configuration has another number of parameters than at the start; EMA_ERR_SHORT
 * for fewer than EMA_ROWS_MIN rows (feeding may go on); those of ema_model_init and of the weights at the first call,
 * which can then be repeated. Later calls answer EMA_OK: a candidate of which no model can be made counts as the worst.
 * Cost: that work, and the rest of the step that reaches it. Two parts are not divided: preparing a model counts as 110
 * plain steps, and what follows from ended runs as 20 + 3 n^3 with n values. A slice that has less left leaves such a
 * part to the next one; the first slice begins with the first model. The longest slices of 200 that were found, over
 * effects, commands and records: docs/BUDGETS.md. Once done, a call does nothing. */
ema_status_t ema_session_run(ema_session_t* session, uint32_t steps);

/* EMA_PHASE_FEEDING of none. */
ema_phase_t ema_session_phase(const ema_session_t* session);

/* What is known now: the best point so far while the search runs, with verdict UNDECIDED. Errors: EMA_ERR_NULL;
 * EMA_ERR_ORDER before the first run; EMA_ERR_RANGE for another number of parameters, as of ema_session_run. */
ema_status_t ema_session_result(const ema_session_t* session, ema_result_t* result);

/* Half of the 95 % interval about the estimate at `place` of a result: its standard error, its bias and, of CSJ and
 * BLK, what the actuator's csj_scatter_percent and blk_scatter_percent say of one run to the next, as independent;
 * scatter is a share of the value, of the healthy one where that is larger. The whole width of the search where the
 * record does not determine the parameter or the search has not ended. Errors, nothing changed: EMA_ERR_NULL;
 * EMA_ERR_RANGE for a place that is none. Cost: one square root. */
ema_status_t ema_session_half_95(const ema_session_config_t* config, const ema_result_t* result, uint32_t place,
                                 ema_real* half_95);

/* The text of one reason, a constant string; "unknown reason" for anything but one bit of the list. Cost: a handful of
 * comparisons. */
const char* ema_reason_text(uint32_t reason);

#ifdef __cplusplus
}
#endif

#endif
