/* The comparator's own tests: what it must refuse matters more than what it accepts. */
#include <math.h>

#include "ema_close.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void test_scalar_within_and_beyond_tolerance(void)
{
    TEST_ASSERT_TRUE(ema_close(1.0, 1.0, 0.0, 0.0));
    TEST_ASSERT_TRUE(ema_close(2.0, 2.5, 0.5, 0.0));
    TEST_ASSERT_FALSE(ema_close(2.0, 2.5, 0.4999, 0.0));
    TEST_ASSERT_TRUE(ema_close(-2.0, -2.5, 0.0, 0.25));
    TEST_ASSERT_FALSE(ema_close(-2.0, -2.5, 0.0, 0.2499));
    TEST_ASSERT_TRUE(ema_close(-2.0, -2.5, 0.25, 0.125));
}

static void test_zero_has_no_relative_tolerance(void)
{
    TEST_ASSERT_TRUE(ema_close(0.0, 0.0, 0.0, 0.0));
    TEST_ASSERT_TRUE(ema_close(0.0, -0.0, 0.0, 0.0));
    TEST_ASSERT_FALSE(ema_close(0.0, 1.0e-30, 0.0, 1.0));
    TEST_ASSERT_TRUE(ema_close(0.0, 1.0e-30, 1.0e-29, 0.0));
}

static void test_not_finite_is_close_to_nothing(void)
{
    const double nan_value = (double)NAN;
    const double infinite = (double)INFINITY;
    TEST_ASSERT_FALSE(ema_close(nan_value, nan_value, 1.0, 1.0));
    TEST_ASSERT_FALSE(ema_close(1.0, nan_value, 1.0, 1.0));
    TEST_ASSERT_FALSE(ema_close(nan_value, 1.0, 1.0, 1.0));
    TEST_ASSERT_FALSE(ema_close(infinite, infinite, 1.0, 1.0));
    TEST_ASSERT_FALSE(ema_close(-infinite, infinite, 1.0, 1.0));
    TEST_ASSERT_FALSE(ema_close(infinite, 1.0, 1.0, 1.0));
    TEST_ASSERT_FALSE(ema_close(1.0, infinite, 1.0, 1.0));
}

static void test_bad_tolerance_accepts_nothing(void)
{
    TEST_ASSERT_FALSE(ema_close(1.0, 1.0, -1.0, 2.0));
    TEST_ASSERT_FALSE(ema_close(1.0, 1.0, 2.0, -1.0));
    TEST_ASSERT_FALSE(ema_close(1.0, 1.0, (double)NAN, 0.0));
    TEST_ASSERT_FALSE(ema_close(1.0, 2.0, (double)INFINITY, 0.0));
    TEST_ASSERT_FALSE(ema_close(1.0, 2.0, 0.0, (double)INFINITY));
}

static void test_array_reports_the_worst(void)
{
    const ema_real expected[4] = {EMA_R(1.0), EMA_R(2.0), EMA_R(3.0), EMA_R(4.0)};
    const ema_real actual[4] = {EMA_R(1.0), EMA_R(2.25), EMA_R(3.5), EMA_R(4.125)};
    ema_close_report_t report;
    TEST_ASSERT_TRUE(ema_close_array(expected, actual, 4U, 0.5, 0.0, &report));
    TEST_ASSERT_FALSE(ema_close_array(expected, actual, 4U, 0.125, 0.0, &report));
    TEST_ASSERT_EQUAL_UINT(2U, report.worst);
    TEST_ASSERT_TRUE(ema_close(3.0, report.expected, 0.0, 0.0));
    TEST_ASSERT_TRUE(ema_close(3.5, report.actual, 0.0, 0.0));
    TEST_ASSERT_TRUE(ema_close(0.5, report.error, 0.0, 0.0));
    TEST_ASSERT_TRUE(ema_close(0.125, report.allowed, 0.0, 0.0));

    char text[200];
    TEST_ASSERT_EQUAL_STRING("worst at index 2: expected 3, got 3.5, error 0.5 over allowed 0.125",
                             ema_close_text(&report, true, text, sizeof text));
    TEST_ASSERT_EQUAL_STRING("expected 3, got 3.5, error 0.5 over allowed 0.125",
                             ema_close_text(&report, false, text, sizeof text));
}

static void test_array_first_and_last_element_count(void)
{
    const ema_real expected[3] = {EMA_R(1.0), EMA_R(1.0), EMA_R(1.0)};
    const ema_real first[3] = {EMA_R(2.0), EMA_R(1.0), EMA_R(1.0)};
    const ema_real last[3] = {EMA_R(1.0), EMA_R(1.0), EMA_R(2.0)};
    ema_close_report_t report;
    TEST_ASSERT_FALSE(ema_close_array(expected, first, 3U, 0.1, 0.0, &report));
    TEST_ASSERT_EQUAL_UINT(0U, report.worst);
    TEST_ASSERT_FALSE(ema_close_array(expected, last, 3U, 0.1, 0.0, &report));
    TEST_ASSERT_EQUAL_UINT(2U, report.worst);
    TEST_ASSERT_TRUE(ema_close_array(expected, last, 2U, 0.1, 0.0, &report));
}

static void test_array_not_finite_is_the_worst(void)
{
    const ema_real expected[4] = {EMA_R(1.0), EMA_R(1.0), EMA_R(1.0), EMA_R(1.0)};
    const ema_real actual[4] = {EMA_R(9.0), (ema_real)NAN, EMA_R(99.0), (ema_real)INFINITY};
    ema_close_report_t report;
    TEST_ASSERT_FALSE(ema_close_array(expected, actual, 4U, 1000.0, 0.0, &report));
    TEST_ASSERT_EQUAL_UINT(1U, report.worst);
    TEST_ASSERT_TRUE(isnan(report.actual));
}

static void test_array_of_no_elements_fails(void)
{
    const ema_real one[1] = {EMA_R(1.0)};
    ema_close_report_t report;
    TEST_ASSERT_FALSE(ema_close_array(one, one, 0U, 1.0, 1.0, &report));
}

static void test_first_difference(void)
{
    const unsigned char a[4] = {1U, 2U, 3U, 4U};
    const unsigned char b[4] = {1U, 2U, 9U, 4U};
    TEST_ASSERT_EQUAL_UINT(2U, ema_first_difference(a, b, 4U));
    TEST_ASSERT_EQUAL_UINT(2U, ema_first_difference(a, b, 2U));
    TEST_ASSERT_EQUAL_UINT(4U, ema_first_difference(a, a, 4U));
    const double zeros[2] = {0.0, -0.0};
    TEST_ASSERT_TRUE(ema_first_difference(&zeros[0], &zeros[1], sizeof(double)) < sizeof(double));
}

static void test_values_from_bits(void)
{
    const uint64_t bits[3] = {UINT64_C(0x3FF0000000000000), UINT64_C(0xC004000000000000), UINT64_C(0x3FB999999999999A)};
    ema_real values[3];
    ema_from_bits_array(bits, values, 3U);
    const ema_real expected[3] = {EMA_R(1.0), EMA_R(-2.5), EMA_R(0.1)};
    TEST_ASSERT_EQUAL_UINT(sizeof values, ema_first_difference(expected, values, sizeof values));
    TEST_ASSERT_TRUE(isnan(ema_from_bits(UINT64_C(0x7FF8000000000000))));
}

static void test_guards_see_writes_on_both_sides(void)
{
    EMA_GUARDED(ema_real) box;
    EMA_GUARD_SET(box);
    TEST_ASSERT_TRUE(ema_guard_intact(box.before));
    TEST_ASSERT_TRUE(ema_guard_intact(box.after));
    const unsigned char* noise = (const unsigned char*)&box.value;
    TEST_ASSERT_EQUAL_HEX8(0xA5, noise[0]);
    TEST_ASSERT_EQUAL_HEX8(0xA5, noise[sizeof(ema_real) - 1U]);
    box.after[0] ^= 1U;
    TEST_ASSERT_FALSE(ema_guard_intact(box.after));
    box.before[EMA_GUARD_WORDS - 1] ^= 0x80000000U;
    TEST_ASSERT_FALSE(ema_guard_intact(box.before));
}

/* The asserting forms are tried for real: a failing assertion must fail its test, so it runs in a run of its own. */
static int which;

static void failing(void)
{
    const ema_real one[2] = {EMA_R(1.0), EMA_R(1.0)};
    const ema_real two[2] = {EMA_R(1.0), EMA_R(2.0)};
    EMA_GUARDED(ema_real) box;
    EMA_GUARD_SET(box);
    switch (which) {
    case 0:
        EMA_ASSERT_CLOSE(1.0, 1.5, 0.1, 0.1);
        break;
    case 1:
        EMA_ASSERT_CLOSE_ARRAY(one, two, 2U, 0.1, 0.1);
        break;
    case 2:
        EMA_ASSERT_CLOSE_ARRAY(one, one, 0U, 0.1, 0.1);
        break;
    case 3:
        EMA_ASSERT_SAME_BITS(one, two, sizeof one);
        break;
    case 4:
        EMA_ASSERT_SAME_BITS(one, one, 0U);
        break;
    case 5:
        box.after[1] = 0U;
        EMA_ASSERT_GUARDS(box);
        break;
    default:
        box.before[1] = 0U;
        EMA_ASSERT_GUARDS(box);
        break;
    }
}

static void passing(void)
{
    const ema_real one[2] = {EMA_R(1.0), EMA_R(1.0)};
    EMA_GUARDED(ema_real) box;
    EMA_GUARD_SET(box);
    EMA_ASSERT_CLOSE(1.0, 1.5, 0.5, 0.0);
    EMA_ASSERT_CLOSE_ARRAY(one, one, 2U, 0.0, 0.0);
    EMA_ASSERT_SAME_BITS(one, one, sizeof one);
    EMA_ASSERT_GUARDS(box);
}

int main(void)
{
    UNITY_BEGIN();
    int failures = 0;
    for (which = 0; which <= 6; which++) {
        RUN_TEST(failing);
        failures += (Unity.TestFailures == (UNITY_UINT)(which + 1)) ? 0 : 1;
    }
    /* The seven failures above were wanted; from here on the count is the verdict. */
    UNITY_BEGIN();
    RUN_TEST(passing);
    RUN_TEST(test_scalar_within_and_beyond_tolerance);
    RUN_TEST(test_zero_has_no_relative_tolerance);
    RUN_TEST(test_not_finite_is_close_to_nothing);
    RUN_TEST(test_bad_tolerance_accepts_nothing);
    RUN_TEST(test_array_reports_the_worst);
    RUN_TEST(test_array_first_and_last_element_count);
    RUN_TEST(test_array_not_finite_is_the_worst);
    RUN_TEST(test_array_of_no_elements_fails);
    RUN_TEST(test_first_difference);
    RUN_TEST(test_values_from_bits);
    RUN_TEST(test_guards_see_writes_on_both_sides);
    return UNITY_END() + failures;
}
