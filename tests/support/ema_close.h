/* Comparisons for the tests, stricter than the framework's own: NaN is close to nothing, infinity is close to nothing,
 * an empty array is not equal to anything, and a failure says the worst index with both values.
 *
 * Numbers are compared in double, which holds both builds' values exactly.
 */
#ifndef EMA_CLOSE_H
#define EMA_CLOSE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "ema/ema.h"
#include "unity.h"

/* What an array comparison found. */
typedef struct {
    size_t worst;  /* index of the first non-finite element, else of the largest error over what is allowed */
    double actual; /* the two values there */
    double expected;
    double error;   /* |actual - expected| there; NaN or infinite when a value is */
    double allowed; /* atol + rtol * |expected| there */
} ema_close_report_t;

/* True when both are finite and |actual - expected| <= atol + rtol * |expected|; false for a negative or NaN tolerance.
 */
bool ema_close(double expected, double actual, double atol, double rtol);

/* The same for every element; false when count is zero. The report is filled in whenever count is not zero. */
bool ema_close_array(const ema_real* expected, const ema_real* actual, size_t count, double atol, double rtol,
                     ema_close_report_t* report);

/* Writes the failure of element `report->worst` of an array, or of a scalar when is_array is false; returns text. */
const char* ema_close_text(const ema_close_report_t* report, bool is_array, char* text, size_t size);

/* Index of the first byte in which two blocks differ, or size when they are the same bits. */
size_t ema_first_difference(const void* expected, const void* actual, size_t size);

/* Exact bits of a stored reference value, and how many of them as numbers of this build. */
double ema_from_bits(uint64_t bits);
void ema_from_bits_array(const uint64_t* bits, ema_real* values, size_t count);

/* Words before and after an object show a write outside it; the object itself starts as noise, so that an
 * initialisation that forgets a field is seen. */
#define EMA_GUARD_WORDS 8
typedef uint32_t ema_guard_t[EMA_GUARD_WORDS];
#define EMA_GUARDED(type)                                                                                              \
    struct {                                                                                                           \
        ema_guard_t before;                                                                                            \
        type value;                                                                                                    \
        ema_guard_t after;                                                                                             \
    }
void ema_guard_set(ema_guard_t before, void* value, size_t size, ema_guard_t after);
bool ema_guard_intact(const ema_guard_t guard);

#define EMA_GUARD_SET(guarded)                                                                                         \
    ema_guard_set((guarded).before, &(guarded).value, sizeof((guarded).value), (guarded).after)
#define EMA_ASSERT_GUARDS(guarded)                                                                                     \
    do {                                                                                                               \
        TEST_ASSERT_TRUE_MESSAGE(ema_guard_intact((guarded).before), "write before " #guarded ".value");               \
        TEST_ASSERT_TRUE_MESSAGE(ema_guard_intact((guarded).after), "write behind " #guarded ".value");                \
    } while (0)

void ema_assert_close(double expected, double actual, double atol, double rtol, unsigned line);
void ema_assert_close_array(const ema_real* expected, const ema_real* actual, size_t count, double atol, double rtol,
                            unsigned line);
void ema_assert_same_bits(const void* expected, const void* actual, size_t size, unsigned line);

#define EMA_ASSERT_CLOSE(expected, actual, atol, rtol)                                                                 \
    ema_assert_close((double)(expected), (double)(actual), (atol), (rtol), (unsigned)__LINE__)
#define EMA_ASSERT_CLOSE_ARRAY(expected, actual, count, atol, rtol)                                                    \
    ema_assert_close_array((expected), (actual), (count), (atol), (rtol), (unsigned)__LINE__)
/* Two objects or arrays of the same type, bit for bit; size in bytes. */
#define EMA_ASSERT_SAME_BITS(expected, actual, size)                                                                   \
    ema_assert_same_bits((expected), (actual), (size), (unsigned)__LINE__)

#endif
