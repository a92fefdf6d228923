#include "ema_open_loop.h"

ema_actuator_t ema_open_loop(void)
{
    ema_actuator_t actuator = ema_rig_actuator();
    actuator.params.kp_per_m = EMA_R(1.0e-8);
    actuator.params.ki_per_m_s = EMA_R(0.0);
    actuator.params.travel_mm = EMA_R(1.0e3);
    return actuator;
}

ema_actuator_t ema_open_loop_locked(void)
{
    ema_actuator_t actuator = ema_open_loop();
    actuator.params.csj_Nm = EMA_R(100.0);
    return actuator;
}

ema_model_t ema_open_loop_steady(const ema_actuator_t* actuator, double share)
{
    ema_model_t model = ema_rig_model(actuator, EMA_R(0.0));
    (void)ema_rig_hold(&model, (ema_real)share * EMA_FULL_OUTPUT_MM, 500U);
    return model;
}

double ema_steady_speed_rad_s(double voltage_V, double torque_constant_Nm_per_A, double resistance_ohm,
                              double friction_Nm, double viscous_Nm_s_per_rad)
{
    const double damping =
        viscous_Nm_s_per_rad + ((torque_constant_Nm_per_A * torque_constant_Nm_per_A) / resistance_ohm);
    return (((torque_constant_Nm_per_A * voltage_V) / resistance_ohm) - friction_Nm) / damping;
}

double ema_open_loop_break_away_Nm(const ema_actuator_t* actuator, double start_mm)
{
    ema_model_t model = ema_rig_model(actuator, (ema_real)start_mm);
    const int32_t rest = model.state.motion;
    double current_A = 0.0;
    for (uint32_t k = 0; (k < 20000U) && (model.state.motion == rest); ++k) {
        current_A = (double)ema_rig_step(&model, EMA_R(5.0e-5) * (ema_real)k * EMA_FULL_OUTPUT_MM).current_A;
    }
    TEST_ASSERT_TRUE(model.state.motion != rest);
    return current_A * (double)actuator->params.torque_constant_Nm_per_A;
}
