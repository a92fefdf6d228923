/* Elementary functions with a fixed order of operations, so that every machine computes the same bits.
 *
 * The C library's transcendentals differ in the last bit from machine to machine, and one flipped acceptance forks an
 * annealing path for good. Stated errors are held by tests/unit/test_math.c.
 */
#ifndef EMA_MATH_H
#define EMA_MATH_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#include "ema/detail/ema_real.h"

/* One turn in rad. */
#define EMA_TURN_RAD EMA_R(6.283185307179586)

/* True unless x is NaN or infinite. A comparison, so that it needs no library call on any target. */
static inline bool ema_is_finite(ema_real x)
{
    return (x - x) == EMA_R(0.0);
}

/* Size of x: one instruction, no call. */
static inline ema_real ema_abs(ema_real x)
{
#if EMA_REAL64
    return fabs(x);
#else
    return fabsf(x);
#endif
}

static inline ema_real ema_min(ema_real a, ema_real b)
{
    return (a < b) ? a : b;
}

static inline ema_real ema_max(ema_real a, ema_real b)
{
    return (a > b) ? a : b;
}

ema_real ema_clamp(ema_real x, ema_real lower, ema_real upper);

/* One over k for the series: a product is many times faster than a quotient, and they have slack for its rounding. */
#if EMA_REAL64
#define EMA_INVERSE_COUNT 25U
#else
#define EMA_INVERSE_COUNT 22U
#endif
extern const ema_real ema_inverse[EMA_INVERSE_COUNT];

/* Square root, correctly rounded on every machine by IEEE 754; x >= 0. */
static inline ema_real ema_sqrt(ema_real x)
{
#if EMA_REAL64
    return sqrt(x);
#else
    return sqrtf(x);
#endif
}

/* A sum that keeps what a small addend loses against a large total (Dekker's two-sum on |total| >= |addend| or not). */
static inline void ema_add_compensated(ema_real* high, ema_real* low, ema_real addend)
{
    const ema_real part = addend + *low;
    const ema_real sum = *high + part;
    const ema_real back = sum - *high;
    *low = (*high - (sum - back)) + (part - back);
    *high = sum;
}

/* e^x; zero below the smallest normal number, the largest finite number above the range. Relative error under 3 units
 * in the last place. */
ema_real ema_exp(ema_real x);
/* The same of -87 < x <= 88, which the caller knows. */
ema_real ema_exp_inside(ema_real x);

/* Natural logarithm of x > 0, normal numbers. Error under 3 units in the last place of max(1, |log x|). */
ema_real ema_log(ema_real x);

/* Sine and cosine of an angle in rad. Absolute error under 2 epsilon * max(1, |x|) for |x| < 1e6. */
ema_real ema_sin(ema_real x);
ema_real ema_cos(ema_real x);

/* Sine of a phase in turns, given as a fraction of 2^64. Absolute error under 2 epsilon. */
ema_real ema_sin_turn64(uint64_t phase);

/* Part of a turn, or any number, as a fraction of 2^64, wrapped to one turn. |x| < 2^31. */
uint64_t ema_turn64(ema_real x);

/* Largest whole number not above x; x itself from about 2^31 on, where reals of the float build are whole. */
ema_real ema_floor(ema_real x);

#endif
