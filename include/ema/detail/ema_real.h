/* The number type of the module: float on the target, double for analysis on the host. */
#ifndef EMA_REAL_H
#define EMA_REAL_H

#ifdef __FAST_MATH__
#error "EMA needs IEEE arithmetic: without it NaN passes every check. Build without -ffast-math."
#endif
#if defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0)
#error "EMA needs NaN and infinity to be seen. Build without -ffinite-math-only."
#endif

/* Contraction makes one rounding of two. Where the compiler takes the standard's word for it no flag is needed; gcc
 * wants -ffp-contract=off, and ema_selftest sees where it was forgotten. */
#if defined(__clang__) && !defined(__cplusplus)
#pragma STDC FP_CONTRACT OFF
#endif

/* EMA_REAL64 = 1 builds the same sources in double precision. Both builds of a program must agree: it is set for the
 * whole library and its users by the build, never per file. */
#ifndef EMA_REAL64
#define EMA_REAL64 0
#endif

#if defined(__FLT_EVAL_METHOD__) && !defined(__cplusplus)
#if (__FLT_EVAL_METHOD__ != 0) && (__FLT_EVAL_METHOD__ != 16) && !(EMA_REAL64 && (__FLT_EVAL_METHOD__ == 1))
#error                                                                                                                 \
    "EMA needs each operation rounded to its own type. Build without excess precision: -msse2 -mfpmath=sse on x86, -std=c11."
#endif
#endif

#if EMA_REAL64
typedef double ema_real;
#define EMA_R(x) x
#define EMA_REAL_EPSILON 2.220446049250313e-16
#else
typedef float ema_real;
/* Turns a literal such as 0.5 into one of the module's type. */
#define EMA_R(x) x##f
#define EMA_REAL_EPSILON 1.1920929e-7f
#endif

#endif
