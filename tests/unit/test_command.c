/* Commands against their closed forms; what is refused; and that they are functions of the step alone. */
#include <math.h>

#include "ema/ema.h"
#include "ema_rig.h"

#define STEP_S EMA_R(1.0e-3)
#define TURN 6.283185307179586476925
#define MANY 20001U

void setUp(void)
{
}

void tearDown(void)
{
}

/* A legal configuration of each kind. */
static const ema_real recorded_mm[5] = {EMA_R(0.5), EMA_R(-0.25), EMA_R(3.0), EMA_R(2.0), EMA_R(-1.0)};
static const ema_command_config_t chirp = {.kind = EMA_COMMAND_CHIRP,
                                           .amplitude_mm = EMA_R(2.0),
                                           .start_hz = EMA_R(0.1),
                                           .end_hz = EMA_R(4.0),
                                           .duration_s = EMA_R(10.0)};
static const ema_command_config_t multisine = {
    .kind = EMA_COMMAND_MULTISINE, .amplitude_mm = EMA_R(2.0), .start_hz = EMA_R(0.5), .count = 7U};
static const ema_command_config_t triangle = {
    .kind = EMA_COMMAND_TRIANGLE, .amplitude_mm = EMA_R(3.0), .start_hz = EMA_R(1.25)};
static const ema_command_config_t trapezoid = {
    .kind = EMA_COMMAND_TRAPEZOID, .amplitude_mm = EMA_R(3.0), .start_hz = EMA_R(1.25), .share = EMA_R(0.4)};
static const ema_command_config_t step = {.kind = EMA_COMMAND_STEP, .amplitude_mm = EMA_R(-2.5), .time_s = EMA_R(0.25)};
static const ema_command_config_t record = {.kind = EMA_COMMAND_RECORD, .samples_mm = recorded_mm, .count = 5U};

static ema_command_t made(const ema_command_config_t* config)
{
    ema_command_t command;
    EMA_ASSERT_STATUS(EMA_OK, ema_command_init(&command, config, STEP_S));
    return command;
}

/* A refused configuration must leave the command as it was. */
static void assert_refused(ema_status_t expected, const ema_command_config_t* config, ema_real step_s, unsigned line)
{
    ema_command_t command;
    (void)memset(&command, 0x5A, sizeof command);
    const ema_command_t before = command;
    ema_assert_status(expected, ema_command_init(&command, config, step_s), line);
    ema_assert_same_bits(&before, &command, sizeof before, line);
}

#define ASSERT_REFUSED(expected, config, step_s) assert_refused((expected), (config), (step_s), (unsigned)__LINE__)

static double chirp_at(double amplitude, double start_hz, double end_hz, double duration_s, double time_s)
{
    const double t = (time_s < duration_s) ? time_s : duration_s;
    return amplitude * sin(TURN * ((start_hz * t) + (((end_hz - start_hz) * t * t) / (2.0 * duration_s))));
}

static void assert_chirp(double start_hz, double end_hz, double duration_s, unsigned line)
{
    const ema_command_config_t config = {.kind = EMA_COMMAND_CHIRP,
                                         .amplitude_mm = EMA_R(2.0),
                                         .start_hz = (ema_real)start_hz,
                                         .end_hz = (ema_real)end_hz,
                                         .duration_s = (ema_real)duration_s};
    const ema_command_t command = made(&config);
    const uint32_t steps = (uint32_t)lround(duration_s * 1000.0);
    /* what rounding of the two frequencies does to the phase, in turns, and the last bit of a sine of 2 */
    const double turns = (0.5 * (start_hz + end_hz) * duration_s) + 1.0;
    const double allowed = 2.0 * ((TURN * turns * EMA_BY_PRECISION(2.0e-7, 1.0e-12)) + (4.0 * EMA_EPS));
    for (uint32_t k = 0; k <= (steps + 50U); ++k) {
        ema_assert_close(chirp_at(2.0, start_hz, end_hz, duration_s, (double)k * 1.0e-3),
                         (double)ema_command_at(&command, k), allowed, 0.0, line);
    }
}

static void test_reference_chirp_is_its_closed_form(void)
{
    assert_chirp(0.1, 4.0, 10.0, __LINE__);
}

static void test_fast_chirps_are_their_closed_form(void)
{
    assert_chirp(0.1, 20.0, 10.0, __LINE__);
    assert_chirp(2.0, 50.0, 2.0, __LINE__);
    assert_chirp(0.0, 400.0, 0.05, __LINE__);
}

static void test_falling_chirps_are_their_closed_form(void)
{
    assert_chirp(4.0, 0.1, 10.0, __LINE__);
    assert_chirp(100.0, 1.0, 1.0, __LINE__);
}

static void test_chirp_without_sweep_is_a_sine(void)
{
    assert_chirp(3.0, 3.0, 1.0, __LINE__);
}

static void test_chirp_holds_its_last_value(void)
{
    const ema_command_t command = made(&chirp);
    const ema_real last = ema_command_at(&command, 10000U);
    TEST_ASSERT_TRUE(ema_command_at(&command, 10001U) == last);
    TEST_ASSERT_TRUE(ema_command_at(&command, UINT32_MAX) == last);
    TEST_ASSERT_FALSE(ema_command_at(&command, 9999U) == last);
}

static void test_multisine_is_its_closed_form(void)
{
    const ema_command_t command = made(&multisine);
    for (uint32_t k = 0; k < 4000U; ++k) {
        double expected = 0.0;
        for (int m = 1; m <= 7; ++m) {
            const double phase = -(TURN / 2.0) * m * (m - 1) / 7.0;
            expected += sin((TURN * m * 0.5 * k * 1.0e-3) + phase) - sin(phase);
        }
        EMA_ASSERT_CLOSE((2.0 / sqrt(7.0)) * expected, ema_command_at(&command, k), EMA_BY_PRECISION(3.0e-5, 1.0e-12),
                         0.0);
    }
}

static void test_multisine_repeats_after_its_base_period(void)
{
    const ema_command_config_t config = {
        .kind = EMA_COMMAND_MULTISINE, .amplitude_mm = EMA_R(1.0), .start_hz = EMA_R(0.5), .count = 32U};
    const ema_command_t command = made(&config);
    for (uint32_t k = 0; k < 2000U; ++k) {
        /* a period of 2000 steps; the phase of the 32nd line moves by 32 roundings of the base */
        EMA_ASSERT_CLOSE(ema_command_at(&command, k), ema_command_at(&command, k + 2000U),
                         EMA_BY_PRECISION(1.0e-4, 1.0e-11), 0.0);
    }
}

static void test_multisine_of_schroeder_phases_is_flatter_than_aligned_lines(void)
{
    const ema_command_config_t config = {
        .kind = EMA_COMMAND_MULTISINE, .amplitude_mm = EMA_R(1.0), .start_hz = EMA_R(0.5), .count = 32U};
    const ema_command_t command = made(&config);
    ema_real least = EMA_R(0.0);
    ema_real most = EMA_R(0.0);
    for (uint32_t k = 0; k < 2000U; ++k) {
        const ema_real value = ema_command_at(&command, k);
        least = (value < least) ? value : least;
        most = (value > most) ? value : most;
    }
    /* rms amplitude 1/sqrt(2) each way; aligned lines would reach sqrt(32) */
    TEST_ASSERT_TRUE((most - least) > EMA_R(2.0));
    TEST_ASSERT_TRUE((most - least) < EMA_R(4.0));
}

static double ramp(double turn)
{
    const double part = turn - floor(turn);
    double value = 4.0 * part;
    if (part > 0.75) {
        value = (4.0 * part) - 4.0;
    } else if (part > 0.25) {
        value = 2.0 - (4.0 * part);
    }
    return value;
}

static void test_triangle_is_its_closed_form(void)
{
    const ema_command_t command = made(&triangle);
    for (uint32_t k = 0; k < 4000U; ++k) {
        EMA_ASSERT_CLOSE(3.0 * ramp(1.25e-3 * k), ema_command_at(&command, k), EMA_BY_PRECISION(1.0e-5, 3.0e-8), 0.0);
    }
    EMA_ASSERT_CLOSE(3.0, ema_command_at(&command, 200U), EMA_BY_PRECISION(1.0e-5, 3.0e-8), 0.0);
    EMA_ASSERT_CLOSE(-3.0, ema_command_at(&command, 600U), EMA_BY_PRECISION(1.0e-5, 3.0e-8), 0.0);
}

static void test_trapezoid_ramps_for_its_share_and_holds(void)
{
    const ema_command_t command = made(&trapezoid);
    uint32_t held = 0U;
    for (uint32_t k = 0; k < 4000U; ++k) {
        const double expected = 3.0 * fmax(-1.0, fmin(1.0, ramp(1.25e-3 * k) / 0.4));
        EMA_ASSERT_CLOSE(expected, ema_command_at(&command, k), EMA_BY_PRECISION(4.0e-5, 8.0e-8), 0.0);
        held += (fabs((double)ema_command_at(&command, k)) == 3.0) ? 1U : 0U;
    }
    /* 60 % of the time, up to the steps on a corner */
    TEST_ASSERT_UINT32_WITHIN(20U, 2400U, held);
}

static void test_trapezoid_of_share_one_is_the_triangle(void)
{
    ema_command_config_t whole = trapezoid;
    whole.share = EMA_R(1.0);
    const ema_command_t a = made(&whole);
    const ema_command_t b = made(&triangle);
    for (uint32_t k = 0; k < 1000U; ++k) {
        TEST_ASSERT_TRUE(ema_command_at(&a, k) == ema_command_at(&b, k));
    }
}

static void test_step_changes_at_its_instant(void)
{
    const ema_command_t command = made(&step);
    TEST_ASSERT_TRUE(ema_command_at(&command, 0U) == EMA_R(0.0));
    TEST_ASSERT_TRUE(ema_command_at(&command, 249U) == EMA_R(0.0));
    TEST_ASSERT_TRUE(ema_command_at(&command, 250U) == EMA_R(-2.5));
    TEST_ASSERT_TRUE(ema_command_at(&command, UINT32_MAX) == EMA_R(-2.5));
    ema_command_config_t at_once = step;
    at_once.time_s = EMA_R(0.0);
    const ema_command_t now = made(&at_once);
    TEST_ASSERT_TRUE(ema_command_at(&now, 0U) == EMA_R(-2.5));
}

static void test_record_gives_its_samples_and_holds_the_last(void)
{
    const ema_command_t command = made(&record);
    for (uint32_t k = 0; k < 5U; ++k) {
        TEST_ASSERT_TRUE(ema_command_at(&command, k) == recorded_mm[k]);
    }
    TEST_ASSERT_TRUE(ema_command_at(&command, 5U) == recorded_mm[4]);
    TEST_ASSERT_TRUE(ema_command_at(&command, UINT32_MAX) == recorded_mm[4]);
}

static void test_functions_of_time_start_at_zero(void)
{
    const ema_command_config_t* const configs[4] = {&chirp, &multisine, &triangle, &trapezoid};
    for (size_t k = 0; k < 4U; ++k) {
        const ema_command_t command = made(configs[k]);
        TEST_ASSERT_TRUE(ema_command_at(&command, 0U) == EMA_R(0.0));
    }
}

static void test_order_of_asking_changes_no_bit(void)
{
    static ema_real forward[MANY];
    const ema_command_config_t* const configs[6] = {&chirp, &multisine, &triangle, &trapezoid, &step, &record};
    for (size_t c = 0; c < 6U; ++c) {
        const ema_command_t command = made(configs[c]);
        const ema_command_t before = command;
        for (uint32_t k = 0; k < MANY; ++k) {
            forward[k] = ema_command_at(&command, k);
        }
        for (uint32_t k = 0; k < MANY; ++k) {
            /* a prime that does not divide MANY: every step is asked once, far from its neighbours */
            const uint32_t at = (uint32_t)((7919ULL * k) % MANY);
            const ema_real again = ema_command_at(&command, at);
            EMA_ASSERT_SAME_BITS(&forward[at], &again, sizeof again);
        }
        EMA_ASSERT_SAME_BITS(&before, &command, sizeof before);
    }
}

static void test_init_needs_its_pointers(void)
{
    ema_command_t command;
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_command_init(NULL, &chirp, STEP_S));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_command_init(&command, NULL, STEP_S));
    ema_command_config_t bad = record;
    bad.samples_mm = NULL;
    ASSERT_REFUSED(EMA_ERR_NULL, &bad, STEP_S);
}

static void test_step_period_out_of_range_is_refused(void)
{
    const ema_real bad[4] = {EMA_R(0.0), EMA_R(-1.0e-3), (ema_real)NAN, (ema_real)INFINITY};
    for (size_t k = 0; k < 4U; ++k) {
        ASSERT_REFUSED(EMA_ERR_RANGE, &chirp, bad[k]);
    }
}

static void test_amplitude_that_is_not_finite_is_refused(void)
{
    const ema_command_config_t* const configs[5] = {&chirp, &multisine, &triangle, &trapezoid, &step};
    const ema_real values[2] = {(ema_real)NAN, (ema_real)INFINITY};
    for (size_t k = 0; k < 5U; ++k) {
        for (size_t v = 0; v < 2U; ++v) {
            ema_command_config_t bad = *configs[k];
            bad.amplitude_mm = values[v];
            ASSERT_REFUSED(EMA_ERR_NOT_FINITE, &bad, STEP_S);
        }
    }
}

static void test_frequency_out_of_range_is_refused(void)
{
    const ema_command_config_t* const configs[4] = {&chirp, &multisine, &triangle, &trapezoid};
    const ema_real values[4] = {EMA_R(-0.1), EMA_R(500.5), (ema_real)NAN, (ema_real)INFINITY};
    for (size_t k = 0; k < 4U; ++k) {
        for (size_t v = 0; v < 4U; ++v) {
            ema_command_config_t bad = *configs[k];
            bad.start_hz = values[v];
            ASSERT_REFUSED(EMA_ERR_RANGE, &bad, STEP_S);
        }
    }
    for (size_t v = 0; v < 4U; ++v) {
        ema_command_config_t bad = chirp;
        bad.end_hz = values[v];
        ASSERT_REFUSED(EMA_ERR_RANGE, &bad, STEP_S);
    }
}

static void test_frequency_up_to_half_the_step_rate_is_accepted(void)
{
    ema_command_config_t fast = chirp;
    fast.start_hz = EMA_R(499.0);
    fast.end_hz = EMA_R(0.0);
    (void)made(&fast);
    fast = triangle;
    fast.start_hz = EMA_R(0.0);
    (void)made(&fast);
}

static void test_multisine_line_above_half_the_step_rate_is_refused(void)
{
    ema_command_config_t config = multisine;
    config.start_hz = EMA_R(71.0);
    (void)made(&config);
    config.start_hz = EMA_R(72.0);
    ASSERT_REFUSED(EMA_ERR_RANGE, &config, STEP_S);
}

static void test_chirp_duration_out_of_range_is_refused(void)
{
    const ema_real values[5] = {EMA_R(0.0), EMA_R(0.5e-3), EMA_R(-1.0), EMA_R(3.0e6), (ema_real)NAN};
    for (size_t v = 0; v < 5U; ++v) {
        ema_command_config_t bad = chirp;
        bad.duration_s = values[v];
        ASSERT_REFUSED(EMA_ERR_RANGE, &bad, STEP_S);
    }
    ema_command_config_t shortest = chirp;
    shortest.duration_s = EMA_R(1.5e-3);
    (void)made(&shortest);
}

static void test_step_instant_out_of_range_is_refused(void)
{
    const ema_real values[3] = {EMA_R(-1.0e-3), EMA_R(3.0e6), (ema_real)NAN};
    for (size_t v = 0; v < 3U; ++v) {
        ema_command_config_t bad = step;
        bad.time_s = values[v];
        ASSERT_REFUSED(EMA_ERR_RANGE, &bad, STEP_S);
    }
}

static void test_trapezoid_share_out_of_range_is_refused(void)
{
    const ema_real values[4] = {EMA_R(0.0), EMA_R(-0.5), EMA_R(1.001), (ema_real)NAN};
    for (size_t v = 0; v < 4U; ++v) {
        ema_command_config_t bad = trapezoid;
        bad.share = values[v];
        ASSERT_REFUSED(EMA_ERR_RANGE, &bad, STEP_S);
    }
}

static void test_count_out_of_range_is_refused(void)
{
    ema_command_config_t bad = multisine;
    bad.count = 0U;
    ASSERT_REFUSED(EMA_ERR_RANGE, &bad, STEP_S);
    bad.count = 33U;
    ASSERT_REFUSED(EMA_ERR_RANGE, &bad, STEP_S);
    bad = record;
    bad.count = 0U;
    ASSERT_REFUSED(EMA_ERR_RANGE, &bad, STEP_S);
}

static void test_kind_outside_the_list_is_refused(void)
{
    ema_command_config_t bad = chirp;
    bad.kind = (ema_command_kind_t)6;
    ASSERT_REFUSED(EMA_ERR_RANGE, &bad, STEP_S);
}

static void test_command_of_no_kind_is_zero(void)
{
    ema_command_t command = made(&step);
    command.config.kind = (ema_command_kind_t)6;
    TEST_ASSERT_TRUE(ema_command_at(&command, 1000U) == EMA_R(0.0));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_reference_chirp_is_its_closed_form);
    RUN_TEST(test_fast_chirps_are_their_closed_form);
    RUN_TEST(test_falling_chirps_are_their_closed_form);
    RUN_TEST(test_chirp_without_sweep_is_a_sine);
    RUN_TEST(test_chirp_holds_its_last_value);
    RUN_TEST(test_multisine_is_its_closed_form);
    RUN_TEST(test_multisine_repeats_after_its_base_period);
    RUN_TEST(test_multisine_of_schroeder_phases_is_flatter_than_aligned_lines);
    RUN_TEST(test_triangle_is_its_closed_form);
    RUN_TEST(test_trapezoid_ramps_for_its_share_and_holds);
    RUN_TEST(test_trapezoid_of_share_one_is_the_triangle);
    RUN_TEST(test_step_changes_at_its_instant);
    RUN_TEST(test_record_gives_its_samples_and_holds_the_last);
    RUN_TEST(test_functions_of_time_start_at_zero);
    RUN_TEST(test_order_of_asking_changes_no_bit);
    RUN_TEST(test_init_needs_its_pointers);
    RUN_TEST(test_step_period_out_of_range_is_refused);
    RUN_TEST(test_amplitude_that_is_not_finite_is_refused);
    RUN_TEST(test_frequency_out_of_range_is_refused);
    RUN_TEST(test_frequency_up_to_half_the_step_rate_is_accepted);
    RUN_TEST(test_multisine_line_above_half_the_step_rate_is_refused);
    RUN_TEST(test_chirp_duration_out_of_range_is_refused);
    RUN_TEST(test_step_instant_out_of_range_is_refused);
    RUN_TEST(test_trapezoid_share_out_of_range_is_refused);
    RUN_TEST(test_count_out_of_range_is_refused);
    RUN_TEST(test_kind_outside_the_list_is_refused);
    RUN_TEST(test_command_of_no_kind_is_zero);
    return UNITY_END();
}
