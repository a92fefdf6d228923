/* Motion as a power series: against closed-form exponentials, a fine integration, and its roots. */
#include <math.h>

#include "ema_rig.h"
#include "plant/ema_series.h"

static ema_actuator_t actuator;

void setUp(void)
{
    actuator = ema_rig_actuator();
}

void tearDown(void)
{
}

static const ema_span_t at_rest = {.current_A = EMA_R(2.0),
                                   .input = EMA_R(12.0),
                                   .span_s = EMA_R(1.0e-3),
                                   .torque_gain_Nm_per_A = EMA_R(0.0612),
                                   .at_rest = true};
static const ema_span_t sliding = {.current_A = EMA_R(2.0),
                                   .speed_rad_s = EMA_R(50.0),
                                   .input = EMA_R(12.0),
                                   .torque_Nm = EMA_R(-0.138),
                                   .span_s = EMA_R(1.0e-3),
                                   .torque_gain_Nm_per_A = EMA_R(0.0612)};

static void test_current_at_rest_is_an_exponential(void)
{
    const ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    ema_series_t series;
    ema_real angle_rad[EMA_SERIES_TERMS + 1U];
    ema_series_build(&series, &model.plant, &model.plant.motor_circuit, &at_rest);
    ema_series_angle(&series, at_rest.span_s, angle_rad);
    const double final_A = 12.0 / 0.99;
    for (double at = 0.0; at <= 1.0; at += 0.0625) {
        const double expected = final_A + ((2.0 - final_A) * exp(-(0.99 / 8.0e-4) * 1.0e-3 * at));
        EMA_ASSERT_CLOSE(expected, ema_series_at(series.current_A, (ema_real)at), 0.0, 8.0 * EMA_EPS);
        TEST_ASSERT_TRUE(ema_series_at(series.speed_rad_s, (ema_real)at) == EMA_R(0.0));
        TEST_ASSERT_TRUE(ema_series_at(angle_rad, (ema_real)at) == EMA_R(0.0));
    }
}

static void test_sliding_without_back_emf_is_a_sum_of_exponentials(void)
{
    actuator.params.back_emf_V_s_per_rad = EMA_R(0.0);
    actuator.params.viscous_Nm_s_per_rad = EMA_R(0.03);
    const ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    ema_series_t series;
    ema_real angle_rad[EMA_SERIES_TERMS + 1U];
    ema_series_build(&series, &model.plant, &model.plant.motor_circuit, &sliding);
    ema_series_angle(&series, sliding.span_s, angle_rad);
    const double a = 0.99 / 8.0e-4; /* of the current */
    const double d = 0.03 / 6.0e-5; /* of the speed */
    const double final_A = 12.0 / 0.99;
    const double steady = ((0.0612 * final_A) - 0.138) / 0.03;
    const double shared = ((0.0612 * (2.0 - final_A)) / 6.0e-5) / (d - a);
    for (double at = 0.0; at <= 1.0; at += 0.125) {
        const double t = 1.0e-3 * at;
        const double own = 50.0 - steady - shared;
        EMA_ASSERT_CLOSE(final_A + ((2.0 - final_A) * exp(-a * t)), ema_series_at(series.current_A, (ema_real)at), 0.0,
                         16.0 * EMA_EPS);
        EMA_ASSERT_CLOSE(steady + (shared * exp(-a * t)) + (own * exp(-d * t)),
                         ema_series_at(series.speed_rad_s, (ema_real)at), 0.0, 16.0 * EMA_EPS);
        EMA_ASSERT_CLOSE((steady * t) - (shared * expm1(-a * t) / a) - (own * expm1(-d * t) / d),
                         ema_series_at(angle_rad, (ema_real)at), 4.0 * EMA_EPS, 16.0 * EMA_EPS);
    }
}

/* A referee that shares nothing with the series: Runge-Kutta at a thousandth of the span. */
static void integrate(const ema_span_t* span, double* current_A, double* speed_rad_s, double* angle_rad)
{
    const double h = (double)span->span_s / 1000.0;
    double y[3] = {(double)span->current_A, (double)span->speed_rad_s, 0.0};
    for (uint32_t n = 0; n < 1000U; ++n) {
        double slope[4][3];
        for (uint32_t stage = 0; stage < 4U; ++stage) {
            const double share = (stage == 0U) ? 0.0 : ((stage == 3U) ? 1.0 : 0.5);
            double at[3];
            for (uint32_t i = 0; i < 3U; ++i) {
                at[i] = y[i] + ((stage == 0U) ? 0.0 : (share * h * slope[stage - 1U][i]));
            }
            const double part = (n + share) / 1000.0;
            const double bubble = part * (1.0 - part);
            const double input_V =
                (double)span->input + ((double)span->input_rise * part) + ((double)span->input_bend * bubble);
            const double torque_Nm = (double)span->torque_Nm + ((double)span->torque_rise_Nm * part)
                                     + ((double)span->torque_bend_Nm * bubble)
                                     + ((double)span->torque_twist_Nm * bubble * ((2.0 * part) - 1.0));
            slope[stage][0] = span->current_held ? 0.0 : ((input_V - (0.99 * at[0]) - (0.0612 * at[1])) / 8.0e-4);
            slope[stage][1] = (((double)span->torque_gain_Nm_per_A * at[0]) - (1.0e-4 * at[1]) + torque_Nm) / 6.0e-5;
            slope[stage][2] = at[1];
        }
        for (uint32_t i = 0; i < 3U; ++i) {
            y[i] += (h / 6.0) * (slope[0][i] + (2.0 * slope[1][i]) + (2.0 * slope[2][i]) + slope[3][i]);
        }
    }
    *current_A = y[0];
    *speed_rad_s = y[1];
    *angle_rad = y[2];
}

static void assert_span(const ema_span_t* span, unsigned line)
{
    const ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    ema_series_t series;
    double current_A;
    double speed_rad_s;
    double angle_rad;
    ema_real terms[EMA_SERIES_TERMS + 1U];
    ema_series_build(&series, &model.plant, &model.plant.motor_circuit, span);
    ema_series_angle(&series, span->span_s, terms);
    integrate(span, &current_A, &speed_rad_s, &angle_rad);
    const double tolerance = EMA_BY_PRECISION(2.0e-6, 2.0e-13);
    ema_assert_close(current_A, (double)ema_series_at(series.current_A, EMA_R(1.0)), tolerance, tolerance, line);
    ema_assert_close(speed_rad_s, (double)ema_series_at(series.speed_rad_s, EMA_R(1.0)), tolerance, tolerance, line);
    ema_assert_close(angle_rad, (double)ema_series_at(terms, EMA_R(1.0)), tolerance, tolerance, line);
}

static void test_coupled_motion_equals_a_fine_integration(void)
{
    assert_span(&sliding, __LINE__);
}

static void test_rising_inputs_equal_a_fine_integration(void)
{
    ema_span_t span = sliding;
    span.input_rise = EMA_R(6.0);
    span.torque_rise_Nm = EMA_R(0.4);
    assert_span(&span, __LINE__);
}

static void test_held_current_equals_a_fine_integration(void)
{
    ema_span_t span = sliding;
    span.current_held = true;
    assert_span(&span, __LINE__);
}

static void test_saturated_torque_equals_a_fine_integration(void)
{
    ema_span_t span = sliding;
    span.torque_gain_Nm_per_A = EMA_R(0.0);
    span.torque_Nm = EMA_R(1.48);
    assert_span(&span, __LINE__);
}

static void test_shorter_span_equals_a_fine_integration(void)
{
    ema_span_t span = sliding;
    span.span_s = EMA_R(3.7e-4);
    assert_span(&span, __LINE__);
}

static void test_circuit_without_inductance_follows_speed_and_input(void)
{
    actuator.params.inductance_H = EMA_R(0.0);
    const ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    ema_span_t span = sliding;
    ema_series_t series;
    span.input_rise = EMA_R(6.0);
    ema_series_build(&series, &model.plant, &model.plant.motor_circuit, &span);
    const double damping = 1.0e-4 + ((0.0612 * 0.0612) / 0.99);
    const double rate = damping / 6.0e-5;
    const double steady = ((0.0612 * 12.0 / 0.99) - 0.138) / damping;
    const double slope = (0.0612 * 6.0 / 0.99) / damping; /* of the speed that the rising input leads to, per span */
    for (double at = 0.0; at <= 1.0; at += 0.125) {
        const double t = 1.0e-3 * at;
        const double lag = slope / (rate * 1.0e-3);
        const double speed = steady + (slope * at) - lag + ((50.0 - steady + lag) * exp(-rate * t));
        EMA_ASSERT_CLOSE(speed, ema_series_at(series.speed_rad_s, (ema_real)at), 0.0, 64.0 * EMA_EPS);
        EMA_ASSERT_CLOSE((12.0 + (6.0 * at) - (0.0612 * speed)) / 0.99, ema_series_at(series.current_A, (ema_real)at),
                         0.0, 64.0 * EMA_EPS);
    }
}

static void test_motion_under_polynomials_equals_a_fine_integration(void)
{
    ema_span_t span = sliding;
    span.input_rise = EMA_R(6.0);
    span.input_bend = EMA_R(5.0);
    span.torque_rise_Nm = EMA_R(-0.3);
    span.torque_bend_Nm = EMA_R(0.8);
    span.torque_twist_Nm = EMA_R(-0.9);
    assert_span(&span, __LINE__);
}

static void test_prepared_responses_are_the_series_at_its_end(void)
{
    /* an effect for which a whole step is tried, with bend and twist */
    actuator.effects.cogging_torque.amplitude_Nm = EMA_R(0.01);
    const ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    const ema_responses_t* const responses = &model.plant.responses[1];
    TEST_ASSERT_TRUE(model.plant.tries_whole_step);
    ema_span_t span = sliding;
    span.input_rise = EMA_R(6.0);
    span.input_bend = EMA_R(5.0);
    span.torque_rise_Nm = EMA_R(0.4);
    span.torque_bend_Nm = EMA_R(0.8);
    span.torque_twist_Nm = EMA_R(-0.9);
    ema_series_t series;
    ema_real angle_rad[EMA_SERIES_TERMS + 1U];
    ema_series_build(&series, &model.plant, &model.plant.motor_circuit, &span);
    ema_series_angle(&series, span.span_s, angle_rad);
    const ema_response_t* const rows[3] = {&responses->current, &responses->speed, &responses->angle};
    const ema_real* const terms[3] = {series.current_A, series.speed_rad_s, angle_rad};
    for (uint32_t k = 0; k < 3U; ++k) {
        const double sum = (2.0 * (double)rows[k]->from_current) + (50.0 * (double)rows[k]->from_speed)
                           + (12.0 * (double)rows[k]->from_voltage) - (0.138 * (double)rows[k]->from_torque)
                           + (6.0 * (double)rows[k]->from_voltage_rise) + (0.4 * (double)rows[k]->from_torque_rise)
                           + (5.0 * (double)rows[k]->from_voltage_bend) + (0.8 * (double)rows[k]->from_torque_bend)
                           - (0.9 * (double)rows[k]->from_torque_twist);
        EMA_ASSERT_CLOSE(ema_series_at(terms[k], EMA_R(1.0)), sum, 4.0 * EMA_EPS, 32.0 * EMA_EPS);
    }
}

static void test_prepared_response_at_rest_is_an_exponential(void)
{
    const ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    const double fade = exp(-(0.99 / 8.0e-4) * 1.0e-3);
    EMA_ASSERT_CLOSE(fade, model.plant.responses[0].stuck_from_current, 8.0 * EMA_EPS, 0.0);
    EMA_ASSERT_CLOSE((1.0 - fade) / 0.99, model.plant.responses[0].stuck_from_voltage, 8.0 * EMA_EPS, 0.0);
}

/* Sets the first terms of a series; the others are zero. */
static void polynomial(ema_real* terms, double c0, double c1, double c2, double c3)
{
    for (uint32_t k = 0; k <= EMA_SERIES_TERMS; ++k) {
        terms[k] = EMA_R(0.0);
    }
    terms[0] = (ema_real)c0;
    terms[1] = (ema_real)c1;
    terms[2] = (ema_real)c2;
    terms[3] = (ema_real)c3;
}

static void test_root_of_a_line(void)
{
    ema_real terms[EMA_SERIES_TERMS + 1U];
    polynomial(terms, -0.3, 1.0, 0.0, 0.0);
    EMA_ASSERT_CLOSE(0.3, ema_series_root(terms, EMA_R(0.0)), 2.0 * EMA_EPS, 0.0);
    polynomial(terms, 0.3, -1.0, 0.0, 0.0);
    EMA_ASSERT_CLOSE(0.3, ema_series_root(terms, EMA_R(0.0)), 2.0 * EMA_EPS, 0.0);
}

static void test_root_of_curved_series(void)
{
    ema_real terms[EMA_SERIES_TERMS + 1U];
    polynomial(terms, -0.5, 0.0, 1.0, 0.0);
    EMA_ASSERT_CLOSE(sqrt(0.5), ema_series_root(terms, EMA_R(0.0)), 4.0 * EMA_EPS, 0.0);
    polynomial(terms, -0.001, 0.0, 0.0, 1.0);
    EMA_ASSERT_CLOSE(0.1, ema_series_root(terms, EMA_R(0.0)), EMA_BY_PRECISION(2.0e-6, 2.0e-6), 0.0);
    /* (x - 0.6) (x^2 + x + 1) */
    polynomial(terms, -0.6, 0.4, 0.4, 1.0);
    EMA_ASSERT_CLOSE(0.6, ema_series_root(terms, EMA_R(0.0)), 4.0 * EMA_EPS, 0.0);
}

static void test_root_is_sought_behind_the_lower_end(void)
{
    ema_real terms[EMA_SERIES_TERMS + 1U];
    /* x (x - 0.4): zero at 0, where the span starts, and at 0.4 */
    polynomial(terms, 0.0, -0.4, 1.0, 0.0);
    EMA_ASSERT_CLOSE(0.4, ema_series_root(terms, EMA_R(0.0625)), 4.0 * EMA_EPS, 0.0);
}

static void test_root_at_the_end_of_the_span(void)
{
    ema_real terms[EMA_SERIES_TERMS + 1U];
    polynomial(terms, -1.0, 1.0, 0.0, 0.0);
    TEST_ASSERT_TRUE(ema_series_root(terms, EMA_R(0.0)) == EMA_R(1.0));
    polynomial(terms, 1.0, -1.0, 0.0, 0.0);
    TEST_ASSERT_TRUE(ema_series_root(terms, EMA_R(0.0)) == EMA_R(1.0));
}

static void test_root_stays_inside_the_bracket_for_nan(void)
{
    ema_real terms[EMA_SERIES_TERMS + 1U];
    polynomial(terms, (double)NAN, 1.0, 0.0, 0.0);
    const ema_real root = ema_series_root(terms, EMA_R(0.25));
    TEST_ASSERT_TRUE((root >= EMA_R(0.25)) && (root <= EMA_R(1.0)));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_current_at_rest_is_an_exponential);
    RUN_TEST(test_sliding_without_back_emf_is_a_sum_of_exponentials);
    RUN_TEST(test_coupled_motion_equals_a_fine_integration);
    RUN_TEST(test_rising_inputs_equal_a_fine_integration);
    RUN_TEST(test_held_current_equals_a_fine_integration);
    RUN_TEST(test_saturated_torque_equals_a_fine_integration);
    RUN_TEST(test_shorter_span_equals_a_fine_integration);
    RUN_TEST(test_circuit_without_inductance_follows_speed_and_input);
    RUN_TEST(test_motion_under_polynomials_equals_a_fine_integration);
    RUN_TEST(test_prepared_responses_are_the_series_at_its_end);
    RUN_TEST(test_prepared_response_at_rest_is_an_exponential);
    RUN_TEST(test_root_of_a_line);
    RUN_TEST(test_root_of_curved_series);
    RUN_TEST(test_root_is_sought_behind_the_lower_end);
    RUN_TEST(test_root_at_the_end_of_the_span);
    RUN_TEST(test_root_stays_inside_the_bracket_for_nan);
    return UNITY_END();
}
