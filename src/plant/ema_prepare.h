/* From an actuator to the blocks of its plant. */
#ifndef EMA_PREPARE_H
#define EMA_PREPARE_H

#include "ema/ema_plant.h"

/* Prepares everything but the responses of the circuits: ema_circuit_prepare. Errors, the plant unchanged: EMA_ERR_RANGE, EMA_ERR_INERTIA, EMA_ERR_STIFF. */
ema_status_t ema_plant_prepare(ema_plant_t* plant, const ema_actuator_t* actuator, ema_real start_mm);

#endif
