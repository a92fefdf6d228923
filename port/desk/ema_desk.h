/* The module as flat arrays of double, for tools at a desk: Python reaches it by ctypes, from both precisions alike.
 *
 * An actuator is `values[ema_desk_value_count()]` and `options[ema_desk_option_count()]`: first the real parameters in
 * the order of ema_params.def, then the values of all effects in the order of ema_effects.def; options in the order of
 * ema_params.def. Every function answers an ema_status_t as int, 0 for success, unless it says otherwise. No function
 * keeps state.
 */
#ifndef EMA_DESK_H
#define EMA_DESK_H

#include <stddef.h>
#include <stdint.h>

/* A row of ema_params.def, or a value of an effect. */
typedef struct {
    const char* section; /* TOML table; empty for an effect's value */
    const char* field;
    const char* text;
    const char* choices; /* options: "a|b", or empty for a whole number */
    double nominal;
    double lower;
    double upper;
    int32_t is_option;
} ema_desk_row_t;

/* A row of ema_effects.def, or of the user's own list behind it. */
typedef struct {
    const char* name;
    const char* site; /* as the list writes it: a learned table's ends in _TABLE */
    const char* equation;
    const char* source;
    const char* look_alikes;
    int32_t memory;
    int32_t substeps;
    int32_t is_learned; /* a table that holds what was learned from records */
    int32_t is_own;
    int32_t first_value; /* index of its first value among those of all effects */
    int32_t value_count;
} ema_desk_effect_t;

int32_t ema_desk_real_bits(void); /* 32 or 64 */
int32_t ema_desk_value_count(void);
int32_t ema_desk_option_count(void);
uint32_t ema_desk_schema(void);  /* EMA_CONFIG_SCHEMA of the lists that it was built from */
uint32_t ema_desk_version(void); /* EMA_VERSION */

/* The two lists in their own order: real parameters and options as they stand among each other, effects, and the values
 * of all effects one after the other. EMA_ERR_NULL; EMA_ERR_RANGE behind the last row. */
int32_t ema_desk_parameter_row(int32_t index, ema_desk_row_t* row);
int32_t ema_desk_effect_row(int32_t index, ema_desk_effect_t* row);
int32_t ema_desk_effect_value_row(int32_t index, ema_desk_row_t* row);
const char* ema_desk_status_text(int32_t status);

/* Text and EMA_REASON_ bit of the index-th reason why a verdict is undecided; NULL behind the last. */
const char* ema_desk_reason_text(int32_t index, int32_t* bit);

/* Checks an actuator; on EMA_ERR_RANGE or EMA_ERR_NOT_FINITE `offender` is the value's index, or value count + option
 * index. */
int32_t ema_desk_check(const double* values, const int32_t* options, int32_t* offender);

/* Simulates `rows` recorded rows with the command of each row held over its model steps. `out` is five arrays of
 * `rows`, one after the other: rod position mm, motor position mm, current A, voltage V, rod speed mm/s.
 * `unlocated_event_steps` (may be NULL) counts steps with more events than are located. */
int32_t ema_desk_simulate(const double* values, const int32_t* options, const double* command_mm, int32_t rows,
                          double start_mm, double* out, int32_t* unlocated_event_steps);

/* Samples a command at `rows` steps of `step_s`: kind as ema_command_kind_t; numbers = amplitude_mm, start_hz, end_hz,
 * duration_s, share, count, time_s. */
int32_t ema_desk_command(int32_t kind, const double* numbers, double step_s, int32_t rows, double* command_mm);

/* The integral of the weighted squared error of a simulated run (mm^2 s with weight 1 on the rod position). channels:
 * rows x 4 (rod mm, motor mm, A, V), row by row. */
int32_t ema_desk_objective(const double* values, const int32_t* options, const double* command_mm,
                           const double* channels, const double* weight, int32_t rows, double start_mm,
                           double* objective);

/* Identification by the onboard session. */
typedef struct {
    int32_t identified_count;
    int32_t identified_id[4]; /* value indices */
    double identified_lower[4];
    double identified_upper[4];
    double identified_min_shift_percent[4];
    double weight[4];
    double start[4]; /* in the parameters' units; used when start_at_healthy is 0 */
    int32_t start_at_healthy;
    int32_t abandon;
    int32_t int16_record; /* keep the record as scaled int16 instead of reals */
    int32_t slice_steps;  /* model steps per run call, >= 1 */
    int32_t evaluation_budget;
    int32_t reanneal_interval;
    double initial_temperature;
    double cooling;
    double function_tolerance;
    int64_t seed;
    int32_t search; /* ema_search_t */
} ema_desk_search_t;

typedef struct {
    double estimate[4];
    double std[4];
    double shift_percent[4];
    int32_t at_bound[4];
    double objective_before;
    double objective_after;
    double residual_rms_mm;
    double residual_correlation;
    int64_t model_steps;
    int32_t evaluations;
    int32_t accepted;
    int32_t accepted_uphill;
    int32_t outcome; /* ema_outcome_t */
    int32_t verdict; /* ema_verdict_t */
    int32_t adequate;
    int32_t reasons; /* EMA_REASON_ bits */
    uint64_t random_state;
    double bias[4];    /* of the estimates, as in ema_estimate_t */
    double half_95[4]; /* of their 95 % intervals: see ema_session_half_95 */
    double scatter_percent[4];
    double today[4];
    int32_t stage; /* ema_stage_t */
} ema_desk_result_t;

/* A table of signatures as ema_signatures_t has it. Each row of `pattern` is effect, first, rows, one_sided, turn[3],
 * penalty; each of `fault` value index, row, healthy, turn, length. */
typedef struct {
    int32_t version;
    uint32_t fingerprint;
    int32_t record_rows;
    int32_t bin_rows;
    int32_t bins;
    int32_t channels;
    int32_t channel[4];
    int32_t patterns;
    int32_t faults;
    int32_t nuisances;
    int32_t rows;
    int32_t values; /* numbers in `value` */
    double command_unit_mm;
    double command_apart_mm;
    double reference[4];
    double weight[4];
    double limit;
    double energy;
    const double* pattern; /* patterns x 8 */
    const double* fault;   /* faults x 5 */
    const double* unit;    /* rows */
    const int16_t* value;
} ema_desk_table_t;

/* ema_finding_t. Effects are rows of the list, EMA_EFFECT_COUNT for none. */
typedef struct {
    int32_t kind; /* ema_finding_kind_t */
    int32_t effect;
    int32_t runner_up;
    uint64_t alike;
    double score;
    double runner_up_score;
    double limit;
    double size;
    double energy;
    double moved[2];
} ema_desk_finding_t;

/* Called after each model run of the annealer with the run's number, the cost found, the best so far, and the
 * identified_count values that were tried, in the parameters' units, or NULL where one slice ended more than one run;
 * of the least squares after their runs side by side, with the best point alone. May be NULL. A return other than 0
 * stops the search. */
typedef int32_t (*ema_desk_progress_t)(int32_t evaluation, double cost, double best, const double* tried,
                                       void* context);

/* The search's settings that the actuator's own tables give. */
int32_t ema_desk_search_default(const double* values, const int32_t* options, ema_desk_search_t* search);

/* Feeds the record to a session and runs it to its end. channels as in ema_desk_objective. A row that cannot be taken:
 * `bad_row` (may be NULL). */
int32_t ema_desk_identify(const double* values, const int32_t* options, const double* command_mm,
                          const double* channels, int32_t rows, const ema_desk_search_t* search,
                          ema_desk_progress_t progress, void* context, ema_desk_result_t* result, int32_t* bad_row);

/* The same behind a table, as ema_guarded.h does it: float32 and a record of reals that hold what the firmware's record
 * holds give the firmware's bits. EMA_ERR_TABLE for a table whose numbers do not fit each other. */
int32_t ema_desk_identify_guarded(const double* values, const int32_t* options, const double* command_mm,
                                  const double* channels, int32_t rows, const ema_desk_search_t* search,
                                  const ema_desk_table_t* table, ema_desk_progress_t progress, void* context,
                                  ema_desk_result_t* result, ema_desk_finding_t* finding, int32_t* bad_row);

/* Text and EMA_WARNING_ bit of the index-th warning of a search's settings; NULL behind the last. */
const char* ema_desk_warning_text(int32_t index, int32_t* bit);

/* The warnings, a set of bits, that ema_session_check has for this search. */
int32_t ema_desk_search_check(const double* values, const int32_t* options, const ema_desk_search_t* search,
                              int32_t* warnings);

#define EMA_DESK_DIMENSION_MAX 8

/* ema_annealer_config_t; candidates are accepted without limit. */
typedef struct {
    int32_t dimension;
    double start[EMA_DESK_DIMENSION_MAX]; /* in [0, 1] */
    double first_step;
    double initial_temperature;
    double cooling;
    double function_tolerance;
    int32_t stall_evaluations;
    int32_t reanneal_interval;
    int32_t evaluation_budget;
    int64_t seed;
} ema_desk_annealer_t;

typedef struct {
    double x[EMA_DESK_DIMENSION_MAX]; /* the best point */
    double cost;
    int32_t evaluations;
    int32_t outcome; /* ema_outcome_t; active where it was stopped */
} ema_desk_annealed_t;

/* Writes the cost of `x`, of which a cost above `limit` may be given up early; a return other than 0 stops the search.
 */
typedef int32_t (*ema_desk_cost_t)(const double* x, double limit, double* cost, void* context);

/* Runs the module's annealer on a cost of the caller's own. Errors: EMA_ERR_NULL, those of ema_annealer_init. */
int32_t ema_desk_anneal(const ema_desk_annealer_t* settings, ema_desk_cost_t cost, void* context,
                        ema_desk_annealed_t* annealed);

#define EMA_DESK_SEARCHED_MAX 8

/* ema_least_squares_config_t; everything in the values' and the signals' own units. */
typedef struct {
    int32_t count;
    int32_t id[EMA_DESK_SEARCHED_MAX];   /* value indices */
    int32_t with[EMA_DESK_SEARCHED_MAX]; /* companions; the value's own index for none */
    double lower[EMA_DESK_SEARCHED_MAX];
    double upper[EMA_DESK_SEARCHED_MAX];
    double start[EMA_DESK_SEARCHED_MAX];
    double noise[4]; /* 0: not compared */
    int32_t run_budget;
    int32_t restarts;
    int32_t int16_record;
    int32_t slice_steps; /* model steps per run call, >= 1 */
} ema_desk_squares_t;

/* ema_least_squares_result_t; standard errors and biases of a value that is not told from the others are negative. */
typedef struct {
    double estimate[EMA_DESK_SEARCHED_MAX];
    double std[EMA_DESK_SEARCHED_MAX];
    double bias[EMA_DESK_SEARCHED_MAX];
    double noise_std[EMA_DESK_SEARCHED_MAX];
    int32_t determined[EMA_DESK_SEARCHED_MAX]; /* ema_determined_t */
    int32_t partner[EMA_DESK_SEARCHED_MAX];
    int32_t at_bound[EMA_DESK_SEARCHED_MAX];
    double misfit_before;
    double misfit_after;
    double residual_rms_mm;
    double residual_correlation;
    int64_t model_steps;
    int32_t runs;
    int32_t starts;
    int32_t outcome; /* ema_outcome_t */
    int32_t crossed;
    int32_t adequate;
} ema_desk_squares_result_t;

/* Called after each march with the model runs so far, the rms of the residual over the noise and the `count` values,
 * both at the lowest point so far; may be NULL. A return other than 0 stops the search. */
typedef int32_t (*ema_desk_squares_progress_t)(int32_t runs, double misfit, const double* lowest, void* context);

/* Searches several values by the module's least squares. channels as in ema_desk_objective; a row that cannot be taken:
 * `bad_row` (may be NULL). Errors besides: those of ema_least_squares_init and ema_least_squares_result. */
int32_t ema_desk_least_squares(const double* values, const int32_t* options, const double* command_mm,
                               const double* channels, int32_t rows, const ema_desk_squares_t* search,
                               ema_desk_squares_progress_t progress, void* context, ema_desk_squares_result_t* result,
                               int32_t* bad_row);

/* ema_outlook_t; a time that is open is negative. */
typedef struct {
    double odds_log;
    double now_percent;
    double now_std_percent;
    double by_percent;
    double rate_percent_per_day;
    double rate_std_percent_per_day;
    double low_days;
    double median_days;
    double high_days;
    double reached_ratio;
    double ahead_days;
    int32_t drifts;
    int32_t towards;
} ema_desk_outlook_t;

/* The module's trend on `readings` readings. After each of the `looks` counts of readings, in rising order, an outlook,
 * worked out in slices of `slice_laws`; `saving` other than 0: put into bytes and restored after every reading. What is
 * refused: ema_trend_status_t, and by `bad_reading` (may be NULL) at which reading. */
int32_t ema_desk_trend(const double* time_days, const double* value_percent, const double* std_percent,
                       int32_t readings, double limit_percent, double false_alarm_ratio, const int32_t* look,
                       int32_t looks, int32_t slice_laws, int32_t saving, ema_desk_outlook_t* outlook,
                       int32_t* bad_reading);

/* The text of an ema_trend_status_t. */
const char* ema_desk_trend_text(int32_t status);

/* The first `count` numbers of the module's generator, for its reference vectors. */
int32_t ema_desk_random(int64_t seed, int64_t stream, int32_t count, uint32_t* bits);

/* The module's equations at the points of a record. An actuator is taken as it is, whether or not it could be
 * simulated. */

/* The values with what the effects at site PARAMETER make of them; the inertia is the total one, a transmission's mass
 * in it. */
int32_t ema_desk_adjusted(const double* values, const int32_t* options, double* adjusted);

/* Sum over the active effects of `site`, an ema_effect_site_t while the model runs other than PRESLIDING,
 * TRANSMISSION, WINDING and GREASE. `points` is seven arrays of `rows`, one after the other: current A, speed rad/s,
 * angle rad, motor position mm (READING: the rod's), voltage V, level of dry friction Nm and its direction. */
int32_t ema_desk_site(const double* values, const int32_t* options, int32_t site, const double* points, int32_t rows,
                      double* sum);

/* Relative change of what warms while a record runs, at each of its rows: of the winding's resistance (`site` WINDING)
 * or of dry and viscous friction (GREASE); the current changes evenly between rows, which are `period_s` apart. */
int32_t ema_desk_warmth(const double* values, const int32_t* options, int32_t site, const double* current_A,
                        int32_t rows, double period_s, double* change);

/* Share of the level of dry friction, -1 to 1, that a contact carries which stretches before it slides, unstretched at
 * the first row; zero without such an effect. */
int32_t ema_desk_contact(const double* values, const int32_t* options, const double* angle_rad, int32_t rows,
                         double* share);

/* The share after a turn from the one before, row by row; zero without such an effect. */
int32_t ema_desk_contact_after(const double* values, const int32_t* options, const double* before,
                               const double* turn_rad, int32_t rows, double* share);

/* Output of the play behind a motor position, from `start_mm`. */
int32_t ema_desk_play(const double* values, const int32_t* options, const double* motor_mm, int32_t rows,
                      double start_mm, double* play_mm);

/* Output of the control law for a command and a feedback as the sensor reads it, one row per record period;
 * EMA_ERR_RANGE when the feedback is delayed by more steps than the module keeps. */
int32_t ema_desk_controller(const double* values, const int32_t* options, const double* command_mm,
                            const double* feedback_mm, int32_t rows, double* output);

#endif
