/* Ball screw: the play's kinematics, and which way a shaft at rest goes. */
#include <math.h>

#include "blocks/ema_mechanics.h"
#include "ema_rig.h"

static ema_actuator_t actuator;
static ema_state_t state;

void setUp(void)
{
    const ema_state_t rest = {0};
    actuator = ema_rig_actuator();
    state = rest;
    ema_rig_seed(4U);
}

void tearDown(void)
{
}

static ema_screw_t prepared(void)
{
    ema_gearbox_t gearbox;
    ema_screw_t screw;
    ema_gearbox_prepare(&gearbox, &actuator.params);
    ema_screw_prepare(&screw, &gearbox, &actuator.params);
    return screw;
}

static void test_play_never_exceeds_half_its_width(void)
{
    actuator.params.blk_mm = EMA_R(0.5);
    const ema_screw_t screw = prepared();
    ema_real input_mm = EMA_R(0.0);
    double largest = 0.0;
    for (uint32_t k = 0; k < 100000U; ++k) {
        input_mm += ema_rig_uniform(EMA_R(-0.2), EMA_R(0.2));
        ema_screw_play(&screw, &state, input_mm);
        largest = fmax(largest, fabs((double)input_mm - (double)state.play_mm));
    }
    /* and it is used up to the last bit of positions of some mm */
    EMA_ASSERT_CLOSE(0.25, largest, 128.0 * EMA_EPS, 0.0);
}

static void test_play_sequence(void)
{
    actuator.params.blk_mm = EMA_R(0.5);
    const ema_screw_t screw = prepared();
    const double input_mm[9] = {0.125, 0.25, 1.0, 0.75, 0.5, 0.25, -1.0, -0.75, -0.25};
    const double output_mm[9] = {0.0, 0.0, 0.75, 0.75, 0.75, 0.5, -0.75, -0.75, -0.5};
    const int32_t side[9] = {0, 0, 1, 0, 0, -1, -1, 0, 1};
    for (uint32_t k = 0; k < 9U; ++k) {
        ema_screw_play(&screw, &state, (ema_real)input_mm[k]);
        TEST_ASSERT_TRUE((double)state.play_mm == output_mm[k]);
        TEST_ASSERT_EQUAL_INT32(side[k], state.play_side);
    }
}

static void test_play_of_no_width_follows_exactly(void)
{
    actuator.params.blk_mm = EMA_R(0.0);
    const ema_screw_t screw = prepared();
    for (uint32_t k = 0; k < 1000U; ++k) {
        const ema_real input_mm = ema_rig_uniform(EMA_R(-20.0), EMA_R(20.0));
        ema_screw_play(&screw, &state, input_mm);
        TEST_ASSERT_TRUE(state.play_mm == input_mm);
    }
}

static void test_prepared_levels_and_stops(void)
{
    actuator.params.csj_Nm = EMA_R(0.2);
    actuator.params.dynamic_ratio = EMA_R(0.75);
    actuator.params.load_torque_Nm = EMA_R(0.05);
    actuator.params.efficiency = EMA_R(0.8);
    const ema_screw_t screw = prepared();
    const double tolerance = 8.0 * EMA_EPS;
    EMA_ASSERT_CLOSE(0.2, screw.static_Nm, 0.0, tolerance);
    EMA_ASSERT_CLOSE(0.15, screw.dynamic_Nm, 0.0, tolerance);
    /* forward the load opposes, backward it aids */
    EMA_ASSERT_CLOSE(-0.05 - 0.15 - (0.25 * 0.05), screw.forward_torque_Nm, 0.0, tolerance);
    EMA_ASSERT_CLOSE(-0.05 + 0.15 + (0.2 * 0.05), screw.backward_torque_Nm, 0.0, tolerance);
    EMA_ASSERT_CLOSE(0.05 + 0.2 + (0.25 * 0.05), screw.hold_upper_Nm, 0.0, tolerance);
    EMA_ASSERT_CLOSE(0.05 - 0.2 - (0.2 * 0.05), screw.hold_lower_Nm, 0.0, tolerance);
    EMA_ASSERT_CLOSE(25.0 / (5.0 / (6.283185307179586 * 4.0)), screw.stop_upper_rad, 0.0, tolerance);
    TEST_ASSERT_TRUE(screw.stop_lower_rad == -screw.stop_upper_rad);
    EMA_ASSERT_CLOSE(0.0165, screw.half_play_mm, 0.0, tolerance);
    EMA_ASSERT_CLOSE(1.0 / 6.0e-5, screw.inverse_inertia_per_kgm2, 0.0, tolerance);
}

static void test_shaft_at_rest_stays_up_to_its_level(void)
{
    const ema_screw_t screw = prepared();
    const ema_real level_Nm = EMA_R(0.25);
    const ema_real above_Nm = EMA_R(0.2500001);
    TEST_ASSERT_EQUAL_INT(EMA_MOTION_STUCK, ema_screw_break_away(&screw, EMA_R(0.0), level_Nm, level_Nm, level_Nm));
    TEST_ASSERT_EQUAL_INT(EMA_MOTION_STUCK, ema_screw_break_away(&screw, EMA_R(0.0), -level_Nm, level_Nm, level_Nm));
    TEST_ASSERT_EQUAL_INT(EMA_MOTION_FORWARD, ema_screw_break_away(&screw, EMA_R(0.0), above_Nm, level_Nm, level_Nm));
    TEST_ASSERT_EQUAL_INT(EMA_MOTION_BACKWARD, ema_screw_break_away(&screw, EMA_R(0.0), -above_Nm, level_Nm, level_Nm));
}

static void test_each_direction_has_its_own_level(void)
{
    const ema_screw_t screw = prepared();
    TEST_ASSERT_EQUAL_INT(EMA_MOTION_STUCK,
                          ema_screw_break_away(&screw, EMA_R(0.0), EMA_R(0.3), EMA_R(0.4), EMA_R(0.2)));
    TEST_ASSERT_EQUAL_INT(EMA_MOTION_BACKWARD,
                          ema_screw_break_away(&screw, EMA_R(0.0), EMA_R(-0.3), EMA_R(0.4), EMA_R(0.2)));
}

static void test_shaft_at_a_stop_leaves_inward_only(void)
{
    const ema_screw_t screw = prepared();
    const ema_real level_Nm = EMA_R(0.1);
    TEST_ASSERT_EQUAL_INT(EMA_MOTION_STUCK,
                          ema_screw_break_away(&screw, screw.stop_upper_rad, EMA_R(1.0), level_Nm, level_Nm));
    TEST_ASSERT_EQUAL_INT(EMA_MOTION_BACKWARD,
                          ema_screw_break_away(&screw, screw.stop_upper_rad, EMA_R(-1.0), level_Nm, level_Nm));
    TEST_ASSERT_EQUAL_INT(EMA_MOTION_STUCK,
                          ema_screw_break_away(&screw, screw.stop_lower_rad, EMA_R(-1.0), level_Nm, level_Nm));
    TEST_ASSERT_EQUAL_INT(EMA_MOTION_FORWARD,
                          ema_screw_break_away(&screw, screw.stop_lower_rad, EMA_R(1.0), level_Nm, level_Nm));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_play_never_exceeds_half_its_width);
    RUN_TEST(test_play_sequence);
    RUN_TEST(test_play_of_no_width_follows_exactly);
    RUN_TEST(test_prepared_levels_and_stops);
    RUN_TEST(test_shaft_at_rest_stays_up_to_its_level);
    RUN_TEST(test_each_direction_has_its_own_level);
    RUN_TEST(test_shaft_at_a_stop_leaves_inward_only);
    return UNITY_END();
}
