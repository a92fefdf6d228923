/* Friction behind a play with elastic ends: closed form of a turn, the flat floor of a reversal, and an end of travel.
 */
#include "base/ema_math.h"
#include "effects/ema_effect_sites.h"
#include "ema_open_loop.h"

/* the module keeps its place in the gap in so much of the friction */
#define EMA_OF_GAP 3.0e-5
#define EMA_LEAD_MM_PER_RAD EMA_R(0.8)

static const ema_effect_elastic_backlash_t effect = {EMA_R(0.5), EMA_R(0.25)};

void setUp(void)
{
}

void tearDown(void)
{
}

static ema_real ema_after(ema_real share, double way_mm)
{
    return ema_effect_elastic_backlash(&effect, (ema_real)(way_mm / 0.8), share, EMA_LEAD_MM_PER_RAD);
}

static void test_turns_in_one_direction_add_up(void)
{
    const ema_real there = ema_after(ema_after(EMA_R(-0.5), 0.3), 0.45);
    /* half the contact back, the gap, and half the other contact */
    EMA_ASSERT_CLOSE(0.5, there, EMA_OF_GAP, 0.0);
    EMA_ASSERT_CLOSE(there, ema_after(EMA_R(-0.5), 0.75), 64.0 * EMA_EPS, 0.0);
}

static void test_a_reversal_finds_a_flat_floor_of_the_gap_and_slides_behind_it(void)
{
    EMA_ASSERT_CLOSE(0.6, ema_after(EMA_R(1.0), -0.1), EMA_OF_GAP, 0.0);
    TEST_ASSERT_TRUE(ema_abs(ema_after(EMA_R(1.0), -0.26)) <= EMA_R(1.0e-5));
    EMA_ASSERT_CLOSE(0.0, ema_after(EMA_R(1.0), -0.5), 0.0, 64.0 * EMA_EPS);
    TEST_ASSERT_TRUE(ema_abs(ema_after(EMA_R(1.0), -0.74)) <= EMA_R(1.0e-5));
    EMA_ASSERT_CLOSE(-1.0, ema_after(EMA_R(1.0), -1.0), 8.0 * EMA_EPS, 0.0);
    TEST_ASSERT_TRUE(ema_after(EMA_R(1.0), -7.0) == EMA_R(-1.0));
    TEST_ASSERT_TRUE(ema_after(EMA_R(-1.0), 7.0) == EMA_R(1.0));
}

static void test_a_torque_far_below_the_friction_moves_the_shaft_through_the_gap(void)
{
    ema_actuator_t actuator = ema_open_loop();
    actuator.params.csj_Nm = EMA_R(1.0);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    (void)ema_rig_hold(&model, EMA_R(0.1) * EMA_FULL_OUTPUT_MM, 2000U);
    EMA_ASSERT_CLOSE(0.0, model.state.angle_rad, 0.0, EMA_EPS);
    actuator.effects.elastic_backlash = effect;
    model = ema_rig_model(&actuator, EMA_R(0.0));
    (void)ema_rig_hold(&model, EMA_R(0.1) * EMA_FULL_OUTPUT_MM, 2000U);
    /* where the contact carries it */
    const double torque_Nm = (double)actuator.params.torque_constant_Nm_per_A * (double)model.state.current_A;
    EMA_ASSERT_CLOSE(0.25 + (0.25 * torque_Nm), model.state.motor_mm, 5.0e-3, 0.0);
    TEST_ASSERT_EQUAL_UINT32(0U, model.state.unlocated_event_steps);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_turns_in_one_direction_add_up);
    RUN_TEST(test_a_reversal_finds_a_flat_floor_of_the_gap_and_slides_behind_it);
    RUN_TEST(test_a_torque_far_below_the_friction_moves_the_shaft_through_the_gap);
    return UNITY_END();
}
