/* How far a simulated run is from a record: the integral of the squared error, computed while the model runs.
 *
 * E = sum over channels of weight * integral of (measured - simulated)^2 dt. With the rod position alone at weight 1
 * this is E_int in mm^2 s, the objective of Dalla Vedova et al. Nothing of the simulated run is stored, and the work
 * comes in slices of work; the result does not depend on how it was sliced. E only grows, so a run is given up
 * once it exceeds a limit.
 */
#ifndef EMA_OBJECTIVE_H
#define EMA_OBJECTIVE_H

#include "ema/ema_model.h"
#include "ema/ema_record.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    EMA_OBJECTIVE_DONE = 0, /* the value is E */
    EMA_OBJECTIVE_RUNNING = 1,
    EMA_OBJECTIVE_EXCEEDED = 2, /* E is above the limit; the value is what had come together */
    EMA_OBJECTIVE_DIVERGED = 3  /* the model left the finite numbers; the value is the largest finite number */
} ema_objective_state_t;

typedef struct {
    ema_objective_state_t state;
    ema_cursor_t cursor;
    ema_real weight[EMA_CHANNEL_COUNT]; /* of the channels in use */
    uint8_t channel[EMA_CHANNEL_COUNT]; /* which these are */
    uint32_t channels;
    ema_real period_s;
    ema_real limit;
    ema_real sum;
    ema_real sum_low;
    ema_model_t model;
} ema_objective_t;

/* Largest finite cost: what a run that leaves the finite numbers is worth. */
#define EMA_COST_MAX EMA_R(1.0e30)

/* Starts a run of `actuator` against `record`, which must outlive it, from rest at `start_mm`. `weight` by
 * ema_channel_t: 1 for the rod position gives mm^2 s; a channel that is not recorded must have weight 0. A run above
 * `limit` is given up. Errors: those of ema_model_init; EMA_ERR_SHORT for an empty record; EMA_ERR_RANGE for a negative
 * weight or one on a channel that is not recorded. */
ema_status_t ema_objective_start(ema_objective_t* objective, const ema_actuator_t* actuator, const ema_record_t* record,
                                 const ema_real weight[EMA_CHANNEL_COUNT], ema_real start_mm, ema_real limit);

/* Runs for `steps` plain steps of work: so many model steps where nothing happens and no effect acts, fewer otherwise
 * (ema_step_scratch.h), and never less than one. Cost: that work, and the rest of the step that reaches it: at most
 * EMA_STEP_WORK_MAX. Returns the state; further calls after the end do
 * nothing. */
ema_objective_state_t ema_objective_run(ema_objective_t* objective, uint32_t steps);

/* The value so far. */
ema_real ema_objective_value(const ema_objective_t* objective);

#ifdef __cplusplus
}
#endif

#endif
