/* Friction that grows with the motor torque and falls with speed: where it breaks away, and what is left at speed. */
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

static void test_breaks_away_when_the_share_that_is_left_reaches_the_level(void)
{
    ema_actuator_t actuator = ema_open_loop();
    actuator.effects.load_dependent_stribeck.ratio = EMA_R(0.2);
    EMA_ASSERT_CLOSE(0.138 / 0.8, ema_open_loop_break_away_Nm(&actuator, 0.0), 0.0, 1.0e-3);
}

static void test_falls_with_speed_and_grows_with_either_sign_of_torque(void)
{
    const ema_effect_load_dependent_stribeck_t effect = {EMA_R(0.1), EMA_R(20.0), EMA_R(2.0)};
    ema_plant_t plant = {.motor = {.torque_constant_Nm_per_A = EMA_R(0.05)}};
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        const ema_site_t site = {
            .plant = &plant, .speed_rad_s = EMA_R(-10.0), .current_A = (ema_real)sign * EMA_R(4.0)};
        const ema_site_t fast = {
            .plant = &plant, .speed_rad_s = EMA_R(400.0), .current_A = (ema_real)sign * EMA_R(4.0)};
        EMA_ASSERT_CLOSE(0.1 * 0.2 * exp(-0.25), ema_effect_load_dependent_stribeck(&effect, &site, EMA_R(9.0)), 0.0,
                         1e-6);
        EMA_ASSERT_CLOSE(0.0, ema_effect_load_dependent_stribeck(&effect, &fast, EMA_R(9.0)), 0.0, 1e-12);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_breaks_away_when_the_share_that_is_left_reaches_the_level);
    RUN_TEST(test_falls_with_speed_and_grows_with_either_sign_of_torque);
    return UNITY_END();
}
