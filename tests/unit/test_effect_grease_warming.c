/* Grease that softens: break-away at the start, steady speed later, when dry and viscous friction have fallen. */
#include <math.h>

#include "ema_open_loop.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void test_both_frictions_have_fallen_as_far_as_the_time_says(void)
{
    ema_actuator_t actuator = ema_open_loop();
    actuator.effects.grease_warming.fall = EMA_R(0.5);
    actuator.effects.grease_warming.time_s = EMA_R(0.3);
    const double left = 1.0 - (0.5 * (1.0 - exp(-0.5 / 0.3)));
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        const ema_model_t model = ema_open_loop_steady(&actuator, 0.4 * (double)sign);
        /* the speed follows the friction by 25 ms, J (D + kt ke / R), in which that falls by 1.5 % of its fall */
        EMA_ASSERT_CLOSE((double)sign * ema_steady_speed_rad_s(9.6, 0.0612, 0.99, 0.138 * left, 1.0e-4 * left),
                         model.state.speed_rad_s, 0.0, 3.0e-3);
    }
}

static void test_a_slow_grease_leaves_the_start_as_it_is(void)
{
    ema_actuator_t actuator = ema_open_loop();
    actuator.effects.grease_warming.fall = EMA_R(0.5);
    actuator.effects.grease_warming.time_s = EMA_R(1000.0);
    EMA_ASSERT_CLOSE(0.138, ema_open_loop_break_away_Nm(&actuator, 0.0), 0.0, 2.0e-3);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_both_frictions_have_fallen_as_far_as_the_time_says);
    RUN_TEST(test_a_slow_grease_leaves_the_start_as_it_is);
    return UNITY_END();
}
