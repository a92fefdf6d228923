/* What happens in a span, on the bounds themselves: where rounding has put the current or the speed on the bound or
 * just beyond it. */
#include "ema_rig.h"
#include "plant/ema_motion_events.h"

#define KT 0.0612
#define R_OHM 0.99

static ema_actuator_t actuator;
static ema_model_t model;
static ema_step_scratch_t work;

void setUp(void)
{
    static const ema_step_scratch_t fresh;
    actuator = ema_rig_actuator();
    work = fresh;
}

void tearDown(void)
{
}

/* A shaft that slides under `voltage_V`, and nothing that has just happened to it. */
static void slide(ema_real current_A, ema_real speed_rad_s, int32_t motion, ema_real voltage_V)
{
    const ema_drive_output_t applied = {voltage_V, voltage_V, false};
    model = ema_rig_model(&actuator, EMA_R(0.0));
    model.state.current_A = current_A;
    model.state.speed_rad_s = speed_rad_s;
    model.state.motion = motion;
    work.applied = applied;
    work.circuit = &model.plant.motor_circuit;
}

static void find(ema_real span_s)
{
    work.span_s = span_s;
    ema_segment_open(&model.plant, &model.state, &work);
    ema_event_find(&model.plant, &model.state, &work);
}

/* Whether a current under `input` is held after `value` was reached, or, with EMA_EVENT_NONE, nothing. */
static bool held_after(ema_event_kind_t kind, ema_real value, ema_real input)
{
    work.event.kind = kind;
    work.event.value = value;
    work.segment.forces.input = input;
    ema_regime_update(&model.plant, &model.state, &work);
    return work.regime.held;
}

/* A current that follows the voltage at once and has just risen to the limit is held, though rounding finds it below.
 */
static void test_current_that_reached_its_limit_is_held(void)
{
    actuator.params.inductance_H = EMA_R(0.0);
    actuator.params.current_limit_A = EMA_R(5.0);
    const ema_real below_V = (ema_real)(R_OHM * 4.999);
    slide(EMA_R(5.0), EMA_R(0.0), (int32_t)EMA_MOTION_STUCK, below_V);
    TEST_ASSERT_FALSE(held_after(EMA_EVENT_NONE, EMA_R(0.0), below_V));
    for (int32_t side = -1; side <= 1; side += 2) {
        TEST_ASSERT_TRUE(held_after(EMA_EVENT_CURRENT, (ema_real)side * EMA_R(5.0), below_V));
    }
    /* another bound says nothing about this one */
    TEST_ASSERT_FALSE(held_after(EMA_EVENT_CURRENT, EMA_R(4.0), below_V));
}

/* A current that has just come back inside, but that rounding left outside: it does not cross the bound outward a
 * second time. */
static void test_current_beyond_its_bound_does_not_cross_it_outward(void)
{
    actuator.params.torque_limit_Nm = (ema_real)(KT * 5.0);
    for (int32_t side = -1; side <= 1; side += 2) {
        const ema_real sign = (ema_real)side;
        slide(sign * EMA_R(5.0001), EMA_R(0.0), (int32_t)EMA_MOTION_STUCK, sign * EMA_R(24.0));
        model.plant.screw.static_Nm = EMA_R(10.0);
        find(EMA_R(1.0e-4));
        TEST_ASSERT_TRUE((sign * work.segment.end.current_A) > EMA_R(5.0));
        TEST_ASSERT_EQUAL_INT(EMA_EVENT_NONE, work.event.kind);
        /* from inside the same bound is crossed */
        model.state.current_A = sign * EMA_R(4.9);
        find(EMA_R(1.0e-4));
        TEST_ASSERT_EQUAL_INT(EMA_EVENT_CURRENT, work.event.kind);
        EMA_ASSERT_CLOSE((double)side * 5.0, work.event.value, 0.0, 8.0 * EMA_EPS);
        EMA_ASSERT_CLOSE(work.event.value, work.event.current_A, 0.0, 16.0 * EMA_EPS);
    }
}

/* A held current is let go where the circuit stops pushing it outward; one that was never pushed has no such instant.
 */
static void test_only_a_current_that_is_pushed_outward_is_let_go(void)
{
    actuator.params.current_limit_A = EMA_R(5.0);
    work.regime.held = true;
    /* the speed rises under 5 A, so that the back-EMF takes over: 24 V - 4.95 V are those of 311.3 rad/s */
    const double even_rad_s = (24.0 - (R_OHM * 5.0)) / KT;
    slide(EMA_R(5.0), (ema_real)(even_rad_s - 1.0), (int32_t)EMA_MOTION_FORWARD, EMA_R(24.0));
    find(EMA_R(1.0e-3));
    TEST_ASSERT_EQUAL_INT(EMA_EVENT_RELEASE, work.event.kind);
    EMA_ASSERT_CLOSE(even_rad_s, work.event.speed_rad_s, 0.0, 1.0e-5);
    slide(EMA_R(5.0), (ema_real)(even_rad_s + 1.0), (int32_t)EMA_MOTION_FORWARD, EMA_R(24.0));
    find(EMA_R(1.0e-3));
    TEST_ASSERT_EQUAL_INT(EMA_EVENT_NONE, work.event.kind);
    TEST_ASSERT_TRUE(work.event.current_A == EMA_R(5.0));
}

/* A shaft that starts at zero speed and is driven back rests at once; a current that reaches its bound before that
 * comes first. */
static void test_reversal_from_zero_speed_against_a_crossing_of_the_current(void)
{
    actuator.params.torque_limit_Nm = (ema_real)(KT * 5.0);
    const double start_A[2] = {-4.0, -4.999};
    const ema_event_kind_t expected[2] = {EMA_EVENT_REST, EMA_EVENT_CURRENT};
    for (uint32_t k = 0; k < 2U; ++k) {
        slide((ema_real)start_A[k], EMA_R(0.0), (int32_t)EMA_MOTION_FORWARD, EMA_R(-24.0));
        find(EMA_R(1.0e-4));
        TEST_ASSERT_TRUE(work.segment.end.current_A < EMA_R(-5.0));
        TEST_ASSERT_TRUE(work.segment.end.speed_rad_s < EMA_R(0.0));
        TEST_ASSERT_EQUAL_INT(expected[k], work.event.kind);
        TEST_ASSERT_TRUE((k == 0U) ? (work.event.at == EMA_R(0.0625)) : (work.event.at < EMA_R(0.0625)));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_current_that_reached_its_limit_is_held);
    RUN_TEST(test_current_beyond_its_bound_does_not_cross_it_outward);
    RUN_TEST(test_only_a_current_that_is_pushed_outward_is_let_go);
    RUN_TEST(test_reversal_from_zero_speed_against_a_crossing_of_the_current);
    return UNITY_END();
}
