/* Decimal numbers are read to the last bit, and nothing that is no number is taken for one. */
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ema_close.h"
#include "ema_csv_number.h"

void setUp(void)
{
}

void tearDown(void)
{
    (void)setlocale(LC_ALL, "C");
}

static ema_number_t read_text(const char* text, double* value)
{
    return ema_csv_number(text, text + strlen(text), value);
}

/* The reader's answer is the C library's, bit for bit. */
static void assert_exact(const char* text)
{
    double value = -1.0;
    const double expected = strtod(text, NULL);
    TEST_ASSERT_EQUAL_INT_MESSAGE(EMA_NUMBER_OK, read_text(text, &value), text);
    TEST_ASSERT_TRUE_MESSAGE(memcmp(&expected, &value, sizeof value) == 0, text);
}

static uint64_t next_bits(uint64_t* state)
{
    *state ^= *state << 13U;
    *state ^= *state >> 7U;
    *state ^= *state << 17U;
    return *state;
}

static void test_forms(void)
{
    static const char* const good[] = {"0",
                                       "-0",
                                       "+1",
                                       "1.",
                                       ".5",
                                       "-.5e1",
                                       "1e3",
                                       "1E-3",
                                       "0012.50",
                                       "1e22",
                                       "1e23",
                                       "1e-22",
                                       "1e-23",
                                       "5e-324",
                                       "1e-400",
                                       "1.7976931348623157e308",
                                       "9007199254740993",
                                       "9007199254740993e0",
                                       "9999999999999999999",
                                       "0.00000000000000000000000000000123",
                                       "1e0000000003",
                                       "0e999999999999",
                                       "123456789012345678901234567890",
                                       "0.1000000000000000055511151231257827021181583404541015625"};
    for (size_t i = 0; i < (sizeof good / sizeof good[0]); ++i) {
        assert_exact(good[i]);
    }
    double value = 0.0;
    TEST_ASSERT_EQUAL_INT(EMA_NUMBER_OK, read_text(" \t 2.5 \t", &value));
    EMA_ASSERT_CLOSE(2.5, value, 0.0, 0.0);
    TEST_ASSERT_EQUAL_INT(EMA_NUMBER_OK, read_text("-0", &value));
    TEST_ASSERT_TRUE(signbit(value) != 0);
}

static void test_what_is_no_number(void)
{
    static const char* const text[] = {"abc",      "-",     "+",     ".",   "e5",    "1e",   "1e+", "1.2.3",
                                       "1,5",      "0x10",  "1 2",   "--1", "1-",    "1e5.", "12a", "nano",
                                       "infinite", "1_000", "\"1\"", "1f",  "1e1e1", "#N/A"};
    double value = 7.0;
    for (size_t i = 0; i < (sizeof text / sizeof text[0]); ++i) {
        TEST_ASSERT_EQUAL_INT_MESSAGE(EMA_NUMBER_TEXT, read_text(text[i], &value), text[i]);
    }
    static const char* const words[] = {"nan", "NaN", "-nan", "inf", "+Inf", "-INFINITY"};
    for (size_t i = 0; i < (sizeof words / sizeof words[0]); ++i) {
        TEST_ASSERT_EQUAL_INT_MESSAGE(EMA_NUMBER_NOT_FINITE, read_text(words[i], &value), words[i]);
    }
    TEST_ASSERT_EQUAL_INT(EMA_NUMBER_EMPTY, read_text("", &value));
    TEST_ASSERT_EQUAL_INT(EMA_NUMBER_EMPTY, read_text("  \t", &value));
    TEST_ASSERT_EQUAL_INT(EMA_NUMBER_HUGE, read_text("1e309", &value));
    TEST_ASSERT_EQUAL_INT(EMA_NUMBER_HUGE, read_text("-1e99999999999", &value));
    EMA_ASSERT_CLOSE(7.0, value, 0.0, 0.0);
}

static void test_zero_byte_and_length_are_no_end(void)
{
    double value = 7.0;
    static const char with_zero[] = {'1', '\0', '2'};
    TEST_ASSERT_EQUAL_INT(EMA_NUMBER_TEXT, ema_csv_number(with_zero, with_zero + sizeof with_zero, &value));
    static const char longer[] = "1.25999";
    TEST_ASSERT_EQUAL_INT(EMA_NUMBER_OK, ema_csv_number(longer, longer + 4, &value));
    EMA_ASSERT_CLOSE(1.25, value, 0.0, 0.0);
}

static void test_every_double_survives_printing(void)
{
    uint64_t state = UINT64_C(88172645463325252);
    for (int i = 0; i < 200000; ++i) {
        uint64_t bits = next_bits(&state);
        /* half of them of the size that recordings hold */
        if ((i % 2) == 0) {
            bits = (bits & UINT64_C(0x800FFFFFFFFFFFFF)) | ((UINT64_C(1003) + (next_bits(&state) % 40U)) << 52U);
        }
        double number = 0.0;
        (void)memcpy(&number, &bits, sizeof number);
        if (isfinite(number)) {
            char text[64];
            (void)snprintf(text, sizeof text, "%.17g", number);
            double value = 0.0;
            TEST_ASSERT_EQUAL_INT_MESSAGE(EMA_NUMBER_OK, read_text(text, &value), text);
            TEST_ASSERT_TRUE_MESSAGE(memcmp(&number, &value, sizeof value) == 0, text);
        }
    }
}

static void test_random_decimals_are_rounded_correctly(void)
{
    uint64_t state = UINT64_C(1234567890123457);
    for (int i = 0; i < 200000; ++i) {
        char text[80];
        const uint64_t mantissa = next_bits(&state) >> (next_bits(&state) % 60U);
        const int exponent = (int)(next_bits(&state) % 60U) - 35;
        (void)snprintf(text, sizeof text, "%llue%d", (unsigned long long)mantissa, exponent);
        assert_exact(text);
    }
}

/* Decimals in the middle of two doubles, and next to it: the hardest to round. */
static void test_middles_are_rounded_to_even(void)
{
    uint64_t state = UINT64_C(42424242424243);
    for (int i = 0; i < 50000; ++i) {
        /* m + 1/2 with m near 2^53 has 17 digits, one of them behind the point */
        const uint64_t m = (UINT64_C(1) << 52U) + (next_bits(&state) >> 12U);
        char text[80];
        (void)snprintf(text, sizeof text, "%llu.5", (unsigned long long)m);
        assert_exact(text);
        (void)snprintf(text, sizeof text, "%llu.499", (unsigned long long)m);
        assert_exact(text);
        (void)snprintf(text, sizeof text, "%llu.501", (unsigned long long)m);
        assert_exact(text);
    }
}

static void test_a_locale_with_decimal_comma_changes_nothing(void)
{
    static const char* const names[] = {"de_DE.UTF-8", "fr_FR.UTF-8", "it_IT.UTF-8",
                                        "de_DE.utf8",  "fr_FR.utf8",  "it_IT.utf8"};
    bool set = false;
    for (size_t i = 0; !set && (i < (sizeof names / sizeof names[0])); ++i) {
        set = (setlocale(LC_ALL, names[i]) != NULL) && (strcmp(localeconv()->decimal_point, ",") == 0);
    }
    if (!set) {
        TEST_IGNORE_MESSAGE("this machine has no locale with a decimal comma");
    }
    double value = 0.0;
    TEST_ASSERT_EQUAL_INT(EMA_NUMBER_OK, read_text("1.5e-40", &value));
    TEST_ASSERT_TRUE((value > 1.4e-40) && (value < 1.6e-40));
    TEST_ASSERT_EQUAL_INT(EMA_NUMBER_TEXT, read_text("1,5e-40", &value));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_forms);
    RUN_TEST(test_what_is_no_number);
    RUN_TEST(test_zero_byte_and_length_are_no_end);
    RUN_TEST(test_every_double_survives_printing);
    RUN_TEST(test_random_decimals_are_rounded_correctly);
    RUN_TEST(test_middles_are_rounded_to_even);
    RUN_TEST(test_a_locale_with_decimal_comma_changes_nothing);
    return UNITY_END();
}
