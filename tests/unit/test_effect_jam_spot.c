/* A spot with more dry friction: break-away on it, at its flank, and far from it. */
#include <math.h>

#include "ema_open_loop.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void test_breaks_away_later_on_the_spot(void)
{
    ema_actuator_t actuator = ema_open_loop();
    actuator.effects.jam_spot.amplitude_Nm = EMA_R(0.2);
    actuator.effects.jam_spot.place_mm = EMA_R(2.0);
    actuator.effects.jam_spot.width_mm = EMA_R(0.5);
    EMA_ASSERT_CLOSE(0.338, ema_open_loop_break_away_Nm(&actuator, 2.0), 0.0, 1.0e-3);
    EMA_ASSERT_CLOSE(0.138 + (0.2 * exp(-1.0)), ema_open_loop_break_away_Nm(&actuator, 1.5), 0.0, 1.0e-3);
    EMA_ASSERT_CLOSE(0.138 + (0.2 * exp(-1.0)), ema_open_loop_break_away_Nm(&actuator, 2.5), 0.0, 1.0e-3);
    EMA_ASSERT_CLOSE(0.138, ema_open_loop_break_away_Nm(&actuator, -2.0), 0.0, 1.0e-3);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_breaks_away_later_on_the_spot);
    return UNITY_END();
}
