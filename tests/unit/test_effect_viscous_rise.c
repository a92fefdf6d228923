/* Cold grease: steady speed with the larger damping. */
#include "ema_open_loop.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void test_damping_grows_by_its_rise(void)
{
    ema_actuator_t actuator = ema_open_loop();
    actuator.effects.viscous_rise.rise = EMA_R(9.0);
    const ema_model_t forward = ema_open_loop_steady(&actuator, 0.4);
    const ema_model_t backward = ema_open_loop_steady(&actuator, -0.4);
    EMA_ASSERT_CLOSE(ema_steady_speed_rad_s(9.6, 0.0612, 0.99, 0.138, 1.0e-3), forward.state.speed_rad_s, 0.0,
                     EMA_CLOSED_FORM);
    EMA_ASSERT_CLOSE(-ema_steady_speed_rad_s(9.6, 0.0612, 0.99, 0.138, 1.0e-3), backward.state.speed_rad_s, 0.0,
                     EMA_CLOSED_FORM);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_damping_grows_by_its_rise);
    return UNITY_END();
}
