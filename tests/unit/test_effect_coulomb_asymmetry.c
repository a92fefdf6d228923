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
    EMA_ASSERT_CLOSE(ema_steady_speed_rad_s(9.6, 0.0612, 0.99, 0.138 * 1.25, 1.0e-4), forward.state.speed_rad_s, 0.0,
                     EMA_CLOSED_FORM);
    EMA_ASSERT_CLOSE(-ema_steady_speed_rad_s(9.6, 0.0612, 0.99, 0.138 * 0.75, 1.0e-4), backward.state.speed_rad_s, 0.0,
                     EMA_CLOSED_FORM);
}

static void test_friction_that_would_drive_the_shaft_is_refused(void)
{
    ema_actuator_t actuator = ema_open_loop();
    ema_model_t model;
    actuator.params.friction_asymmetry = EMA_R(-0.9);
    actuator.effects.coulomb_asymmetry.asymmetry = EMA_R(-0.2);
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_model_init(&model, &actuator, EMA_R(0.0)));
    actuator.effects.coulomb_asymmetry.asymmetry = EMA_R(-0.05);
    EMA_ASSERT_STATUS(EMA_OK, ema_model_init(&model, &actuator, EMA_R(0.0)));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_friction_is_larger_forward_and_smaller_backward);
    RUN_TEST(test_friction_that_would_drive_the_shaft_is_refused);
    return UNITY_END();
}
