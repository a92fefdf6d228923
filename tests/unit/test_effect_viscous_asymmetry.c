/* Damping that differs between the directions: steady speeds. */
#include "ema_open_loop.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void test_damping_is_larger_forward_and_smaller_backward(void)
{
    ema_actuator_t actuator = ema_open_loop();
    actuator.params.viscous_Nm_s_per_rad = EMA_R(1.0e-3);
    actuator.effects.viscous_asymmetry.asymmetry = EMA_R(0.5);
    const ema_model_t forward = ema_open_loop_steady(&actuator, 0.4);
    const ema_model_t backward = ema_open_loop_steady(&actuator, -0.4);
    EMA_ASSERT_CLOSE(ema_steady_speed_rad_s(9.6, 0.0612, 0.99, 0.138, 1.5e-3), forward.state.speed_rad_s, 0.0,
                     EMA_CLOSED_FORM);
    EMA_ASSERT_CLOSE(-ema_steady_speed_rad_s(9.6, 0.0612, 0.99, 0.138, 0.5e-3), backward.state.speed_rad_s, 0.0,
                     EMA_CLOSED_FORM);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_damping_is_larger_forward_and_smaller_backward);
    return UNITY_END();
}
