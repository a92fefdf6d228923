/* Learned tables: straight lines between nodes on every axis, edges held, the round closed, what is refused, and how
 * far outside the range one was used. */
#include <math.h>

#include "effects/ema_effect_sites.h"
#include "effects/ema_table.h"
#include "ema_open_loop.h"

#define SPANS 15
#define TURN 6.283185307179586

static ema_actuator_t actuator;
static ema_plant_t plant;

void setUp(void)
{
    actuator = ema_rig_actuator();
    plant.gearbox.lead_mm = EMA_R(5.0);
    ema_rig_seed(31U);
}

void tearDown(void)
{
}

/* A table whose nodes are the numbers `nodes[0..15]`. */
static ema_effect_learned_torque_t table_of(int axis, double first, double last, const double* nodes)
{
    ema_effect_learned_torque_t table = {
        .gain = EMA_R(1.0), .axis = (ema_real)axis, .first = (ema_real)first, .last = (ema_real)last};
    ema_real* const node = &table.node_00;
    for (uint32_t k = 0; k <= SPANS; ++k) {
        node[k] = (ema_real)nodes[k];
    }
    return table;
}

/* Nodes that rise by `step` from `from` on. */
static ema_effect_learned_torque_t ramp(int axis, double first, double last, double from, double step)
{
    double nodes[SPANS + 1];
    for (uint32_t k = 0; k <= SPANS; ++k) {
        nodes[k] = from + (step * k);
    }
    return table_of(axis, first, last, nodes);
}

/* A place at which every axis shows another number. */
static ema_site_t site_at(double speed_rad_s, double position_mm, double angle_rad, double current_A)
{
    const ema_site_t site = {.plant = &plant,
                             .speed_rad_s = (ema_real)speed_rad_s,
                             .angle_rad = (ema_real)angle_rad,
                             .position_mm = (ema_real)position_mm,
                             .current_A = (ema_real)current_A};
    return site;
}

static void test_a_straight_line_is_met_on_every_axis(void)
{
    for (uint32_t k = 0; k < 2000U; ++k) {
        const double speed = (double)ema_rig_uniform(EMA_R(-100.0), EMA_R(100.0));
        const double position = (double)ema_rig_uniform(EMA_R(-2.0), EMA_R(2.0));
        const double angle = (double)ema_rig_uniform(EMA_R(-40.0), EMA_R(40.0));
        const double current = (double)ema_rig_uniform(EMA_R(-6.0), EMA_R(6.0));
        const ema_site_t site = site_at(speed, position, angle, current);
        const double lead = position - (5.0 * floor(position / 5.0));
        const double turn = angle - (TURN * floor(angle / TURN));
        const double at[5] = {speed, position, lead, turn, current};
        const double first[5] = {-100.0, -2.0, 0.0, 0.0, -6.0};
        const double last[5] = {100.0, 2.0, 5.0, TURN, 6.0};
        for (int axis = 0; axis < 5; ++axis) {
            const ema_effect_learned_torque_t table = ramp(axis, first[axis], last[axis], 1.0, 0.2);
            const double expected = 1.0 + (3.0 * (at[axis] - first[axis]) / (last[axis] - first[axis]));
            EMA_ASSERT_CLOSE(expected, ema_effect_learned_torque(&table, &site), 60.0 * EMA_EPS, 0.0);
        }
    }
}

static void test_nodes_are_met_and_the_line_between_them_is_straight(void)
{
    double nodes[SPANS + 1];
    for (uint32_t k = 0; k <= SPANS; ++k) {
        nodes[k] = (double)ema_rig_uniform(EMA_R(-1.0), EMA_R(1.0));
    }
    const ema_effect_learned_torque_t table = table_of(EMA_AXIS_POSITION, -7.5, 7.5, nodes);
    for (uint32_t k = 0; k <= SPANS; ++k) {
        const ema_site_t at = site_at(0.0, (double)k - 7.5, 0.0, 0.0);
        EMA_ASSERT_CLOSE(nodes[k], ema_effect_learned_torque(&table, &at), EMA_EPS, 0.0);
        if (k < SPANS) {
            const ema_site_t between = site_at(0.0, (double)k - 7.25, 0.0, 0.0);
            EMA_ASSERT_CLOSE((0.75 * nodes[k]) + (0.25 * nodes[k + 1U]), ema_effect_learned_torque(&table, &between),
                             4.0 * EMA_EPS, 0.0);
        }
    }
}

static void test_the_edge_value_is_held_outside_the_range(void)
{
    const ema_effect_learned_torque_t table = ramp(EMA_AXIS_CURRENT, 2.0, 5.0, 1.0, 0.5);
    const double below[4] = {1.999, 0.0, -5.0, -1.0e30};
    const double above[4] = {5.001, 9.0, 1.0e4, 1.0e30};
    for (uint32_t k = 0; k < 4U; ++k) {
        const ema_site_t low = site_at(0.0, 0.0, 0.0, below[k]);
        const ema_site_t high = site_at(0.0, 0.0, 0.0, above[k]);
        TEST_ASSERT_TRUE(ema_effect_learned_torque(&table, &low) == EMA_R(1.0));
        TEST_ASSERT_TRUE(ema_effect_learned_torque(&table, &high) == EMA_R(8.5));
    }
}

static void test_a_periodic_axis_repeats_and_closes_the_round(void)
{
    /* nodes over fifteen sixteenths of the turn: the last span leads back to the first node */
    const ema_effect_learned_torque_t table = ramp(EMA_AXIS_TURN, 0.0, TURN * 15.0 / 16.0, 0.0, 1.0);
    for (int turns = -3; turns <= 3; ++turns) {
        const ema_site_t node = site_at(0.0, 0.0, (turns * TURN) + (TURN * 4.0 / 16.0), 0.0);
        const ema_site_t closing = site_at(0.0, 0.0, (turns * TURN) + (TURN * 15.25 / 16.0), 0.0);
        EMA_ASSERT_CLOSE(4.0, ema_effect_learned_torque(&table, &node), 300.0 * EMA_EPS, 0.0);
        EMA_ASSERT_CLOSE(0.75 * 15.0, ema_effect_learned_torque(&table, &closing), 4000.0 * EMA_EPS, 0.0);
    }
    /* a range that starts anywhere, and covers the lead but for a part */
    const ema_effect_learned_torque_t part = ramp(EMA_AXIS_LEAD, 3.0, 6.0, 1.0, 1.0);
    const ema_site_t start = site_at(0.0, -2.0, 0.0, 0.0);
    const ema_site_t past = site_at(0.0, 7.0, 0.0, 0.0);
    EMA_ASSERT_CLOSE(1.0, ema_effect_learned_torque(&part, &start), 16.0 * EMA_EPS, 0.0);
    EMA_ASSERT_CLOSE(8.5, ema_effect_learned_torque(&part, &past), 16.0 * EMA_EPS, 0.0);
}

static void test_gain_scales_and_friction_ignores_the_level(void)
{
    ema_effect_learned_torque_t table = ramp(EMA_AXIS_SPEED, -10.0, 10.0, 1.0, 0.0);
    const ema_site_t site = site_at(3.0, 0.0, 0.0, 0.0);
    table.gain = EMA_R(-2.5);
    TEST_ASSERT_TRUE(ema_effect_learned_torque(&table, &site) == EMA_R(-2.5));
    ema_effect_learned_friction_t friction;
    (void)memcpy(&friction, &table, sizeof friction);
    TEST_ASSERT_TRUE(ema_effect_learned_friction(&friction, &site, EMA_R(0.1)) == EMA_R(-2.5));
    TEST_ASSERT_TRUE(ema_effect_learned_friction(&friction, &site, EMA_R(0.7)) == EMA_R(-2.5));
}

static void test_what_is_no_number_stays_in_the_table(void)
{
    for (int axis = 0; axis < 5; ++axis) {
        const ema_effect_learned_torque_t table = ramp(axis, 0.0, 2.0, 1.0, 1.0);
        const ema_site_t site = site_at((double)NAN, (double)NAN, (double)NAN, (double)NAN);
        const ema_real value = ema_effect_learned_torque(&table, &site);
        TEST_ASSERT_TRUE((value >= EMA_R(1.0)) && (value <= EMA_R(16.0)));
    }
}

static void test_outside_is_counted_in_shares_of_the_range(void)
{
    const ema_effect_learned_torque_t table = ramp(EMA_AXIS_POSITION, -1.0, 3.0, 0.0, 1.0);
    const double at[6] = {-1.0, 3.0, 1.0, -2.0, 4.0, 11.0};
    const double expected[6] = {0.0, 0.0, 0.0, 0.25, 0.25, 2.0};
    for (uint32_t k = 0; k < 6U; ++k) {
        const ema_site_t site = site_at(0.0, at[k], 0.0, 0.0);
        EMA_ASSERT_CLOSE(expected[k], ema_table_outside(EMA_TABLE_OF(&table), &site, EMA_R(0.0)), 4.0 * EMA_EPS, 0.0);
    }
    /* on a periodic axis the nearer edge counts */
    const ema_effect_learned_torque_t part = ramp(EMA_AXIS_LEAD, 0.0, 2.0, 0.0, 1.0);
    const double round_at[5] = {1.0, 2.5, 4.5, -0.5, 8.5};
    const double round_expected[5] = {0.0, 0.25, 0.25, 0.25, 0.75};
    for (uint32_t k = 0; k < 5U; ++k) {
        const ema_site_t site = site_at(0.0, round_at[k], 0.0, 0.0);
        EMA_ASSERT_CLOSE(round_expected[k], ema_table_outside(EMA_TABLE_OF(&part), &site, EMA_R(0.0)), 4.0 * EMA_EPS,
                         0.0);
    }
}

/* The check's answer when `field` of an acting table is `value`. */
#define REFUSED(status, name, field, value)                                                                            \
    do {                                                                                                               \
        ema_actuator_t bad = actuator;                                                                                 \
        size_t offender = SIZE_MAX;                                                                                    \
        ema_model_t model;                                                                                             \
        bad.effects.name.gain = EMA_R(1.0);                                                                            \
        bad.effects.name.field = (value);                                                                              \
        EMA_ASSERT_STATUS((status), ema_actuator_check(&bad, &offender));                                              \
        TEST_ASSERT_EQUAL_size_t(EMA_EFFECT_VALUE_ID(name, field), offender);                                          \
        EMA_ASSERT_STATUS((status), ema_model_init(&model, &bad, EMA_R(0.0)));                                         \
        bad.effects.name.gain = EMA_R(0.0);                                                                            \
        if (isfinite((double)(value))) {                                                                               \
            EMA_ASSERT_STATUS(EMA_OK, ema_actuator_check(&bad, &offender));                                            \
        }                                                                                                              \
    } while (0)

static void test_a_table_that_cannot_be_read_is_refused_and_named(void)
{
    REFUSED(EMA_ERR_BOUNDS, learned_torque, first, EMA_R(1.0));
    REFUSED(EMA_ERR_BOUNDS, learned_friction, first, EMA_R(1.5));
    REFUSED(EMA_ERR_RANGE, learned_voltage, axis, EMA_R(0.5));
    REFUSED(EMA_ERR_NOT_FINITE, learned_reading, node_15, (ema_real)NAN);
    REFUSED(EMA_ERR_NOT_FINITE, learned_torque, last, (ema_real)INFINITY);
    /* a range of nearly nothing has no inverse */
    actuator.effects.learned_torque.last = EMA_R(0.0);
    REFUSED(EMA_ERR_BOUNDS, learned_torque, first, -(EMA_BY_PRECISION(1.0e-40F, 1.0e-310)));
    actuator.effects.learned_torque.last = EMA_R(4.0);
    actuator.effects.learned_torque.axis = EMA_R(2.0);
    REFUSED(EMA_ERR_RANGE, learned_torque, last, EMA_R(4.01));
    actuator.effects.learned_torque.axis = EMA_R(3.0);
    REFUSED(EMA_ERR_RANGE, learned_torque, last, EMA_R(5.3));
    /* a whole turn and a whole lead are not too long */
    actuator.effects.learned_torque.gain = EMA_R(1.0);
    actuator.effects.learned_torque.first = EMA_R(0.0);
    actuator.effects.learned_torque.last = EMA_R(6.2831853);
    EMA_ASSERT_STATUS(EMA_OK, ema_actuator_check(&actuator, NULL));
}

static void test_learned_values_are_known_by_their_ids(void)
{
    uint32_t learned = 0U;
    for (size_t id = 0; id < EMA_VALUE_COUNT; ++id) {
        learned += ema_actuator_is_learned((ema_value_id_t)id) ? 1U : 0U;
    }
    TEST_ASSERT_EQUAL_UINT32(4U * 20U, learned);
    TEST_ASSERT_TRUE(ema_actuator_is_learned(EMA_EFFECT_VALUE_ID(learned_reading, node_07)));
    TEST_ASSERT_FALSE(ema_actuator_is_learned(EMA_VALUE_ID(csj_Nm)));
    TEST_ASSERT_FALSE(ema_actuator_is_learned(EMA_EFFECT_VALUE_ID(gain_drift, drift)));
    TEST_ASSERT_FALSE(ema_actuator_is_learned((ema_value_id_t)EMA_VALUE_COUNT));
}

/* All nodes at one value. */
#define FLAT(name, value)                                                                                              \
    do {                                                                                                               \
        actuator.effects.name.gain = EMA_R(1.0);                                                                       \
        actuator.effects.name.first = EMA_R(-1.0e4);                                                                   \
        actuator.effects.name.last = EMA_R(1.0e4);                                                                     \
        for (uint32_t k = 0; k <= SPANS; ++k) {                                                                        \
            (&actuator.effects.name.node_00)[k] = EMA_R(value);                                                        \
        }                                                                                                              \
    } while (0)

static void test_flat_tables_are_what_they_are_called(void)
{
    actuator = ema_open_loop();
    FLAT(learned_friction, 0.1);
    EMA_ASSERT_CLOSE(0.238, ema_open_loop_break_away_Nm(&actuator, 0.0), 0.0, 1.0e-3);
    FLAT(learned_torque, 0.05);
    EMA_ASSERT_CLOSE(0.188, ema_open_loop_break_away_Nm(&actuator, 0.0), 0.0, 1.0e-3);
    /* more friction than there is cannot be taken away */
    actuator = ema_open_loop();
    FLAT(learned_friction, -1.0);
    EMA_ASSERT_CLOSE(0.0, ema_open_loop_break_away_Nm(&actuator, 0.0), 2.0e-3, 0.0);
    actuator = ema_open_loop_locked();
    FLAT(learned_voltage, 1.2);
    const ema_model_t locked = ema_open_loop_steady(&actuator, 0.5);
    EMA_ASSERT_CLOSE((12.0 + 1.2) / 0.99, locked.state.current_A, 0.0, 1.0e-4);
}

static void test_reading_is_added_to_the_rod_sensor_and_to_its_loop(void)
{
    FLAT(learned_reading, 0.25);
    ema_actuator_t offset = ema_rig_actuator();
    offset.effects.sensor_offset.offset_mm = EMA_R(0.25);
    const ema_command_t command = ema_rig_chirp(EMA_R(4.0), EMA_R(1.0), EMA_R(1.0e-3));
    for (int32_t side = 0; side < 2; ++side) {
        actuator.options.side = side;
        offset.options.side = side;
        ema_model_t learned = ema_rig_model(&actuator, EMA_R(0.5));
        ema_model_t known = ema_rig_model(&offset, EMA_R(0.5));
        EMA_ASSERT_SAME_BITS(known.state.delay_mm, learned.state.delay_mm, sizeof known.state.delay_mm);
        for (uint32_t step = 0; step < 1000U; ++step) {
            const ema_output_t a = ema_rig_step(&learned, ema_command_at(&command, step));
            const ema_output_t b = ema_rig_step(&known, ema_command_at(&command, step));
            EMA_ASSERT_CLOSE((double)b.position_mm, a.position_mm, EMA_BY_PRECISION(1.0e-6, 1.0e-13), 0.0);
            EMA_ASSERT_CLOSE((double)b.current_A, a.current_A, EMA_BY_PRECISION(2.0e-4, 1.0e-10), 0.0);
        }
        TEST_ASSERT_FALSE(learned.plant.active.any);
    }
}

static void test_the_state_keeps_how_far_outside_a_table_was_used(void)
{
    FLAT(learned_torque, 0.0);
    actuator.effects.learned_torque.first = EMA_R(-1.0);
    actuator.effects.learned_torque.last = EMA_R(1.0);
    const ema_command_t command = ema_rig_chirp(EMA_R(2.0), EMA_R(2.0), EMA_R(1.0e-3));
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    double farthest_mm = 0.0;
    for (uint32_t step = 0; step < 2000U; ++step) {
        const ema_output_t row = ema_rig_step(&model, ema_command_at(&command, step));
        farthest_mm = fmax(farthest_mm, fabs((double)row.motor_position_mm));
        EMA_ASSERT_CLOSE(fmax(farthest_mm - 1.0, 0.0) / 2.0, model.state.outside_ratio, 8.0 * EMA_EPS, 0.0);
    }
    TEST_ASSERT_TRUE(model.state.outside_ratio > EMA_R(0.4));
    ema_model_restart(&model);
    TEST_ASSERT_TRUE(model.state.outside_ratio == EMA_R(0.0));
    /* without a table nothing is kept */
    actuator.effects.learned_torque.gain = EMA_R(0.0);
    model = ema_rig_model(&actuator, EMA_R(0.0));
    TEST_ASSERT_NULL(model.plant.learned);
    (void)ema_rig_hold(&model, EMA_R(5.0), 500U);
    TEST_ASSERT_TRUE(model.state.outside_ratio == EMA_R(0.0));
}

static void test_a_model_reads_its_tables_where_it_is_told(void)
{
    FLAT(learned_friction, 0.02);
    ema_actuator_t gone = actuator;
    ema_model_t direct = ema_rig_model(&actuator, EMA_R(0.0));
    ema_model_t moved = ema_rig_model(&gone, EMA_R(0.0));
    TEST_ASSERT_TRUE(moved.plant.learned == &gone.effects);
    ema_model_learned(&moved, &actuator);
    (void)memset(&gone, 0x5A, sizeof gone);
    (void)ema_rig_hold(&direct, EMA_R(1.0), 300U);
    (void)ema_rig_hold(&moved, EMA_R(1.0), 300U);
    EMA_ASSERT_SAME_BITS(&direct.state, &moved.state, sizeof direct.state);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_straight_line_is_met_on_every_axis);
    RUN_TEST(test_nodes_are_met_and_the_line_between_them_is_straight);
    RUN_TEST(test_the_edge_value_is_held_outside_the_range);
    RUN_TEST(test_a_periodic_axis_repeats_and_closes_the_round);
    RUN_TEST(test_gain_scales_and_friction_ignores_the_level);
    RUN_TEST(test_what_is_no_number_stays_in_the_table);
    RUN_TEST(test_outside_is_counted_in_shares_of_the_range);
    RUN_TEST(test_a_table_that_cannot_be_read_is_refused_and_named);
    RUN_TEST(test_learned_values_are_known_by_their_ids);
    RUN_TEST(test_flat_tables_are_what_they_are_called);
    RUN_TEST(test_reading_is_added_to_the_rod_sensor_and_to_its_loop);
    RUN_TEST(test_the_state_keeps_how_far_outside_a_table_was_used);
    RUN_TEST(test_a_model_reads_its_tables_where_it_is_told);
    return UNITY_END();
}
