/* How well a record determines the identified parameters: model runs side by side, one at the estimate and one beside
 * it per parameter.
 *
 * With J the sensitivities of the weighted channels, the standard errors are sqrt(diag((J'J)^-1) s^2), s^2 the
 * residual's mean square. Neighbouring residuals that are alike carry less information than their number says: with
 * correlation rho of neighbours s^2 is widened by (1 + rho) / (1 - rho), the factor of a first-order autoregressive
 * residual. White noise leaves rho near 0 and the errors as they are.
 *
 * What stands in the residual for longer than noise does, though little of it, comes from something that the fit has
 * partly taken for a parameter: a sensor that saturates, a clock, a lag. How far the estimate may be off for that is
 * its bias: a third of what is shared, as if it lay along the parameter's own signature. The share is measured: of the
 * records in docs/FAULTS.md, and of others spoilt at random, none needed more. What the sensor's own noise shares
 * (`shared_noise_mm` of the actuator) is no bias: it widens the errors and nothing else.
 */
#ifndef EMA_SENSITIVITY_H
#define EMA_SENSITIVITY_H

#include "ema/ema_model.h"
#include "ema/ema_record.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Parameters whose sensitivities are taken at once: sets the memory. */
#define EMA_IDENTIFIED_MAX 4U

/* What is summed of the residual at the estimate. */
typedef struct {
    ema_real position_square; /* of the rod position */
    ema_real position_neighbours;
    ema_real position_last_mm;
    ema_real weighted_square; /* of all weighted channels */
    ema_real block_mm;        /* of the rod position, summed over the rows of a block so far */
    ema_real block_square;    /* of whole blocks */
} ema_residual_t;

typedef struct {
    ema_cursor_t cursor;
    bool pushed[2]; /* the run at the estimate has pushed the rod back, and forward */
    ema_real weight[EMA_CHANNEL_COUNT];
    ema_real delta[EMA_IDENTIFIED_MAX];
    ema_real normal[(EMA_IDENTIFIED_MAX * (EMA_IDENTIFIED_MAX + 1U)) / 2U]; /* J'J, lower triangle row by row */
    ema_real gradient[EMA_IDENTIFIED_MAX];                                  /* J'r, r measured minus simulated */
    ema_residual_t residual;
    ema_real period_s; /* of the record */
    ema_real cost;     /* the objective of the run at the estimate, bit for bit that of ema_objective.h */
    ema_real cost_low;
    ema_real limit;           /* the runs are given up once the cost exceeds it */
    ema_real shared_noise_mm; /* of the rod position's sensor */
    uint32_t parameters;      /* 0: the run at the estimate alone, for its cost */
    uint32_t channels;
    uint32_t prepared;   /* runs whose model is made */
    uint32_t next_run;   /* whose turn it is */
    ema_real command_mm; /* of the present model step, for all of them */
    ema_output_t row_output[1U + EMA_IDENTIFIED_MAX];
    ema_step_scratch_t work; /* one for all of them */
    ema_state_t state[1U + EMA_IDENTIFIED_MAX];
    ema_plant_t plant[1U + EMA_IDENTIFIED_MAX]; /* of each run, and its state */
} ema_sensitivity_t;

typedef struct {
    ema_real std[EMA_IDENTIFIED_MAX];  /* in the parameters' units */
    ema_real bias[EMA_IDENTIFIED_MAX]; /* how far the estimates may be off for what the residual shares over many rows;
                                          0 where it is white */
    ema_real residual_rms_mm;
    ema_real residual_correlation;
    ema_real outside_ratio; /* of the run at the estimate: how far a learned table was used outside its range */
    bool determined;        /* false: the record does not tell the parameters apart, std and bias are not set */
    bool crossed; /* the play was passed: the rod was pushed both ways. Before that its place in the play, which nobody
                     knows, stands for the play */
} ema_sensitivity_result_t;

/* Prepares the runs of `actuator` (at the estimate) with `count` values `ids` moved by `delta`, against `record`. Each
 * value is moved in `actuator` itself and put back. Errors: EMA_ERR_NULL; EMA_ERR_SHORT for an empty record;
 * EMA_ERR_RANGE for a count beyond EMA_IDENTIFIED_MAX, an unknown id or one of a learned table, a negative weight or
 * one on a channel that is not recorded; nothing changed. Those of ema_model_init, also for a moved value outside its
 * range; `self` is then not to be used. */
ema_status_t ema_sensitivity_start(ema_sensitivity_t* self, ema_actuator_t* actuator, const ema_record_t* record,
                                   const ema_real weight[EMA_CHANNEL_COUNT], const ema_value_id_t* ids,
                                   const ema_real* delta, uint32_t count, ema_real start_mm);

/* From now on all runs read their learned tables from `actuator`: see ema_model_learned. Cost: constant. */
void ema_sensitivity_learned(ema_sensitivity_t* self, const ema_actuator_t* actuator);

/* Runs for `steps` plain steps of work over all runs together (ema_objective_run); returns how many model steps it
 * made, 0 once it is done. */
uint32_t ema_sensitivity_run(ema_sensitivity_t* self, uint32_t steps);

bool ema_sensitivity_done(const ema_sensitivity_t* self);

/* Standard errors and residual, after the runs are done. Cost: one Cholesky solution of `count` unknowns. */
void ema_sensitivity_result(const ema_sensitivity_t* self, ema_sensitivity_result_t* result);

#ifdef __cplusplus
}
#endif

#endif
