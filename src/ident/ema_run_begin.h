/* Starts of model runs for callers that divide or repeat them: sensitivities one model at a time, and a run with a
 * table that has been checked, for an actuator that is no longer the exported one. */
#ifndef EMA_RUN_BEGIN_H
#define EMA_RUN_BEGIN_H

#include "ema/detail/ema_onboard.h"
#include "ema/detail/ema_sensitivity.h"

/* Everything but the models. Errors, nothing changed: EMA_ERR_SHORT; EMA_ERR_RANGE of count and weights. */
ema_status_t ema_sensitivity_begin(ema_sensitivity_t* self, const ema_actuator_t* actuator, const ema_record_t* record,
                                   const ema_real weight[EMA_CHANNEL_COUNT], uint32_t count);

/* The next model: first the one at the estimate. Errors: those of ema_model_init. */
ema_status_t ema_sensitivity_model(ema_sensitivity_t* self, const ema_actuator_t* actuator, ema_real start_mm);

/* The next model, with one value moved; in `actuator` it is put back. */
ema_status_t ema_sensitivity_moved(ema_sensitivity_t* self, ema_actuator_t* actuator, ema_value_id_t id, ema_real delta,
                                   ema_real start_mm);

/* After runs that were not given up: writes the step of the damped least squares, (J'J + damping diag J'J) s = J'r, in
 * the parameters' own units, zero for those of `held`, a set of bits. Returns by how much the linear model lets the
 * weighted squares fall; negative, `step` unchanged, where the record does not tell the parameters apart. Source:
 * Marquardt, J. SIAM 11, 1963. */
ema_real ema_sensitivity_step(const ema_sensitivity_t* self, ema_real damping, uint32_t held, ema_real* step);

/* As ema_onboard_start, after ema_onboard_check of the exported actuator with this table and record; `actuator` may
 * differ from that in what differs from day to day, besides CSJ and BLK. Errors: those of ema_model_init. */
ema_status_t ema_onboard_begin(ema_onboard_t* self, const ema_signatures_t* table, const ema_actuator_t* actuator,
                               const ema_record_t* record, ema_real start_mm);

#endif
