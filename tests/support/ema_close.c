#include "ema_close.h"

#include <math.h>
#include <stdio.h>

#define GUARD_PATTERN 0x5AFE600DU
#define NOISE_BYTE 0xA5

static double allowed_error(double expected, double atol, double rtol)
{
    return atol + (rtol * fabs(expected));
}

bool ema_close(double expected, double actual, double atol, double rtol)
{
    const bool tolerances = (atol >= 0.0) && (rtol >= 0.0) && isfinite(atol) && isfinite(rtol);
    return tolerances && isfinite(expected) && isfinite(actual)
           && (fabs(actual - expected) <= allowed_error(expected, atol, rtol));
}

bool ema_close_array(const ema_real* expected, const ema_real* actual, size_t count, double atol, double rtol,
                     ema_close_report_t* report)
{
    bool all = (count > 0U);
    double worst_excess = -1.0;
    for (size_t i = 0U; i < count; i++) {
        const double e = (double)expected[i];
        const double a = (double)actual[i];
        const bool finite = isfinite(e) && isfinite(a);
        const double allowed = allowed_error(e, atol, rtol);
        const double error = fabs(a - e);
        const double excess = finite ? (error - allowed) : (double)INFINITY;
        if ((i == 0U) || (excess > worst_excess)) {
            worst_excess = excess;
            *report = (ema_close_report_t){.worst = i, .actual = a, .expected = e, .error = error, .allowed = allowed};
        }
        all = ema_close(e, a, atol, rtol) && all;
    }
    return all;
}

const char* ema_close_text(const ema_close_report_t* report, bool is_array, char* text, size_t size)
{
    char where[40] = "";
    if (is_array) {
        (void)snprintf(where, sizeof where, "worst at index %lu: ", (unsigned long)report->worst);
    }
    (void)snprintf(text, size, "%sexpected %.17g, got %.17g, error %.3g over allowed %.3g", where, report->expected,
                   report->actual, report->error, report->allowed);
    return text;
}

size_t ema_first_difference(const void* expected, const void* actual, size_t size)
{
    const unsigned char* e = (const unsigned char*)expected;
    const unsigned char* a = (const unsigned char*)actual;
    size_t i = 0U;
    while ((i < size) && (e[i] == a[i])) {
        i++;
    }
    return i;
}

double ema_from_bits(uint64_t bits)
{
    double value;
    (void)memcpy(&value, &bits, sizeof value);
    return value;
}

void ema_from_bits_array(const uint64_t* bits, ema_real* values, size_t count)
{
    for (size_t i = 0U; i < count; i++) {
        values[i] = (ema_real)ema_from_bits(bits[i]);
    }
}

void ema_guard_set(ema_guard_t before, void* value, size_t size, ema_guard_t after)
{
    for (size_t i = 0U; i < EMA_GUARD_WORDS; i++) {
        before[i] = GUARD_PATTERN;
        after[i] = GUARD_PATTERN;
    }
    (void)memset(value, NOISE_BYTE, size);
}

bool ema_guard_intact(const ema_guard_t guard)
{
    bool intact = true;
    for (size_t i = 0U; i < EMA_GUARD_WORDS; i++) {
        intact = intact && (guard[i] == GUARD_PATTERN);
    }
    return intact;
}

void ema_assert_close(double expected, double actual, double atol, double rtol, unsigned line)
{
    if (!ema_close(expected, actual, atol, rtol)) {
        char text[200];
        const ema_close_report_t report = {.actual = actual,
                                           .expected = expected,
                                           .error = fabs(actual - expected),
                                           .allowed = allowed_error(expected, atol, rtol)};
        UNITY_TEST_FAIL(line, ema_close_text(&report, false, text, sizeof text));
    }
}

void ema_assert_close_array(const ema_real* expected, const ema_real* actual, size_t count, double atol, double rtol,
                            unsigned line)
{
    ema_close_report_t report = {0};
    if (!ema_close_array(expected, actual, count, atol, rtol, &report)) {
        char text[200];
        UNITY_TEST_FAIL(line, (count == 0U) ? "nothing to compare: count is zero"
                                            : ema_close_text(&report, true, text, sizeof text));
    }
}

void ema_assert_same_bits(const void* expected, const void* actual, size_t size, unsigned line)
{
    const size_t at = ema_first_difference(expected, actual, size);
    if ((size == 0U) || (at < size)) {
        char text[100];
        (void)snprintf(text, sizeof text, "different bits: first at byte %lu of %lu", (unsigned long)at,
                       (unsigned long)size);
        UNITY_TEST_FAIL(line, text);
    }
}
