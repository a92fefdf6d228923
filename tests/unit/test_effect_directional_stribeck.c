/* Break-away friction of another size in each direction: where it breaks away, and what is left of it while it slides.
 */
#include <math.h>

#include "effects/ema_effect_sites.h"
#include "ema_close.h"
#include "ema_open_loop.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void test_breaks_away_at_the_level_of_its_direction(void)
{
    ema_actuator_t actuator = ema_open_loop();
    actuator.effects.directional_stribeck.rise = EMA_R(0.5);
    actuator.effects.directional_stribeck.asymmetry = EMA_R(0.6);
    EMA_ASSERT_CLOSE(0.138 * (1.0 + (0.5 * 1.6)), ema_open_loop_break_away_Nm(&actuator, 0.0), 0.0, 1.0e-3);
    actuator.effects.directional_stribeck.asymmetry = EMA_R(-0.6);
    EMA_ASSERT_CLOSE(0.138 * (1.0 + (0.5 * 0.4)), ema_open_loop_break_away_Nm(&actuator, 0.0), 0.0, 1.0e-3);
}

static void test_one_direction_alone_can_have_it(void)
{
    const ema_effect_directional_stribeck_t effect = {EMA_R(0.25), EMA_R(1.0), EMA_R(10.0), EMA_R(1.0)};
    const ema_site_t forward = {.speed_rad_s = EMA_R(10.0), .direction = EMA_R(1.0)};
    const ema_site_t backward = {.speed_rad_s = EMA_R(-10.0), .direction = EMA_R(-1.0)};
    EMA_ASSERT_CLOSE(0.2 * 0.5 * exp(-1.0), ema_effect_directional_stribeck(&effect, &forward, EMA_R(0.2)), 0.0, 1e-6);
    EMA_ASSERT_CLOSE(0.0, ema_effect_directional_stribeck(&effect, &backward, EMA_R(0.2)), 0.0, 1e-12);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_breaks_away_at_the_level_of_its_direction);
    RUN_TEST(test_one_direction_alone_can_have_it);
    return UNITY_END();
}
