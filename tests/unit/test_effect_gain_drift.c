/* The position gain has drifted: the first output after a step, in both structures of the control law. */
#include "ema_open_loop.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void test_first_output_has_the_drifted_gain(void)
{
    ema_actuator_t actuator = ema_rig_actuator();
    actuator.effects.gain_drift.drift = EMA_R(0.25);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    EMA_ASSERT_CLOSE(24.0 * 400.0 * 1.25 * 0.5e-3, ema_rig_step(&model, EMA_R(0.5)).voltage_V, 0.0, 8.0 * EMA_EPS);
}

static void test_cascade_has_it_too(void)
{
    ema_actuator_t actuator = ema_rig_actuator();
    actuator.options.structure = 1;
    actuator.params.position_gain_per_s = EMA_R(30.0);
    actuator.params.speed_gain_s_per_m = EMA_R(10.0);
    actuator.effects.gain_drift.drift = EMA_R(-0.5);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    EMA_ASSERT_CLOSE(24.0 * 10.0 * 15.0 * 0.5e-3, ema_rig_step(&model, EMA_R(0.5)).voltage_V, 0.0, 8.0 * EMA_EPS);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_first_output_has_the_drifted_gain);
    RUN_TEST(test_cascade_has_it_too);
    return UNITY_END();
}
