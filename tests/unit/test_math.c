/* The module's own elementary functions against the C library in long double, over their whole stated range. */
#include <float.h>
#include <math.h>
#include <stdio.h>

#include "base/ema_math.h"
#include "ema_rig.h"

#define SWEEP 200000U

#define LONG(x) ((long double)(x))

/* Largest number of the build, and the range of exponents of its normal numbers. */
#define REAL_MAX EMA_BY_PRECISION((ema_real)FLT_MAX, (ema_real)DBL_MAX)
#define REAL_MIN_EXP EMA_BY_PRECISION(FLT_MIN_EXP, DBL_MIN_EXP)
#define REAL_MAX_EXP EMA_BY_PRECISION(FLT_MAX_EXP, DBL_MAX_EXP)

void setUp(void)
{
    ema_rig_seed(1U);
}

void tearDown(void)
{
}

static double larger(double a, double b)
{
    return (a > b) ? a : b;
}

/* A worst error of exactly zero over a long sweep would mean that nothing was compared. */
static void assert_worst(double worst, double bound, unsigned line)
{
    if (!(worst > 0.0) || !(worst < bound)) {
        char text[120];
        (void)snprintf(text, sizeof text, "worst error %.3g epsilon is not in (0, %g)", worst, bound);
        UNITY_TEST_FAIL(line, text);
    }
}

static void test_exp_is_within_3_units_in_the_last_place(void)
{
    double worst = 0.0;
    for (uint32_t k = 0; k < SWEEP; ++k) {
        const ema_real x =
            EMA_BY_PRECISION(ema_rig_uniform(EMA_R(-86.9), EMA_R(88.0)), ema_rig_uniform(EMA_R(-707.9), EMA_R(709.0)));
        const long double exact = expl(LONG(x));
        worst = larger(worst, (double)(fabsl(LONG(ema_exp(x)) - exact) / exact) / EMA_EPS);
    }
    assert_worst(worst, 3.0, __LINE__);
}

static void test_exp_near_zero_is_within_3_units_in_the_last_place(void)
{
    double worst = 0.0;
    for (uint32_t k = 0; k < SWEEP; ++k) {
        const ema_real x = ema_rig_uniform(EMA_R(-2.0), EMA_R(2.0));
        const long double exact = expl(LONG(x));
        worst = larger(worst, (double)(fabsl(LONG(ema_exp(x)) - exact) / exact) / EMA_EPS);
    }
    assert_worst(worst, 3.0, __LINE__);
}

static void test_exp_special_values(void)
{
    TEST_ASSERT_TRUE(ema_exp(EMA_R(0.0)) == EMA_R(1.0));
    TEST_ASSERT_TRUE(ema_exp(EMA_R(1.0e4)) == REAL_MAX);
    TEST_ASSERT_TRUE(ema_exp((ema_real)INFINITY) == REAL_MAX);
    TEST_ASSERT_TRUE(ema_exp(EMA_R(-1.0e4)) == EMA_R(0.0));
    TEST_ASSERT_TRUE(ema_exp((ema_real)-INFINITY) == EMA_R(0.0));
    const ema_real last = EMA_BY_PRECISION(EMA_R(88.0), EMA_R(709.0));
    TEST_ASSERT_TRUE(ema_exp(last) < REAL_MAX);
    TEST_ASSERT_TRUE(ema_exp(last + EMA_R(0.001)) == REAL_MAX);
}

static void test_log_is_within_3_units_in_the_last_place(void)
{
    double worst = 0.0;
    for (uint32_t k = 0; k < SWEEP; ++k) {
        const int exponent = (int)ema_rig_uniform((ema_real)REAL_MIN_EXP, (ema_real)REAL_MAX_EXP - EMA_R(1.0));
        const ema_real x = (ema_real)ldexp((double)ema_rig_uniform(EMA_R(1.0), EMA_R(2.0)), exponent);
        const long double exact = logl(LONG(x));
        const double scale = larger(1.0, (double)fabsl(exact));
        worst = larger(worst, ((double)fabsl(LONG(ema_log(x)) - exact) / scale) / EMA_EPS);
    }
    assert_worst(worst, 3.0, __LINE__);
}

static void test_log_near_one_is_within_3_epsilon(void)
{
    double worst = 0.0;
    for (uint32_t k = 0; k < SWEEP; ++k) {
        const ema_real x = ema_rig_uniform(EMA_R(0.4), EMA_R(2.1));
        worst = larger(worst, (double)fabsl(LONG(ema_log(x)) - logl(LONG(x))) / EMA_EPS);
    }
    assert_worst(worst, 3.0, __LINE__);
}

static void test_log_special_values(void)
{
    TEST_ASSERT_TRUE(ema_log(EMA_R(1.0)) == EMA_R(0.0));
    EMA_ASSERT_CLOSE(0.69314718055994531, ema_log(EMA_R(2.0)), 0.0, 2.0 * EMA_EPS);
    EMA_ASSERT_CLOSE((double)logl(LONG(REAL_MAX)), ema_log(REAL_MAX), 0.0, 3.0 * EMA_EPS);
}

static void test_log_undoes_exp(void)
{
    for (uint32_t k = 0; k < 1000U; ++k) {
        const ema_real x = ema_rig_uniform(EMA_R(-80.0), EMA_R(80.0));
        EMA_ASSERT_CLOSE(x, ema_log(ema_exp(x)), 4.0 * EMA_EPS, 6.0 * EMA_EPS);
    }
}

static void test_sine_is_within_2_epsilon_times_its_angle(void)
{
    double worst = 0.0;
    for (uint32_t k = 0; k < SWEEP; ++k) {
        const ema_real reach = ema_exp(ema_rig_uniform(EMA_R(-5.0), EMA_R(13.8)));
        const ema_real x = ema_rig_uniform(-reach, reach);
        const double error = (double)fabsl(LONG(ema_sin(x)) - sinl(LONG(x)));
        worst = larger(worst, error / (EMA_EPS * larger(1.0, fabs((double)x))));
    }
    assert_worst(worst, 2.0, __LINE__);
}

static void test_cosine_is_within_2_epsilon_times_its_angle(void)
{
    double worst = 0.0;
    for (uint32_t k = 0; k < SWEEP; ++k) {
        const ema_real reach = ema_exp(ema_rig_uniform(EMA_R(-5.0), EMA_R(13.8)));
        const ema_real x = ema_rig_uniform(-reach, reach);
        const double error = (double)fabsl(LONG(ema_cos(x)) - cosl(LONG(x)));
        worst = larger(worst, error / (EMA_EPS * larger(1.0, fabs((double)x))));
    }
    assert_worst(worst, 2.0, __LINE__);
}

static void test_sine_special_values(void)
{
    TEST_ASSERT_TRUE(ema_sin(EMA_R(0.0)) == EMA_R(0.0));
    EMA_ASSERT_CLOSE(1.0, ema_cos(EMA_R(0.0)), 2.0 * EMA_EPS, 0.0);
    EMA_ASSERT_CLOSE(1.0, ema_sin(EMA_R(1.5707963267948966)), 2.0 * EMA_EPS, 0.0);
    EMA_ASSERT_CLOSE(-1.0, ema_sin(EMA_R(-1.5707963267948966)), 2.0 * EMA_EPS, 0.0);
}

static void test_sine_of_a_phase_is_within_2_epsilon(void)
{
    double worst = 0.0;
    for (uint32_t k = 0; k < SWEEP; ++k) {
        const uint64_t phase = ((uint64_t)(uint32_t)ema_rig_uniform(EMA_R(0.0), EMA_R(4294967040.0)) << 32U)
                               + ((uint64_t)k * UINT64_C(21474));
        const long double angle = ldexpl((long double)phase, -64) * 6.283185307179586476925L;
        worst = larger(worst, (double)fabsl(LONG(ema_sin_turn64(phase)) - sinl(angle)) / EMA_EPS);
    }
    assert_worst(worst, 2.0, __LINE__);
}

/* The sine of a phase by the compiler's own conversion of the whole, and by a loop over all terms. */
static ema_real sine_converted(uint64_t phase)
{
    const uint64_t half = UINT64_C(1) << 63U;
    const bool negative = phase > half;
    uint64_t whole = negative ? (UINT64_C(0) - phase) : phase;
    whole = (whole > (half / 2U)) ? (half - whole) : whole;
    const ema_real size = (ema_real)whole;
    const ema_real x = (negative ? -size : size) * (EMA_R(1.5707963267948966) / EMA_R(4.611686018427387904e18));
    ema_real sum = EMA_R(1.0);
    for (uint32_t even = EMA_BY_PRECISION(12U, 20U); even > 0U; even -= 2U) {
        sum = EMA_R(1.0) - (sum * ((x * x) * (ema_inverse[even] * ema_inverse[even + 1U])));
    }
    return x * sum;
}

static void test_a_phase_is_rounded_as_a_conversion_rounds_it(void)
{
    const uint64_t quarter = UINT64_C(1) << 62U;
    uint64_t bits = UINT64_C(0x9e3779b97f4a7c15);
    for (uint32_t width = 0; width < 63U; ++width) {
        const uint64_t top = UINT64_C(1) << width;
        /* the first bit that a float of this width cannot hold: ties go to the even neighbour */
        const uint64_t half = top >> 24U;
        for (uint32_t trial = 0; trial < 500U; ++trial) {
            bits = (bits * UINT64_C(6364136223846793005)) + 1U;
            const uint64_t any = top | (bits >> (63U - width) >> 1U);
            const uint64_t tie = (half > 0U) ? ((any & ~((2U * half) - 1U)) | half) : any;
            const uint64_t tried[4] = {any, tie, tie + 1U, tie - 1U};
            for (uint32_t k = 0; k < 16U; ++k) {
                const uint64_t from = (uint64_t)(k / 4U) * quarter;
                const ema_real up = ema_sin_turn64(from + tried[k % 4U]);
                const ema_real down = ema_sin_turn64(from - tried[k % 4U]);
                const ema_real wanted[2] = {sine_converted(from + tried[k % 4U]), sine_converted(from - tried[k % 4U])};
                /* of a zero the sign too */
                TEST_ASSERT_EQUAL_MEMORY(&wanted[0], &up, sizeof up);
                TEST_ASSERT_EQUAL_MEMORY(&wanted[1], &down, sizeof down);
            }
        }
    }
}

static void test_sine_of_quarter_turns(void)
{
    const uint64_t quarter = UINT64_C(1) << 62U;
    TEST_ASSERT_TRUE(ema_sin_turn64(0U) == EMA_R(0.0));
    EMA_ASSERT_CLOSE(1.0, ema_sin_turn64(quarter), 2.0 * EMA_EPS, 0.0);
    EMA_ASSERT_CLOSE(0.0, ema_sin_turn64(2U * quarter), 2.0 * EMA_EPS, 0.0);
    EMA_ASSERT_CLOSE(-1.0, ema_sin_turn64(3U * quarter), 2.0 * EMA_EPS, 0.0);
    EMA_ASSERT_CLOSE(0.0, ema_sin_turn64(UINT64_MAX), 2.0 * EMA_EPS, 0.0);
    EMA_ASSERT_CLOSE(0.0, ema_sin_turn64((2U * quarter) - 1U), 2.0 * EMA_EPS, 0.0);
    EMA_ASSERT_CLOSE(1.0, ema_sin_turn64(quarter + 1U), 2.0 * EMA_EPS, 0.0);
    EMA_ASSERT_CLOSE(-1.0, ema_sin_turn64((3U * quarter) - 1U), 2.0 * EMA_EPS, 0.0);
}

static void test_sine_of_a_phase_is_odd(void)
{
    for (uint64_t phase = 1U; phase < (UINT64_C(1) << 63U); phase *= 3U) {
        TEST_ASSERT_TRUE(ema_sin_turn64(phase) == -ema_sin_turn64(UINT64_C(0) - phase));
        if (phase > (UINT64_MAX / 3U)) {
            break;
        }
    }
}

static void test_part_of_a_turn(void)
{
    const uint64_t half = UINT64_C(1) << 63U;
    TEST_ASSERT_TRUE(ema_turn64(EMA_R(0.0)) == 0U);
    TEST_ASSERT_TRUE(ema_turn64(EMA_R(0.5)) == half);
    TEST_ASSERT_TRUE(ema_turn64(EMA_R(0.25)) == (half / 2U));
    TEST_ASSERT_TRUE(ema_turn64(EMA_R(-0.25)) == (half + (half / 2U)));
    TEST_ASSERT_TRUE(ema_turn64(EMA_R(7.5)) == half);
    TEST_ASSERT_TRUE(ema_turn64(EMA_R(1.0)) == 0U);
    TEST_ASSERT_TRUE(ema_turn64(EMA_R(-3.0)) == 0U);
}

static void test_part_of_a_turn_keeps_the_bits(void)
{
    for (uint32_t k = 0; k < SWEEP; ++k) {
        const ema_real x = ema_rig_uniform(EMA_R(0.0), EMA_R(1.0));
        const long double exact = ldexpl(LONG(x), 64);
        const long double got = (long double)ema_turn64(x);
        /* the low half keeps what the number type has left below 2^-32 */
        EMA_ASSERT_CLOSE((double)(exact * 0x1p-64L), (double)(got * 0x1p-64L), 0x1p-55, 0.0);
    }
}

static void test_part_of_a_turn_just_below_one_does_not_wrap(void)
{
    const ema_real below = EMA_R(1.0) - (EMA_REAL_EPSILON / EMA_R(2.0));
    TEST_ASSERT_TRUE(ema_turn64(below) > (UINT64_MAX - (UINT64_C(1) << 41U)));
}

static void test_floor_equals_the_library(void)
{
    for (uint32_t k = 0; k < SWEEP; ++k) {
        const ema_real x =
            ema_rig_uniform(EMA_R(-100.0), EMA_R(100.0)) * ema_exp(ema_rig_uniform(EMA_R(0.0), EMA_R(25.0)));
        if (ema_abs(x) < EMA_R(2147483000.0)) {
            TEST_ASSERT_TRUE((double)ema_floor(x) == floor((double)x));
        } else {
            TEST_ASSERT_TRUE(ema_floor(x) == x);
        }
    }
}

static void test_floor_special_values(void)
{
    TEST_ASSERT_TRUE(ema_floor(EMA_R(-0.25)) == EMA_R(-1.0));
    TEST_ASSERT_TRUE(ema_floor(EMA_R(-3.0)) == EMA_R(-3.0));
    TEST_ASSERT_TRUE(ema_floor(EMA_R(3.0)) == EMA_R(3.0));
    TEST_ASSERT_TRUE(ema_floor(EMA_R(-4.0e9)) == EMA_R(-4.0e9));
    TEST_ASSERT_TRUE(isnan((double)ema_floor((ema_real)NAN)));
    TEST_ASSERT_TRUE(isinf((double)ema_floor((ema_real)INFINITY)));
}

static void test_finite_tells_nan_and_infinity(void)
{
    TEST_ASSERT_TRUE(ema_is_finite(EMA_R(0.0)));
    TEST_ASSERT_TRUE(ema_is_finite(REAL_MAX));
    TEST_ASSERT_TRUE(ema_is_finite(-REAL_MAX));
    TEST_ASSERT_FALSE(ema_is_finite((ema_real)NAN));
    TEST_ASSERT_FALSE(ema_is_finite((ema_real)INFINITY));
    TEST_ASSERT_FALSE(ema_is_finite((ema_real)-INFINITY));
}

static void test_absolute_least_greatest_clamp(void)
{
    TEST_ASSERT_TRUE(ema_abs(EMA_R(-2.5)) == EMA_R(2.5));
    TEST_ASSERT_TRUE(ema_abs(EMA_R(2.5)) == EMA_R(2.5));
    TEST_ASSERT_TRUE(ema_min(EMA_R(1.0), EMA_R(2.0)) == EMA_R(1.0));
    TEST_ASSERT_TRUE(ema_min(EMA_R(2.0), EMA_R(1.0)) == EMA_R(1.0));
    TEST_ASSERT_TRUE(ema_max(EMA_R(1.0), EMA_R(2.0)) == EMA_R(2.0));
    TEST_ASSERT_TRUE(ema_max(EMA_R(2.0), EMA_R(1.0)) == EMA_R(2.0));
    TEST_ASSERT_TRUE(ema_clamp(EMA_R(5.0), EMA_R(-1.0), EMA_R(1.0)) == EMA_R(1.0));
    TEST_ASSERT_TRUE(ema_clamp(EMA_R(-5.0), EMA_R(-1.0), EMA_R(1.0)) == EMA_R(-1.0));
    TEST_ASSERT_TRUE(ema_clamp(EMA_R(0.5), EMA_R(-1.0), EMA_R(1.0)) == EMA_R(0.5));
    TEST_ASSERT_TRUE(ema_is_finite(ema_clamp((ema_real)NAN, EMA_R(-1.0), EMA_R(1.0))));
}

static void test_square_root_is_correctly_rounded(void)
{
    for (uint32_t k = 0; k < 5000U; ++k) {
        const ema_real whole = ema_floor(ema_rig_uniform(EMA_R(1.0), EMA_R(4000.0)));
        TEST_ASSERT_TRUE(ema_sqrt(whole * whole) == whole);
        const ema_real x = ema_rig_uniform(EMA_R(0.0), EMA_R(1.0e6));
        TEST_ASSERT_TRUE(ema_sqrt(x) == (ema_real)sqrt((double)x));
    }
    TEST_ASSERT_TRUE(ema_sqrt(EMA_R(0.0)) == EMA_R(0.0));
}

static void test_compensated_sum_keeps_what_a_plain_sum_loses(void)
{
    const ema_real addend = EMA_BY_PRECISION(EMA_R(1.0e-6), EMA_R(1.0e-15));
    const uint32_t count = 100000U;
    ema_real high = EMA_R(2.0);
    ema_real low = EMA_R(0.0);
    ema_real plain = EMA_R(2.0);
    for (uint32_t k = 0; k < count; ++k) {
        ema_add_compensated(&high, &low, addend);
        plain += addend;
    }
    const double exact = (double)addend * (double)count;
    const double compensated_error = fabs((((double)high - 2.0) + (double)low) - exact);
    const double plain_error = fabs(((double)plain - 2.0) - exact);
    TEST_ASSERT_TRUE(compensated_error <= EMA_EPS);
    TEST_ASSERT_TRUE(plain_error > (100.0 * EMA_EPS));
}

static void test_compensated_sum_takes_an_addend_larger_than_the_total(void)
{
    ema_real high = EMA_REAL_EPSILON / EMA_R(4.0);
    ema_real low = EMA_R(0.0);
    ema_add_compensated(&high, &low, EMA_R(1.0));
    TEST_ASSERT_TRUE(high == EMA_R(1.0));
    TEST_ASSERT_TRUE(low == (EMA_REAL_EPSILON / EMA_R(4.0)));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_exp_is_within_3_units_in_the_last_place);
    RUN_TEST(test_exp_near_zero_is_within_3_units_in_the_last_place);
    RUN_TEST(test_exp_special_values);
    RUN_TEST(test_log_is_within_3_units_in_the_last_place);
    RUN_TEST(test_log_near_one_is_within_3_epsilon);
    RUN_TEST(test_log_special_values);
    RUN_TEST(test_log_undoes_exp);
    RUN_TEST(test_sine_is_within_2_epsilon_times_its_angle);
    RUN_TEST(test_cosine_is_within_2_epsilon_times_its_angle);
    RUN_TEST(test_sine_special_values);
    RUN_TEST(test_sine_of_a_phase_is_within_2_epsilon);
    RUN_TEST(test_a_phase_is_rounded_as_a_conversion_rounds_it);
    RUN_TEST(test_sine_of_quarter_turns);
    RUN_TEST(test_sine_of_a_phase_is_odd);
    RUN_TEST(test_part_of_a_turn);
    RUN_TEST(test_part_of_a_turn_keeps_the_bits);
    RUN_TEST(test_part_of_a_turn_just_below_one_does_not_wrap);
    RUN_TEST(test_floor_equals_the_library);
    RUN_TEST(test_floor_special_values);
    RUN_TEST(test_finite_tells_nan_and_infinity);
    RUN_TEST(test_absolute_least_greatest_clamp);
    RUN_TEST(test_square_root_is_correctly_rounded);
    RUN_TEST(test_compensated_sum_keeps_what_a_plain_sum_loses);
    RUN_TEST(test_compensated_sum_takes_an_addend_larger_than_the_total);
    return UNITY_END();
}
