/* Contact that stretches before it slides: closed form of a turn, and of a slow pull below the level. */
#include <math.h>

#include "effects/ema_effect_sites.h"
#include "ema_open_loop.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void test_turns_in_one_direction_add_up(void)
{
    const ema_effect_presliding_t effect = {EMA_R(0.05)};
    const ema_real half = ema_effect_presliding(&effect, EMA_R(0.01), EMA_R(-0.4), EMA_R(0.8));
    const ema_real there = ema_effect_presliding(&effect, EMA_R(0.03), half, EMA_R(0.8));
    EMA_ASSERT_CLOSE(1.0 - (1.4 * exp(-0.04 / 0.05)), there, 8.0 * EMA_EPS, 0.0);
    EMA_ASSERT_CLOSE(there, ema_effect_presliding(&effect, EMA_R(0.04), EMA_R(-0.4), EMA_R(0.8)), 8.0 * EMA_EPS, 0.0);
}

static void test_contact_slides_after_a_long_turn_and_turns_round(void)
{
    const ema_effect_presliding_t effect = {EMA_R(0.05)};
    EMA_ASSERT_CLOSE(1.0, ema_effect_presliding(&effect, EMA_R(5.0), EMA_R(-1.0), EMA_R(0.8)), 2.0 * EMA_EPS, 0.0);
    EMA_ASSERT_CLOSE(-1.0, ema_effect_presliding(&effect, EMA_R(-5.0), EMA_R(1.0), EMA_R(0.8)), 2.0 * EMA_EPS, 0.0);
    EMA_ASSERT_CLOSE(0.3, ema_effect_presliding(&effect, EMA_R(0.0), EMA_R(0.3), EMA_R(0.8)), 0.0, 2.0 * EMA_EPS);
}

static void test_slow_pull_below_the_level_stretches_by_its_logarithm(void)
{
    ema_actuator_t actuator = ema_open_loop();
    actuator.params.csj_Nm = EMA_R(1.0);
    actuator.effects.presliding.stretch_rad = EMA_R(0.05);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    for (uint32_t k = 0; k < 4000U; ++k) {
        (void)ema_rig_step(&model, (EMA_R(0.4) / EMA_R(4000.0)) * (ema_real)k * EMA_FULL_OUTPUT_MM);
    }
    const double torque_Nm = (double)actuator.params.torque_constant_Nm_per_A * (double)model.state.current_A;
    EMA_ASSERT_CLOSE(-0.05 * log1p(-torque_Nm), model.state.angle_rad, 0.0, 2.0e-3);
    TEST_ASSERT_TRUE(model.state.angle_rad > EMA_R(0.02));
}

static void test_end_of_travel_holds_until_the_torque_turns_inward(void)
{
    ema_actuator_t actuator = ema_open_loop();
    actuator.params.travel_mm = EMA_R(0.5);
    actuator.effects.presliding.stretch_rad = EMA_R(0.05);
    ema_model_t model = ema_open_loop_steady(&actuator, 0.3);
    EMA_ASSERT_CLOSE(0.5, model.state.motor_mm, 0.0, 8.0 * EMA_EPS);
    TEST_ASSERT_TRUE(model.state.speed_rad_s == EMA_R(0.0));
    EMA_ASSERT_CLOSE(0.3 * 24.0 / 0.99, model.state.current_A, 0.0, EMA_CLOSED_FORM);
    (void)ema_rig_hold(&model, EMA_R(-0.3) * EMA_FULL_OUTPUT_MM, 20U);
    TEST_ASSERT_TRUE(model.state.speed_rad_s < EMA_R(-1.0));
    TEST_ASSERT_EQUAL_UINT32(0U, model.state.unlocated_event_steps);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_turns_in_one_direction_add_up);
    RUN_TEST(test_contact_slides_after_a_long_turn_and_turns_round);
    RUN_TEST(test_slow_pull_below_the_level_stretches_by_its_logarithm);
    RUN_TEST(test_end_of_travel_holds_until_the_torque_turns_inward);
    return UNITY_END();
}
