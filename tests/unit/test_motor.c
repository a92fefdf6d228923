/* Motor: torque and its saturation; the current of a locked rotor against 1 - exp(-R t / L). */
#include <math.h>

#include "blocks/ema_mechanics.h"
#include "ema_rig.h"

static ema_actuator_t actuator;

void setUp(void)
{
    actuator = ema_rig_actuator();
}

void tearDown(void)
{
}

static double torque(double current_A)
{
    ema_motor_t motor;
    ema_motor_prepare(&motor, &actuator.params);
    return (double)ema_motor_torque(&motor, (ema_real)current_A);
}

static void test_torque_is_constant_times_current(void)
{
    actuator.params.torque_constant_Nm_per_A = EMA_R(0.0625);
    EMA_ASSERT_CLOSE(0.5, torque(8.0), 0.0, 2.0 * EMA_EPS);
    EMA_ASSERT_CLOSE(-0.5, torque(-8.0), 0.0, 2.0 * EMA_EPS);
}

static void test_torque_saturates_at_its_limit(void)
{
    actuator.params.torque_limit_Nm = EMA_R(0.5);
    TEST_ASSERT_TRUE(torque(100.0) == 0.5);
    TEST_ASSERT_TRUE(torque(-100.0) == -0.5);
    EMA_ASSERT_CLOSE(0.0612 * 8.0, torque(8.0), 0.0, 4.0 * EMA_EPS);
}

static void test_torque_limit_of_zero_is_none(void)
{
    actuator.params.torque_limit_Nm = EMA_R(0.0);
    EMA_ASSERT_CLOSE(0.0612 * 5000.0, torque(5000.0), 0.0, 4.0 * EMA_EPS);
}

static void test_current_of_a_locked_rotor_rises_exponentially(void)
{
    actuator.params.csj_Nm = EMA_R(100.0);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    const double final_A = 24.0 / 0.99;
    const double rate_per_s = 0.99 / 8.0e-4;
    for (uint32_t k = 0; k < 20U; ++k) {
        const ema_output_t row = ema_rig_step(&model, EMA_R(20.0));
        EMA_ASSERT_CLOSE(final_A * -expm1(-rate_per_s * 1.0e-3 * k), row.current_A, EMA_BY_PRECISION(1.0e-5, 1.0e-12),
                         0.0);
        EMA_ASSERT_CLOSE(24.0, row.voltage_V, 0.0, 0.0);
        TEST_ASSERT_TRUE(row.motor_position_mm == EMA_R(0.0));
    }
}

static void test_current_without_inductance_follows_at_once(void)
{
    actuator.params.csj_Nm = EMA_R(100.0);
    actuator.params.inductance_H = EMA_R(0.0);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    EMA_ASSERT_CLOSE(24.0 / 0.99, ema_rig_step(&model, EMA_R(20.0)).current_A, 0.0, 4.0 * EMA_EPS);
    EMA_ASSERT_CLOSE(-24.0 / 0.99, ema_rig_step(&model, EMA_R(-20.0)).current_A, 0.0, 4.0 * EMA_EPS);
}

static void test_current_loop_of_a_locked_rotor_has_its_time_constant(void)
{
    actuator.options.mode = 1;
    actuator.params.csj_Nm = EMA_R(100.0);
    actuator.params.current_scale_A = EMA_R(4.0);
    actuator.params.current_loop_s = EMA_R(2.0e-3);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    for (uint32_t k = 0; k < 20U; ++k) {
        const ema_output_t row = ema_rig_step(&model, EMA_R(20.0));
        EMA_ASSERT_CLOSE(4.0 * -expm1(-0.5 * k), row.current_A, EMA_BY_PRECISION(2.0e-6, 1.0e-13), 0.0);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_torque_is_constant_times_current);
    RUN_TEST(test_torque_saturates_at_its_limit);
    RUN_TEST(test_torque_limit_of_zero_is_none);
    RUN_TEST(test_current_of_a_locked_rotor_rises_exponentially);
    RUN_TEST(test_current_without_inductance_follows_at_once);
    RUN_TEST(test_current_loop_of_a_locked_rotor_has_its_time_constant);
    return UNITY_END();
}
