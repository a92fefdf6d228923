/* Block 3: motor. Equations: docs/DESIGN.md, "Motor". */
#ifndef EMA_MOTOR_H
#define EMA_MOTOR_H

#include "base/ema_math.h"
#include "ema/detail/ema_plant.h"

void ema_motor_prepare(ema_motor_t* motor, const ema_params_t* params);

/* Torque on the shaft, saturated by the induction flux. */
static inline ema_real ema_motor_torque(const ema_motor_t* motor, ema_real current_A)
{
    /* the call of a function would take longer than this */
    const ema_real torque_Nm = motor->torque_constant_Nm_per_A * current_A;
    return ema_min(ema_max(torque_Nm, -motor->torque_limit_Nm), motor->torque_limit_Nm);
}

#endif
