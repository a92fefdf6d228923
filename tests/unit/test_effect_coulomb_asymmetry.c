/* Dry friction that differs between the directions: steady speeds. */
#include "ema_open_loop.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void test_friction_is_larger_forward_and_smaller_backward(void)
{
    ema_actuator_t actuator = ema_open_loop();
    actuator.effects.coulomb_asymmetry.asymmetry = EMA_R(0.25);
    const ema_model_t forward = ema_open_loop_steady(&actuator, 0.4);
    const ema_model_t backward = ema_open_loop_steady(&actuator, -0.4);
    EMA_ASSERT_CLOSE(ema_steady_speed_rad_s(9.6, 0.0612, 0.99, 0.138 * 1.25, 1.0e-4), forward.state.speed_rad_s, 0.0, EMA_CLOSED_FORM);
    EMA_ASSERT_CLOSE(-ema_steady_speed_rad_s(9.6, 0.0612, 0.99, 0.138 * 0.75, 1.0e-4), backward.state.speed_rad_s, 0.0, EMA_CLOSED_FORM);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_friction_is_larger_forward_and_smaller_backward);
    return UNITY_END();
}
