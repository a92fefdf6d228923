/* The start of the sensitivities one model at a time, for slices that are shorter than all of them take. */
#ifndef EMA_SENSITIVITY_BEGIN_H
#define EMA_SENSITIVITY_BEGIN_H

#include "ema/detail/ema_sensitivity.h"

/* Everything but the models. Errors, nothing changed: EMA_ERR_SHORT; EMA_ERR_RANGE of count and weights. */
ema_status_t ema_sensitivity_begin(ema_sensitivity_t* self, const ema_actuator_t* actuator, const ema_record_t* record,
                                   const ema_real weight[EMA_CHANNEL_COUNT], uint32_t count);

/* The next model: first the one at the estimate. Errors: those of ema_model_init. */
ema_status_t ema_sensitivity_model(ema_sensitivity_t* self, const ema_actuator_t* actuator, ema_real start_mm);

/* The next model, with one value moved; in `actuator` it is put back. */
ema_status_t ema_sensitivity_moved(ema_sensitivity_t* self, ema_actuator_t* actuator, ema_value_id_t id, ema_real delta,
                                   ema_real start_mm);

#endif
