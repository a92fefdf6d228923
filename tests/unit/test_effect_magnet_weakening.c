/* Magnets that lost flux: steady speed with both constants lower. */
#include "ema_open_loop.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void test_torque_and_back_emf_fall_together(void)
{
    ema_actuator_t actuator = ema_open_loop();
    actuator.effects.magnet_weakening.loss = EMA_R(0.1);
    const ema_model_t forward = ema_open_loop_steady(&actuator, 0.4);
    const ema_model_t backward = ema_open_loop_steady(&actuator, -0.4);
    EMA_ASSERT_CLOSE(ema_steady_speed_rad_s(9.6, 0.0612 * 0.9, 0.99, 0.138, 1.0e-4), forward.state.speed_rad_s, 0.0,
                     EMA_CLOSED_FORM);
    EMA_ASSERT_CLOSE(-ema_steady_speed_rad_s(9.6, 0.0612 * 0.9, 0.99, 0.138, 1.0e-4), backward.state.speed_rad_s, 0.0,
                     EMA_CLOSED_FORM);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_torque_and_back_emf_fall_together);
    return UNITY_END();
}
