/* Torque constant and back-EMF that vary with the angle: break-away, and the work of a turn. */
#include "effects/ema_effect_sites.h"
#include "ema_open_loop.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void test_breaks_away_at_the_current_of_the_local_constant(void)
{
    ema_actuator_t actuator = ema_open_loop();
    actuator.effects.torque_ripple.ratio = EMA_R(0.1);
    EMA_ASSERT_CLOSE(0.138 / 1.1, ema_open_loop_break_away_Nm(&actuator, 0.0), 0.0, 1.0e-3);
    actuator.effects.torque_ripple.phase_rad = EMA_R(3.141592653589793);
    EMA_ASSERT_CLOSE(0.138 / 0.9, ema_open_loop_break_away_Nm(&actuator, 0.0), 0.0, 1.0e-3);
}

static void test_sums_to_nothing_over_a_turn(void)
{
    const ema_effect_torque_ripple_t effect = {EMA_R(0.05), EMA_R(6.0), EMA_R(0.4)};
    double sum = 0.0;
    for (uint32_t k = 0; k < 36U; ++k) {
        const ema_site_t site = {.angle_rad = EMA_R(6.283185307179586) * ((ema_real)k / EMA_R(36.0))};
        sum += (double)ema_effect_torque_ripple(&effect, &site);
    }
    EMA_ASSERT_CLOSE(0.0, sum, 64.0 * EMA_EPS, 0.0);
}

static void test_torque_limit_holds_with_the_ripple(void)
{
    ema_actuator_t actuator = ema_open_loop();
    actuator.params.torque_limit_Nm = EMA_R(0.1);
    actuator.effects.torque_ripple.ratio = EMA_R(0.5);
    const ema_model_t model = ema_open_loop_steady(&actuator, 1.0);
    TEST_ASSERT_TRUE(model.state.motion == 0);
    TEST_ASSERT_TRUE(model.state.angle_rad == EMA_R(0.0));
}

/* A drive that controls the current sees no back-EMF: the ripple changes the torque, and the current stays. */
static void test_current_loop_keeps_its_current_under_the_ripple(void)
{
    const double ratio[2] = {0.1, 0.4};
    for (uint32_t k = 0; k < 2U; ++k) {
        ema_actuator_t actuator = ema_open_loop();
        actuator.options.mode = 1;
        actuator.params.current_scale_A = EMA_R(5.0);
        actuator.params.current_loop_s = EMA_R(0.0);
        actuator.effects.torque_ripple.ratio = (ema_real)ratio[k];
        actuator.effects.torque_ripple.periods = EMA_R(1.0);
        ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
        (void)ema_rig_hold(&model, EMA_FULL_OUTPUT_MM, 2U);
        EMA_ASSERT_CLOSE(5.0, model.state.current_A, 0.0, EMA_CLOSED_FORM);
        /* two steps of 1 ms at angle zero, nearly: kt (1 + ratio) i - csj over the inertia */
        EMA_ASSERT_CLOSE(2.0e-3 * ((0.0612 * (1.0 + ratio[k]) * 5.0) - 0.138) / 6.0e-5, model.state.speed_rad_s, 0.0,
                         5.0e-3);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_breaks_away_at_the_current_of_the_local_constant);
    RUN_TEST(test_sums_to_nothing_over_a_turn);
    RUN_TEST(test_torque_limit_holds_with_the_ripple);
    RUN_TEST(test_current_loop_keeps_its_current_under_the_ripple);
    return UNITY_END();
}
