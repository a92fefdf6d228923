#include "blocks/ema_motor.h"

#include "blocks/ema_limits.h"

void ema_motor_prepare(ema_motor_t* motor, const ema_params_t* params)
{
    motor->torque_constant_Nm_per_A = params->torque_constant_Nm_per_A;
    motor->back_emf_V_s_per_rad = params->back_emf_V_s_per_rad;
    motor->resistance_ohm = params->resistance_ohm;
    motor->inductance_H = params->inductance_H;
    motor->torque_limit_Nm = ema_limit_or_none(params->torque_limit_Nm);
}
