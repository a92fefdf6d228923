/* Dry friction that grows with the motor torque: where it slides steadily, and where it breaks away. */
#include "ema_open_loop.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void test_steady_speed_is_that_of_a_motor_with_less_torque(void)
{
    ema_actuator_t actuator = ema_open_loop();
    actuator.effects.load_dependent_friction.ratio = EMA_R(0.2);
    const ema_model_t model = ema_open_loop_steady(&actuator, -0.4);
    const double left = 0.8 * 0.0612;
    EMA_ASSERT_CLOSE(-((left * 9.6 / 0.99) - 0.138) / (1.0e-4 + (left * 0.0612 / 0.99)), model.state.speed_rad_s, 0.0,
                     EMA_CLOSED_FORM);
}

static void test_breaks_away_when_the_share_that_is_left_reaches_the_level(void)
{
    ema_actuator_t actuator = ema_open_loop();
    actuator.effects.load_dependent_friction.ratio = EMA_R(0.2);
    EMA_ASSERT_CLOSE(0.138 / 0.8, ema_open_loop_break_away_Nm(&actuator, 0.0), 0.0, 1.0e-3);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_steady_speed_is_that_of_a_motor_with_less_torque);
    RUN_TEST(test_breaks_away_when_the_share_that_is_left_reaches_the_level);
    return UNITY_END();
}
