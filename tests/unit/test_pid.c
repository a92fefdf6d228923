/* Control logic: each structure against its closed form, saturation, anti-windup and its own rate. */
#include <math.h>

#include "blocks/ema_pid.h"
#include "ema_rig.h"

#define TOLERANCE (8.0 * EMA_EPS)

static ema_actuator_t actuator;
static ema_state_t state;

void setUp(void)
{
    const ema_state_t rest = {0};
    actuator = ema_rig_actuator();
    /* each test switches on what it looks at */
    actuator.params.kp_per_m = EMA_R(0.0);
    actuator.params.ki_per_m_s = EMA_R(0.0);
    actuator.params.anti_windup_per_s = EMA_R(0.0);
    state = rest;
    ema_rig_seed(3U);
}

void tearDown(void)
{
}

static ema_pid_t prepared(void)
{
    ema_pid_t pid;
    ema_pid_prepare(&pid, &actuator.params, &actuator.options);
    return pid;
}

/* One control run; the model advances the step. */
static double run(const ema_pid_t* pid, double command_mm, double feedback_mm)
{
    const ema_real output = ema_pid_step(pid, &state, (ema_real)command_mm, (ema_real)feedback_mm);
    ++state.step;
    return (double)output;
}

static void test_proportional_action_is_gain_times_error_in_metres(void)
{
    actuator.params.kp_per_m = EMA_R(400.0);
    const ema_pid_t pid = prepared();
    EMA_ASSERT_CLOSE(400.0 * 0.5e-3, run(&pid, 1.25, 0.75), 0.0, TOLERANCE);
    EMA_ASSERT_CLOSE(-400.0 * 0.5e-3, run(&pid, 0.75, 1.25), 0.0, TOLERANCE);
    EMA_ASSERT_CLOSE(0.0, run(&pid, 1.0, 1.0), 0.0, 0.0);
}

static void test_integral_action_follows_the_output(void)
{
    actuator.params.ki_per_m_s = EMA_R(400.0);
    const ema_pid_t pid = prepared();
    for (uint32_t k = 0; k < 50U; ++k) {
        /* the integral of k earlier runs */
        EMA_ASSERT_CLOSE(k * 1.0e-3 * 400.0 * 0.5e-3, run(&pid, 0.5, 0.0), 1.0e-6 * EMA_BY_PRECISION(1.0, 1.0e-6), 0.0);
    }
}

static void test_derivative_of_the_error_starts_at_zero(void)
{
    actuator.params.kd_s_per_m = EMA_R(1.5);
    const ema_pid_t pid = prepared();
    EMA_ASSERT_CLOSE(0.0, run(&pid, 2.0, 1.0), 0.0, 0.0);
    /* the error grows from 1 mm to 1.25 mm in 1 ms, then stays */
    EMA_ASSERT_CLOSE(1.5 * 0.25, run(&pid, 2.0, 0.75), 0.0, EMA_BY_PRECISION(1.0e-5, 1.0e-12));
    EMA_ASSERT_CLOSE(0.0, run(&pid, 2.0, 0.75), 1.0e-12, 0.0);
}

static void test_derivative_of_the_error_kicks_at_a_step_of_the_command(void)
{
    actuator.params.kd_s_per_m = EMA_R(0.5);
    const ema_pid_t pid = prepared();
    (void)run(&pid, 0.0, 0.0);
    EMA_ASSERT_CLOSE(0.5 * 1.0, run(&pid, 1.0, 0.0), 0.0, EMA_BY_PRECISION(1.0e-5, 1.0e-12));
}

static void test_derivative_of_the_measured_speed_does_not_kick(void)
{
    actuator.options.derivative = 1;
    actuator.params.kd_s_per_m = EMA_R(0.5);
    const ema_pid_t pid = prepared();
    (void)run(&pid, 0.0, 0.0);
    EMA_ASSERT_CLOSE(0.0, run(&pid, 1.0, 0.0), 0.0, 0.0);
}

static void test_derivative_of_the_measured_speed_brakes(void)
{
    actuator.options.derivative = 1;
    actuator.params.kd_s_per_m = EMA_R(0.5);
    const ema_pid_t pid = prepared();
    EMA_ASSERT_CLOSE(0.0, run(&pid, 0.0, 0.25), 0.0, 0.0);
    for (uint32_t k = 1; k < 20U; ++k) {
        /* 0.25 mm in 1 ms is 0.25 m/s */
        EMA_ASSERT_CLOSE(-0.5 * 0.25, run(&pid, 0.0, 0.25 * (k + 1U)), 0.0, EMA_BY_PRECISION(1.0e-5, 1.0e-12));
    }
}

static void test_averaged_speed_is_that_of_two_samples(void)
{
    const double feedback_mm[5] = {0.0, 0.125, 0.5, 0.25, 0.25};
    actuator.options.derivative = 1;
    actuator.options.average_speed = 1;
    actuator.params.kd_s_per_m = EMA_R(0.5);
    const ema_pid_t pid = prepared();
    for (uint32_t k = 0; k < 5U; ++k) {
        /* mean of now and before, against the mean one run earlier; the first run has itself before it */
        const double now = 0.5 * (feedback_mm[k] + feedback_mm[(k > 0U) ? (k - 1U) : 0U]);
        const double before = (k > 0U) ? (0.5 * (feedback_mm[k - 1U] + feedback_mm[(k > 1U) ? (k - 2U) : 0U])) : now;
        EMA_ASSERT_CLOSE(-0.5 * (now - before), run(&pid, 0.0, feedback_mm[k]), EMA_BY_PRECISION(1.0e-6, 1.0e-13), 0.0);
    }
}

static void test_output_saturates_at_its_limit(void)
{
    actuator.params.kp_per_m = EMA_R(400.0);
    actuator.params.output_limit = EMA_R(0.75);
    const ema_pid_t pid = prepared();
    TEST_ASSERT_TRUE(run(&pid, 100.0, 0.0) == 0.75);
    TEST_ASSERT_TRUE(run(&pid, -100.0, 0.0) == -0.75);
    EMA_ASSERT_CLOSE(400.0 * 1.8e-3, run(&pid, 1.8, 0.0), 0.0, TOLERANCE);
}

static void test_integral_winds_up_without_back_calculation(void)
{
    actuator.params.kp_per_m = EMA_R(400.0);
    actuator.params.ki_per_m_s = EMA_R(4000.0);
    const ema_pid_t pid = prepared();
    for (uint32_t k = 0; k < 1000U; ++k) {
        (void)run(&pid, 10.0, 0.0);
    }
    EMA_ASSERT_CLOSE(4000.0 * 10.0e-3 * 1.0, state.integral, 0.0, EMA_BY_PRECISION(1.0e-4, 1.0e-12));
}

static void test_back_calculation_holds_the_integral(void)
{
    actuator.params.kp_per_m = EMA_R(400.0);
    actuator.params.ki_per_m_s = EMA_R(4000.0);
    actuator.params.anti_windup_per_s = EMA_R(50.0);
    const ema_pid_t pid = prepared();
    for (uint32_t k = 0; k < 2000U; ++k) {
        (void)run(&pid, 10.0, 0.0);
    }
    /* at rest ki e = kaw (raw - u): raw = u + ki e / kaw, I = raw - kp e */
    EMA_ASSERT_CLOSE((1.0 + (4000.0 * 10.0e-3 / 50.0)) - (400.0 * 10.0e-3), state.integral,
                     EMA_BY_PRECISION(1.0e-5, 1.0e-9), 0.0);
}

static void test_back_calculation_fades_with_its_gain(void)
{
    actuator.params.kp_per_m = EMA_R(400.0);
    actuator.params.anti_windup_per_s = EMA_R(50.0);
    const ema_pid_t pid = prepared();
    double expected = 0.0;
    for (uint32_t k = 0; k < 100U; ++k) {
        (void)run(&pid, 10.0, 0.0);
        expected += 1.0e-3 * 50.0 * (1.0 - (4.0 + expected));
        EMA_ASSERT_CLOSE(expected, state.integral, EMA_BY_PRECISION(1.0e-5, 1.0e-12), 0.0);
    }
}

static void test_cascade_is_its_closed_form(void)
{
    actuator.options.structure = 1;
    actuator.params.position_gain_per_s = EMA_R(20.0);
    actuator.params.speed_gain_s_per_m = EMA_R(6.0);
    actuator.params.speed_integral_per_m = EMA_R(150.0);
    /* what belongs to the other structure has no say */
    actuator.params.kp_per_m = EMA_R(400.0);
    actuator.params.ki_per_m_s = EMA_R(400.0);
    actuator.params.kd_s_per_m = EMA_R(400.0);
    const ema_pid_t pid = prepared();
    double integral = 0.0;
    for (uint32_t k = 0; k < 30U; ++k) {
        const double feedback_mm = 0.0625 * k;
        const double speed_m_s = (k > 0U) ? 0.0625 : 0.0;
        const double speed_error_m_s = (20.0 * (2.0 - feedback_mm) * 1.0e-3) - speed_m_s;
        EMA_ASSERT_CLOSE((6.0 * speed_error_m_s) + integral, run(&pid, 2.0, feedback_mm),
                         EMA_BY_PRECISION(2.0e-6, 1.0e-13), 0.0);
        integral += 1.0e-3 * 150.0 * speed_error_m_s;
    }
}

static void test_cascade_limits_the_speed_it_asks_for(void)
{
    actuator.options.structure = 1;
    actuator.params.position_gain_per_s = EMA_R(20.0);
    actuator.params.speed_gain_s_per_m = EMA_R(6.0);
    actuator.params.speed_limit_m_s = EMA_R(0.03125);
    const ema_pid_t pid = prepared();
    EMA_ASSERT_CLOSE(6.0 * 0.03125, run(&pid, 100.0, 0.0), 0.0, TOLERANCE);
    EMA_ASSERT_CLOSE(-6.0 * 0.03125, run(&pid, -100.0, 0.0), 0.0, TOLERANCE);
    EMA_ASSERT_CLOSE(6.0 * 20.0 * 1.0e-3, run(&pid, 1.0, 0.0), 0.0, TOLERANCE);
}

static void test_cascade_without_a_speed_limit_asks_for_any_speed(void)
{
    actuator.options.structure = 1;
    actuator.params.position_gain_per_s = EMA_R(20.0);
    actuator.params.speed_gain_s_per_m = EMA_R(0.25);
    const ema_pid_t pid = prepared();
    EMA_ASSERT_CLOSE(0.25 * 20.0 * 0.125, run(&pid, 125.0, 0.0), 0.0, TOLERANCE);
}

static void test_cascade_averages_its_speed(void)
{
    actuator.options.structure = 1;
    actuator.options.average_speed = 1;
    actuator.params.speed_gain_s_per_m = EMA_R(1.0);
    const ema_pid_t pid = prepared();
    EMA_ASSERT_CLOSE(0.0, run(&pid, 0.0, 0.0), 0.0, 0.0);
    EMA_ASSERT_CLOSE(-0.125, run(&pid, 0.0, 0.25), 0.0, EMA_BY_PRECISION(1.0e-5, 1.0e-12));
    EMA_ASSERT_CLOSE(-0.25, run(&pid, 0.0, 0.5), 0.0, EMA_BY_PRECISION(1.0e-5, 1.0e-12));
}

static void test_control_law_runs_at_its_own_rate(void)
{
    actuator.options.every_steps = 4;
    actuator.params.kp_per_m = EMA_R(100.0);
    actuator.params.ki_per_m_s = EMA_R(100.0);
    const ema_pid_t pid = prepared();
    double integral = 0.0;
    double expected = 0.0;
    for (uint32_t k = 0; k < 40U; ++k) {
        const double command_mm = 0.125 * k;
        if ((k % 4U) == 0U) {
            expected = (100.0 * command_mm * 1.0e-3) + integral;
            integral += 4.0e-3 * 100.0 * command_mm * 1.0e-3;
        }
        EMA_ASSERT_CLOSE(expected, run(&pid, command_mm, 0.0), EMA_BY_PRECISION(1.0e-6, 1.0e-13), 0.0);
    }
}

static void test_derivative_uses_the_control_period(void)
{
    actuator.options.every_steps = 4;
    actuator.options.derivative = 1;
    actuator.params.kd_s_per_m = EMA_R(0.5);
    const ema_pid_t pid = prepared();
    double output = 0.0;
    for (uint32_t k = 0; k < 9U; ++k) {
        output = run(&pid, 0.0, 0.125 * k);
    }
    /* 0.5 mm in 4 ms */
    EMA_ASSERT_CLOSE(-0.5 * 0.125, output, 0.0, EMA_BY_PRECISION(1.0e-5, 1.0e-12));
}

static void test_short_form_equals_the_general_form_bit_for_bit(void)
{
    actuator.params.kp_per_m = EMA_R(400.0);
    actuator.params.ki_per_m_s = EMA_R(4000.0);
    actuator.params.anti_windup_per_s = EMA_R(50.0);
    const ema_pid_t pid = prepared();
    TEST_ASSERT_TRUE(pid.plain);
    ema_pid_t general = pid;
    general.plain = false;
    ema_state_t other = state;
    for (uint32_t k = 0; k < 2000U; ++k) {
        const ema_real command_mm = ema_rig_uniform(EMA_R(-4.0), EMA_R(4.0));
        const ema_real feedback_mm = ema_rig_uniform(EMA_R(-4.0), EMA_R(4.0));
        const ema_real a = ema_pid_step(&pid, &state, command_mm, feedback_mm);
        const ema_real b = ema_pid_step(&general, &other, command_mm, feedback_mm);
        EMA_ASSERT_SAME_BITS(&a, &b, sizeof a);
        EMA_ASSERT_SAME_BITS(&state.integral, &other.integral, sizeof state.integral);
        ++state.step;
        ++other.step;
    }
}

static void test_derivative_gain_takes_the_general_form(void)
{
    actuator.params.kd_s_per_m = EMA_R(0.1);
    TEST_ASSERT_FALSE(prepared().plain);
    actuator.params.kd_s_per_m = EMA_R(0.0);
    actuator.options.structure = 1;
    TEST_ASSERT_FALSE(prepared().plain);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_proportional_action_is_gain_times_error_in_metres);
    RUN_TEST(test_integral_action_follows_the_output);
    RUN_TEST(test_derivative_of_the_error_starts_at_zero);
    RUN_TEST(test_derivative_of_the_error_kicks_at_a_step_of_the_command);
    RUN_TEST(test_derivative_of_the_measured_speed_does_not_kick);
    RUN_TEST(test_derivative_of_the_measured_speed_brakes);
    RUN_TEST(test_averaged_speed_is_that_of_two_samples);
    RUN_TEST(test_output_saturates_at_its_limit);
    RUN_TEST(test_integral_winds_up_without_back_calculation);
    RUN_TEST(test_back_calculation_holds_the_integral);
    RUN_TEST(test_back_calculation_fades_with_its_gain);
    RUN_TEST(test_cascade_is_its_closed_form);
    RUN_TEST(test_cascade_limits_the_speed_it_asks_for);
    RUN_TEST(test_cascade_without_a_speed_limit_asks_for_any_speed);
    RUN_TEST(test_cascade_averages_its_speed);
    RUN_TEST(test_control_law_runs_at_its_own_rate);
    RUN_TEST(test_derivative_uses_the_control_period);
    RUN_TEST(test_short_form_equals_the_general_form_bit_for_bit);
    RUN_TEST(test_derivative_gain_takes_the_general_form);
    return UNITY_END();
}
