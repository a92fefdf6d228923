/* Encoder network: sides, sensor errors, resolution and the delay's parabola. */
#include <math.h>

#include "blocks/ema_encoder.h"
#include "ema_rig.h"

static ema_actuator_t actuator;
static ema_state_t state;

void setUp(void)
{
    const ema_state_t rest = {0};
    actuator = ema_rig_actuator();
    state = rest;
    ema_rig_seed(5U);
}

void tearDown(void)
{
}

static ema_encoder_t prepared(void)
{
    ema_encoder_t encoder;
    ema_encoder_prepare(&encoder, &actuator.params, &actuator.options);
    return encoder;
}

static double seen(const ema_encoder_t* encoder, double motor_mm, double rod_reading_mm)
{
    const ema_real value = ema_encoder_step(encoder, &state, (ema_real)motor_mm, (ema_real)rod_reading_mm);
    ++state.step;
    return (double)value;
}

static void test_loop_sees_the_chosen_side(void)
{
    const ema_encoder_t motor = prepared();
    TEST_ASSERT_TRUE(seen(&motor, 1.5, 2.5) == 1.5);
    actuator.options.side = 1;
    const ema_encoder_t rod = prepared();
    TEST_ASSERT_TRUE(seen(&rod, 1.5, 2.5) == 2.5);
}

static void test_rod_sensor_reads_with_gain_error_and_offset(void)
{
    actuator.params.rod_gain_error = EMA_R(0.0625);
    actuator.params.rod_offset_mm = EMA_R(0.25);
    const ema_encoder_t encoder = prepared();
    TEST_ASSERT_TRUE(ema_encoder_rod(&encoder, EMA_R(2.0)) == EMA_R(2.375));
    TEST_ASSERT_TRUE(ema_encoder_rod(&encoder, EMA_R(-2.0)) == EMA_R(-1.875));
}

static void test_rod_sensor_without_errors_is_exact(void)
{
    const ema_encoder_t encoder = prepared();
    for (uint32_t k = 0; k < 100U; ++k) {
        const ema_real rod_mm = ema_rig_uniform(EMA_R(-20.0), EMA_R(20.0));
        TEST_ASSERT_TRUE(ema_encoder_rod(&encoder, rod_mm) == rod_mm);
    }
}

static void test_resolution_rounds_to_the_nearest_multiple(void)
{
    actuator.params.resolution_mm = EMA_R(0.25);
    const ema_encoder_t encoder = prepared();
    TEST_ASSERT_TRUE(seen(&encoder, 1.12, 0.0) == 1.0);
    TEST_ASSERT_TRUE(seen(&encoder, 1.13, 0.0) == 1.25);
    TEST_ASSERT_TRUE(seen(&encoder, -1.12, 0.0) == -1.0);
    TEST_ASSERT_TRUE(seen(&encoder, -1.13, 0.0) == -1.25);
    double largest = 0.0;
    for (uint32_t k = 0; k < 10000U; ++k) {
        const double position_mm = (double)ema_rig_uniform(EMA_R(-5.0), EMA_R(5.0));
        const double value_mm = seen(&encoder, position_mm, 0.0);
        TEST_ASSERT_TRUE(fmod(value_mm, 0.25) == 0.0);
        largest = fmax(largest, fabs(value_mm - position_mm));
    }
    TEST_ASSERT_TRUE((largest <= 0.125) && (largest > 0.1245));
}

static void test_delay_of_whole_steps_gives_the_sample_itself(void)
{
    actuator.params.step_s = EMA_R(9.765625e-4);
    actuator.params.delay_s = EMA_R(3.0) * EMA_R(9.765625e-4);
    const ema_encoder_t encoder = prepared();
    ema_real sent[40];
    for (uint32_t k = 0; k < 40U; ++k) {
        sent[k] = ema_rig_uniform(EMA_R(-5.0), EMA_R(5.0));
        const double value_mm = seen(&encoder, (double)sent[k], 0.0);
        /* before the first step the samples hold the start: zero here */
        TEST_ASSERT_TRUE(value_mm == ((k < 3U) ? 0.0 : (double)sent[k - 3U]));
    }
}

static double parabola(double k)
{
    return 1.0 - (0.25 * k) + (0.015625 * k * k);
}

static void test_delay_between_steps_is_exact_on_a_parabola(void)
{
    const double steps[5] = {0.25, 0.5, 1.75, 6.3125, 11.9375};
    for (uint32_t d = 0; d < 5U; ++d) {
        const ema_state_t rest = {0};
        state = rest;
        actuator.params.step_s = EMA_R(9.765625e-4);
        actuator.params.delay_s = (ema_real)(steps[d] * 9.765625e-4);
        const ema_encoder_t encoder = prepared();
        for (uint32_t k = 0; k < 60U; ++k) {
            const double value_mm = seen(&encoder, parabola(k), 0.0);
            if (k >= 14U) {
                EMA_ASSERT_CLOSE(parabola(k - steps[d]), value_mm, 100.0 * EMA_EPS, 0.0);
            }
        }
    }
}

static void test_delay_leaves_a_constant_exact(void)
{
    actuator.params.delay_s = EMA_R(0.00537);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(1.2345));
    const ema_encoder_t* const encoder = &model.plant.encoder;
    for (uint32_t k = 0; k < 40U; ++k) {
        TEST_ASSERT_TRUE(ema_encoder_step(encoder, &model.state, EMA_R(1.2345), EMA_R(0.0)) == EMA_R(1.2345));
        ++model.state.step;
    }
}

static void test_longest_delay_is_read_from_the_kept_samples(void)
{
    actuator.params.step_s = EMA_R(1.0e-3);
    actuator.params.delay_s = EMA_R(0.012);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    const ema_encoder_t* const encoder = &model.plant.encoder;
    for (uint32_t k = 0; k < 60U; ++k) {
        const double value_mm = (double)ema_encoder_step(encoder, &model.state, (ema_real)parabola(k), EMA_R(0.0));
        if (k >= 14U) {
            EMA_ASSERT_CLOSE(parabola(k - 12.0), value_mm, 200.0 * EMA_EPS, 0.0);
        }
        ++model.state.step;
    }
}

static void test_delay_comes_before_resolution(void)
{
    actuator.params.step_s = EMA_R(9.765625e-4);
    actuator.params.delay_s = EMA_R(9.765625e-4);
    actuator.params.resolution_mm = EMA_R(0.5);
    const ema_encoder_t encoder = prepared();
    (void)seen(&encoder, 0.7, 0.0);
    TEST_ASSERT_TRUE(seen(&encoder, 9.0, 0.0) == 0.5);
}

static void test_delay_and_resolution_act_on_the_rod_sensor_too(void)
{
    actuator.options.side = 1;
    actuator.params.resolution_mm = EMA_R(0.5);
    const ema_encoder_t encoder = prepared();
    TEST_ASSERT_TRUE(seen(&encoder, 9.0, 1.2) == 1.0);
}

static void test_feedback_without_delay_and_resolution_keeps_nothing(void)
{
    const ema_encoder_t encoder = prepared();
    TEST_ASSERT_TRUE(encoder.plain);
    const ema_state_t before = state;
    (void)ema_encoder_step(&encoder, &state, EMA_R(3.0), EMA_R(0.0));
    EMA_ASSERT_SAME_BITS(&before, &state, sizeof before);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_loop_sees_the_chosen_side);
    RUN_TEST(test_rod_sensor_reads_with_gain_error_and_offset);
    RUN_TEST(test_rod_sensor_without_errors_is_exact);
    RUN_TEST(test_resolution_rounds_to_the_nearest_multiple);
    RUN_TEST(test_delay_of_whole_steps_gives_the_sample_itself);
    RUN_TEST(test_delay_between_steps_is_exact_on_a_parabola);
    RUN_TEST(test_delay_leaves_a_constant_exact);
    RUN_TEST(test_longest_delay_is_read_from_the_kept_samples);
    RUN_TEST(test_delay_comes_before_resolution);
    RUN_TEST(test_delay_and_resolution_act_on_the_rod_sensor_too);
    RUN_TEST(test_feedback_without_delay_and_resolution_keeps_nothing);
    return UNITY_END();
}
