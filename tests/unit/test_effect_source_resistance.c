/* A supply with inner resistance: current of a locked rotor. */
#include "ema_open_loop.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void test_locked_current_sees_the_share_of_the_source(void)
{
    ema_actuator_t actuator = ema_open_loop_locked();
    actuator.effects.source_resistance.resistance_ohm = EMA_R(0.3);
    const ema_model_t half = ema_open_loop_steady(&actuator, -0.5);
    const ema_model_t full = ema_open_loop_steady(&actuator, 1.0);
    EMA_ASSERT_CLOSE(-12.0 / (0.99 + 0.15), half.state.current_A, 0.0, EMA_CLOSED_FORM);
    EMA_ASSERT_CLOSE(24.0 / (0.99 + 0.3), full.state.current_A, 0.0, EMA_CLOSED_FORM);
}

static void test_saturated_current_mode_sees_the_bus_and_not_the_recorded_command(void)
{
    ema_actuator_t actuator = ema_open_loop_locked();
    actuator.options.mode = 1;
    actuator.params.current_scale_A = EMA_R(100.0);
    actuator.params.current_loop_s = EMA_R(1.0e-3);
    actuator.params.command_scale_V = EMA_R(5.0);
    actuator.effects.source_resistance.resistance_ohm = EMA_R(0.3);
    const ema_model_t model = ema_open_loop_steady(&actuator, 1.0);
    EMA_ASSERT_CLOSE(24.0 / (0.99 + 0.3), model.state.current_A, 0.0, EMA_CLOSED_FORM);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_locked_current_sees_the_share_of_the_source);
    RUN_TEST(test_saturated_current_mode_sees_the_bus_and_not_the_recorded_command);
    return UNITY_END();
}
