/* Drag with the square root of speed: what it takes of the steady torque. */
#include <math.h>

#include "ema_open_loop.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void test_steady_torque_holds_the_drag(void)
{
    ema_actuator_t actuator = ema_open_loop();
    actuator.effects.concave_viscous.drag_Nm_per_sqrt_rad_s = EMA_R(0.01);
    const ema_model_t forward = ema_open_loop_steady(&actuator, 0.4);
    const ema_model_t backward = ema_open_loop_steady(&actuator, -0.4);
    const double speed_rad_s = (double)forward.state.speed_rad_s;
    const double free_rad_s = ema_steady_speed_rad_s(9.6, 0.0612, 0.99, 0.138, 1.0e-4);
    const double drag_Nm = (1.0e-4 + (0.0612 * 0.0612 / 0.99)) * (free_rad_s - speed_rad_s);
    EMA_ASSERT_CLOSE(0.01 * sqrt(speed_rad_s), drag_Nm, 0.0, EMA_BY_PRECISION(2.0e-4, 1.0e-8));
    EMA_ASSERT_CLOSE(-speed_rad_s, backward.state.speed_rad_s, 0.0, EMA_CLOSED_FORM);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_steady_torque_holds_the_drag);
    return UNITY_END();
}
