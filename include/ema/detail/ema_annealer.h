/* Simulated annealing over the unit box, in up to 8 dimensions. It knows a vector and a cost, nothing of actuators.
 *
 * Ask and tell: the caller takes the candidate, evaluates it however it likes and in as many slices as it likes, and
 * tells its cost. The path is a function of configuration and costs alone.
 *
 *     while (ema_annealer_outcome(&a) == EMA_OUTCOME_ACTIVE) {
 *         cost = f(ema_annealer_candidate(&a));     a cost above ema_annealer_limit(&a) may be given up early
 *         ema_annealer_tell(&a, cost);
 *     }
 *
 * Acceptance is Metropolis': the candidate is taken when cost <= current - T log(u), u uniform and drawn before the
 * evaluation, so the limit is known beforehand. Temperature falls by a constant factor per evaluation; after every
 * `reanneal_interval` accepted candidates it is raised to the spread of the costs kept around the best point, and the
 * steps are widened. Candidates come from two sources: a walk along one coordinate whose steps adapt to an acceptance
 * rate of 0.44 (Corana et al., ACM Trans. Math. Softw. 13, 1987), and, once enough points are known, the Boltzmann
 * distribution at the present temperature of a quadratic fitted to the best points (the idea of adapting the steps to
 * the local shape of the cost is Vanderbilt and Louie's, J. Comput. Phys. 56, 1984). Above 4 dimensions the quadratic
 * is separable.
 */
#ifndef EMA_ANNEALER_H
#define EMA_ANNEALER_H

#include <stdbool.h>
#include <stdint.h>

#include "ema/detail/ema_random.h"
#include "ema/detail/ema_real.h"
#include "ema/detail/ema_status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define EMA_ANNEALER_DIMENSION_MAX 8U

/* Best points kept for the quadratic. */
#define EMA_ANNEALER_POINTS_MAX 36U

/* Why the search stopped, or that it has not. */
typedef enum {
    EMA_OUTCOME_TOLERANCE = 0, /* the best cost improved by less than the tolerance over the stall window */
    EMA_OUTCOME_ACTIVE = 1,
    EMA_OUTCOME_BUDGET = 2, /* the evaluations are used up */
    EMA_OUTCOME_COUNT = 3   /* the number of accepted candidates is reached */
} ema_outcome_t;

typedef struct {
    uint32_t dimension;                         /* 1 to 8 */
    ema_real start[EMA_ANNEALER_DIMENSION_MAX]; /* in [0, 1] */
    ema_real first_step;                        /* of each coordinate, in (0, 1] */
    ema_real initial_temperature;               /* in the unit of the cost, > 0 */
    ema_real cooling;                           /* factor per evaluation, in (0, 1) */
    ema_real function_tolerance;                /* in the unit of the cost, >= 0 */
    uint32_t stall_evaluations;                 /* length of the stall window, >= 1 */
    uint32_t reanneal_interval;                 /* accepted candidates between two reannealings; 0 never reanneals */
    uint32_t accept_limit;                      /* accepted candidates in all; 0 is no limit */
    uint32_t evaluation_budget;                 /* >= 1 */
    uint64_t seed;
} ema_annealer_config_t;

/* What happened so far. */
typedef struct {
    uint32_t evaluations;
    uint32_t accepted;
    uint32_t accepted_uphill;
    uint32_t from_quadratic; /* candidates that the quadratic proposed */
    uint32_t reannealed;
    uint32_t not_finite; /* costs that were no finite number; never accepted */
} ema_annealer_info_t;

typedef struct {
    ema_real x[EMA_ANNEALER_DIMENSION_MAX];
    ema_real cost;
} ema_annealer_point_t;

/* Elements of the lower triangle of a symmetric matrix. */
#define EMA_ANNEALER_TRIANGLE(size) (((size) * ((size) + 1U)) / 2U)

/* Unknowns of the quadratic: 15 when it is full in 4 dimensions, 17 when it is separable in 8. */
#define EMA_ANNEALER_UNKNOWNS_MAX 17U

/* The quadratic through the best points, and the memory of its fit: it means nothing between two candidates. */
typedef struct {
    ema_real scale[EMA_ANNEALER_DIMENSION_MAX];                         /* z = (x - best) / scale */
    ema_real lowest[EMA_ANNEALER_DIMENSION_MAX];                        /* z of the quadratic's minimum */
    ema_real factor[EMA_ANNEALER_TRIANGLE(EMA_ANNEALER_DIMENSION_MAX)]; /* Cholesky factor of its curvature in z */
    ema_real normal[EMA_ANNEALER_TRIANGLE(EMA_ANNEALER_UNKNOWNS_MAX)];  /* equations of the fit */
    ema_real right[EMA_ANNEALER_UNKNOWNS_MAX];
} ema_quadratic_t;

/* A plain value: a copy is a checkpoint. */
typedef struct {
    ema_outcome_t outcome;
    bool walked; /* the candidate came from the walk */
    ema_real temperature;
    ema_real limit;        /* cost above which the candidate is not wanted */
    ema_real accept_limit; /* cost up to which it is accepted; not above the limit */
    ema_real last_cost;    /* the cost told last; above the limit it is only a lower bound */
    ema_real stall_cost;   /* best cost at the start of the stall window */
    uint32_t stall_start;  /* evaluation at which it started */
    uint32_t point_count;
    uint32_t accepted_since; /* since the last reannealing */
    uint32_t coordinate;     /* that the walk moves next */
    ema_annealer_info_t info;
    ema_annealer_config_t config;
    ema_random_t random;
    ema_real step[EMA_ANNEALER_DIMENSION_MAX];
    ema_annealer_point_t current;
    ema_annealer_point_t best;
    ema_annealer_point_t candidate;
    ema_annealer_point_t points[EMA_ANNEALER_POINTS_MAX];
    ema_quadratic_t quadratic;
} ema_annealer_t;

/* Starts a search; the first candidate is the start. Errors: EMA_ERR_NULL; EMA_ERR_RANGE for a setting outside its
 * range (NaN included). Cost: constant. */
ema_status_t ema_annealer_init(ema_annealer_t* annealer, const ema_annealer_config_t* config);

/* Moves the start of a search that has been told no cost yet, and gives it another temperature than the
 * configuration's: for whoever learns of them after ema_annealer_init. Errors, nothing changed: EMA_ERR_NULL;
 * EMA_ERR_ORDER once a cost was told; EMA_ERR_RANGE for a coordinate outside [0, 1] or a temperature that is negative,
 * not finite or above what the configuration may have. Cost: constant. */
ema_status_t ema_annealer_restart(ema_annealer_t* annealer, const ema_real* start, ema_real temperature);

/* The point to evaluate, `dimension` numbers in [0, 1]. */
const ema_real* ema_annealer_candidate(const ema_annealer_t* annealer);

/* A cost above this changes nothing by its value: the evaluation may be given up as soon as it is exceeded. */
ema_real ema_annealer_limit(const ema_annealer_t* annealer);

/* Takes the candidate's cost, decides, and prepares the next candidate. Does nothing once the search has ended.
 * Cost: at most one least-squares fit of 17 unknowns to 36 points, in the annealer's own memory. */
void ema_annealer_tell(ema_annealer_t* annealer, ema_real cost);

/* Whether and why the search ended. */
ema_outcome_t ema_annealer_outcome(const ema_annealer_t* annealer);

/* Whether a search can work with its settings, before it is begun: ema_annealer_init refuses what means nothing, this
 * says what means something and will not reach the lowest cost. A firmware that does not call it links none of it.
 *
 * The rules stand in docs/FIRMWARE.md; how often they are right is counted in docs/ROBUSTNESS.md.
 */

/* What is wrong and what to do; a set of bits. */
/* EMA-D1 */
#define EMA_ANNEALER_WARNING_LIST(X)                                                                                   \
    X(EMA_WARNING_START, 1, "the start of the search lies outside its bounds: widen them")                             \
    X(EMA_WARNING_FEW, 2, "evaluation_budget is too small to search so many values: allow 30 model runs for each")     \
    X(EMA_WARNING_HOT, 4,                                                                                              \
      "the evaluations are used up before the search is cold: raise evaluation_budget, or lower cooling or "           \
      "initial_temperature")                                                                                           \
    X(EMA_WARNING_COLD, 8,                                                                                             \
      "initial_temperature lies so far below function_tolerance that nothing is searched: raise the one or lower the " \
      "other")                                                                                                         \
    X(EMA_WARNING_TOLERANCE, 16,                                                                                       \
      "function_tolerance is larger than what the sensor resolves, so the search ends before its lowest cost: lower "  \
      "it")                                                                                                            \
    X(EMA_WARNING_REANNEALED, 32,                                                                                      \
      "reanneal_interval is so short that the search never cools: raise it to 10 or more, 60 say")

enum {
#define EMA_WARNING_ENUM(name, bit, text) name = (bit), /* EMA-D1 */
    EMA_ANNEALER_WARNING_LIST(EMA_WARNING_ENUM)
#undef EMA_WARNING_ENUM
};

/* The warnings for `config`. `resolution` is the difference of two costs that just matters, in their unit: by what one
 * standard error of a parameter raises the cost; for a position alone, squared sensor noise times the record's period
 * (mm^2 s). Zero, or anything that is no positive finite number, is unknown: the function tolerance takes its place,
 * and what needs more than that is not judged. Does not look for what ema_annealer_init refuses, the start aside; NULL
 * has no warnings. Cost: three logarithms. */
uint32_t ema_annealer_check(const ema_annealer_config_t* config, ema_real resolution);

/* The text of one warning, a constant string; "unknown warning" for anything but one bit of the list. Cost: a handful
 * of comparisons. */
const char* ema_annealer_warning_text(uint32_t warning);

#ifdef __cplusplus
}
#endif

#endif
