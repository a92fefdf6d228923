#include "base/ema_math.h"

#include <float.h>
#include <string.h>

#if EMA_REAL64
typedef uint64_t ema_bits_t;
#define EMA_MANTISSA_BITS 52U
#define EMA_EXPONENT_BIAS 1023
#define EMA_EXPONENT_MASK 0x7ffU
#define EMA_LOG_TERMS 11U
#define EMA_REAL_MAX DBL_MAX
#define EMA_EXP_HIGH 709.0
#define EMA_EXP_LOW (-708.0)
#define EMA_WHOLE_FROM 6755399441055744.0
#define EMA_LN2_HIGH 0.693147180369123816490
#define EMA_LN2_LOW 1.90821492927058770002e-10
#else
typedef uint32_t ema_bits_t;
#define EMA_MANTISSA_BITS 23U
#define EMA_EXPONENT_BIAS 127
#define EMA_EXPONENT_MASK 0xffU
#define EMA_LOG_TERMS 5U
#define EMA_REAL_MAX FLT_MAX
#define EMA_EXP_HIGH 88.0f
#define EMA_EXP_LOW (-87.0f)
#define EMA_WHOLE_FROM 12582912.0f
#define EMA_LN2_HIGH 0.693359375f
#define EMA_LN2_LOW (-2.12194440e-4f)
#endif

const ema_real ema_inverse[EMA_INVERSE_COUNT] = {
    EMA_R(0.0),
    EMA_R(1.0),
    EMA_R(0.5),
    EMA_R(0.3333333333333333),
    EMA_R(0.25),
    EMA_R(0.2),
    EMA_R(0.16666666666666666),
    EMA_R(0.14285714285714285),
    EMA_R(0.125),
    EMA_R(0.1111111111111111),
    EMA_R(0.1),
    EMA_R(0.09090909090909091),
    EMA_R(0.08333333333333333),
    EMA_R(0.07692307692307693),
    EMA_R(0.07142857142857142),
    EMA_R(0.06666666666666667),
    EMA_R(0.0625),
    EMA_R(0.058823529411764705),
    EMA_R(0.05555555555555555),
    EMA_R(0.05263157894736842),
    EMA_R(0.05),
    EMA_R(0.047619047619047616),
#if EMA_REAL64
    0.045454545454545456,
    0.043478260869565216,
    0.041666666666666664,
#endif
};

/* Polynomials, highest power first: e^x for |x| <= ln2 / 2, and in the square of t the sine of t turns over t for |t|
 * <= 1/4. Taylor's, or in float32, where every term counts, the one of least error. */
#if EMA_REAL64
static const ema_real ema_exp_terms[] = {
    1.1470745597729725e-11,
    1.6059043836821613e-10,
    2.08767569878681e-09,
    2.505210838544172e-08,
    2.7557319223985888e-07,
    2.7557319223985893e-06,
    2.4801587301587302e-05,
    0.00019841269841269841,
    0.0013888888888888889,
    0.0083333333333333332,
    0.041666666666666664,
    0.16666666666666666,
    0.5,
    1.0,
    1.0,
};
static const ema_real ema_sin_terms[] = {
    -8.8235335992429962e-05, 0.0011309237482517954, -0.012031585942120619, 0.10422916220813978,
    -0.71812230177850012,    3.8199525848482803,    -15.094642576822984,   42.058693944897634,
    -76.705859753061361,     81.605249276075043,    -41.341702240399755,   6.2831853071795862,
};
#else
static const ema_real ema_exp_terms[] = {0.00138368038f, 0.00837484561f, 0.0416682288f, 0.166664198f,
                                         0.499999911f,   1.0f,           1.0f};
static const ema_real ema_sin_terms[] = {39.7109184f, -76.5749893f, 81.6022339f, -41.3416786f, 6.28318548f};
#endif

/* The next two terms of a polynomial. */
static inline ema_real ema_next_terms(const ema_real* terms, ema_real x, ema_real square, ema_real sum)
{
    return (sum * square) + ((terms[0] * x) + terms[1]);
}

/* Two terms at a time: each waits for half as many before it as by Horner's rule. */
static ema_real ema_polynomial(const ema_real* terms, uint32_t count, ema_real x)
{
    const ema_real square = x * x;
    const uint32_t odd = count % 2U;
    ema_real sum = (odd != 0U) ? terms[0] : ((terms[0] * x) + terms[1]);
    for (uint32_t k = 2U - odd; k < count; k += 2U) {
        sum = ema_next_terms(&terms[k], x, square, sum);
    }
    return sum;
}

#define EMA_POLYNOMIAL(terms, x) ema_polynomial(terms, (uint32_t)(sizeof(terms) / sizeof(ema_real)), x)

/* The whole number next to x, |x| < 2^22: beside 3/2 of the power of two from which on there are only whole numbers,
 * which the sum is rounded to. No branch, since nothing would predict it. */
static ema_real ema_nearest(ema_real x)
{
    const ema_real whole = x + EMA_WHOLE_FROM;
    return whole - EMA_WHOLE_FROM;
}

#define EMA_QUARTER_RAD EMA_R(1.5707963267948966)

/* Two to the power k, k within the exponents of normal numbers. */
static ema_real ema_power_of_two(int32_t k)
{
    const int32_t exponent = k + EMA_EXPONENT_BIAS;
    const ema_bits_t bits = (ema_bits_t)(uint32_t)exponent << EMA_MANTISSA_BITS;
    ema_real value;
    (void)memcpy(&value, &bits, sizeof value); /* EMA-D3 */
    return value;
}

ema_real ema_clamp(ema_real x, ema_real lower, ema_real upper)
{
    return ema_min(ema_max(x, lower), upper);
}

ema_real ema_floor(ema_real x)
{
    if (!(ema_abs(x) < EMA_R(2147483000.0))) {
        return x;
    }
    const int32_t whole = (int32_t)x;
    const ema_real back = (ema_real)whole;
    return (back > x) ? (back - EMA_R(1.0)) : back;
}

ema_real ema_exp_inside(ema_real x)
{
    const ema_real turns = ema_nearest(x * EMA_R(1.4426950408889634));
    const ema_real rest = (x - (turns * EMA_LN2_HIGH)) - (turns * EMA_LN2_LOW);
#if EMA_REAL64
    const ema_real sum = EMA_POLYNOMIAL(ema_exp_terms, rest);
#else
    /* written out: friction asks for it many times in a step */
    const ema_real square = rest * rest;
    ema_real sum = ema_next_terms(&ema_exp_terms[1], rest, square, ema_exp_terms[0]);
    sum = ema_next_terms(&ema_exp_terms[3], rest, square, sum);
    sum = ema_next_terms(&ema_exp_terms[5], rest, square, sum);
#endif
    return sum * ema_power_of_two((int32_t)turns);
}

ema_real ema_exp(ema_real x)
{
    if (x > EMA_EXP_HIGH) {
        return EMA_REAL_MAX;
    }
    if (!(x > EMA_EXP_LOW)) {
        return EMA_R(0.0);
    }
    return ema_exp_inside(x);
}

ema_real ema_log(ema_real x)
{
    ema_bits_t bits;
    (void)memcpy(&bits, &x, sizeof bits); /* EMA-D3 */
    const ema_bits_t biased = (bits >> EMA_MANTISSA_BITS) & EMA_EXPONENT_MASK;
    int32_t exponent = (int32_t)biased - EMA_EXPONENT_BIAS;
    bits = (bits & (((ema_bits_t)1 << EMA_MANTISSA_BITS) - (ema_bits_t)1))
           | ((ema_bits_t)(uint32_t)EMA_EXPONENT_BIAS << EMA_MANTISSA_BITS);
    ema_real mantissa;
    (void)memcpy(&mantissa, &bits, sizeof mantissa); /* EMA-D3 */
    if (mantissa > EMA_R(1.4142135623730951)) {
        mantissa *= EMA_R(0.5);
        exponent += 1;
    }
    /* log m = 2 atanh((m - 1) / (m + 1)) with |ratio| < 0.172 */
    const ema_real ratio = (mantissa - EMA_R(1.0)) / (mantissa + EMA_R(1.0));
    const ema_real square = ratio * ratio;
    ema_real sum = EMA_R(0.0);
    for (uint32_t k = EMA_LOG_TERMS; k > 0U; --k) {
        sum = (sum * square) + ema_inverse[(2U * k) - 1U];
    }
    const ema_real whole = (ema_real)exponent;
    return (whole * EMA_LN2_HIGH) + ((whole * EMA_LN2_LOW) + (EMA_R(2.0) * ratio * sum));
}

/* Taylor's terms of the sine by Horner, each over the one before, the highest first. */
#define EMA_SIN_OVER(even) ((EMA_R(1.0) / EMA_R(even)) * (EMA_R(1.0) / (EMA_R(even) + EMA_R(1.0))))
static const ema_real ema_quarter_terms[] = {
#if EMA_REAL64
    EMA_SIN_OVER(20.0), EMA_SIN_OVER(18.0), EMA_SIN_OVER(16.0), EMA_SIN_OVER(14.0),
#endif
    EMA_SIN_OVER(12.0), EMA_SIN_OVER(10.0), EMA_SIN_OVER(8.0),  EMA_SIN_OVER(6.0),
    EMA_SIN_OVER(4.0),  EMA_SIN_OVER(2.0)};

/* Sine of x rad for |x| <= pi / 2; two terms in a turn, since a chirp asks for it in every step. */
static ema_real ema_sin_quarter(ema_real x)
{
    const ema_real square = x * x;
    ema_real sum = EMA_R(1.0);
    for (uint32_t k = 0; k < (uint32_t)(sizeof(ema_quarter_terms) / sizeof(ema_real)); k += 2U) {
        sum = EMA_R(1.0) - (sum * (square * ema_quarter_terms[k]));
        sum = EMA_R(1.0) - (sum * (square * ema_quarter_terms[k + 1U]));
    }
    return x * sum;
}

#if !EMA_REAL64
/* From this size on the upper word has more bits than a real, so that of the lower it matters only whether it is zero.
 */
#define EMA_UPPER_LARGE (UINT32_C(1) << 25U)
/* Shifts that bring any number there. */
#define EMA_UPPER_SHIFT 6U
#define EMA_UPPER_SHIFTS 10U

/* The number whose two's complement has these bits. */
static int32_t ema_signed(uint32_t bits)
{
    return (bits <= (uint32_t)INT32_MAX) ? (int32_t)bits : (-1 - (int32_t)(uint32_t)~bits);
}
#endif

/* A signed fraction of 2^64 turns, at most a quarter, in rad. In float32 rounded once as a conversion of the whole
 * rounds it: the target has no instruction for more than 32 bits. */
static ema_real ema_quarter_rad(uint64_t turned)
{
#if EMA_REAL64
    const bool negative = (turned >> 63U) != 0U;
    const ema_real size = (ema_real)(negative ? (UINT64_C(0) - turned) : turned);
    return (negative ? -size : size) * (EMA_QUARTER_RAD / EMA_R(4.611686018427387904e18));
#else
    uint64_t left = turned;
    ema_real unit_rad = EMA_QUARTER_RAD / EMA_R(1073741824.0);
    uint32_t upper = (uint32_t)(left >> 32U);
    for (uint32_t k = 0; (k < EMA_UPPER_SHIFTS) && ((upper + EMA_UPPER_LARGE) < (2U * EMA_UPPER_LARGE)); ++k) {
        left <<= EMA_UPPER_SHIFT;
        unit_rad *= EMA_R(0.015625);
        upper = (uint32_t)(left >> 32U);
    }
    return (ema_real)ema_signed(upper | (((left & UINT32_MAX) != 0U) ? 1U : 0U)) * unit_rad;
#endif
}

ema_real ema_sin_turn64(uint64_t phase)
{
    /* fold the second and third quarter back, so that the series sees at most a quarter turn either way */
    const uint64_t quarter = UINT64_C(1) << 62U;
    const bool back = ((phase + quarter) >> 63U) != 0U;
    return ema_sin_quarter(ema_quarter_rad(back ? ((quarter * 2U) - phase) : phase));
}

uint64_t ema_turn64(ema_real x)
{
    const ema_real part = x - ema_floor(x);
    /* in two halves: a single conversion of a number close to 1 could round up to 2^64 */
    const ema_real scaled = part * EMA_R(4294967296.0);
    const uint32_t high = (scaled < EMA_R(4294967295.0)) ? (uint32_t)scaled : UINT32_MAX;
    const ema_real rest = ema_clamp(scaled - (ema_real)high, EMA_R(0.0), EMA_R(0.99999994)) * EMA_R(4294967296.0);
    return ((uint64_t)high << 32U) | (uint32_t)rest;
}

/* The part of a turn, -1/2 to 1/2, that x rad are beyond whole ones. */
static ema_real ema_turn_part(ema_real x)
{
    const ema_real turns = x * EMA_R(0.15915494309189535);
    return (ema_abs(turns) < EMA_R(4194304.0)) ? (turns - ema_nearest(turns)) : EMA_R(0.0);
}

/* The sine of at most a quarter turn either way. */
static ema_real ema_sin_folded(ema_real turn)
{
    return turn * EMA_POLYNOMIAL(ema_sin_terms, turn * turn);
}

/* Folded at a quarter turn by the whole half turns, of which every second turns the sign: a product with a power of
 * two, the difference from a whole number and a sign lose nothing. */
ema_real ema_sin(ema_real x)
{
    const ema_real halves = x * EMA_R(0.3183098861837907);
    if (!(ema_abs(halves) < EMA_R(4194304.0))) {
        return EMA_R(0.0);
    }
    const ema_real whole = ema_nearest(halves);
    const ema_real rest = EMA_R(0.5) * (halves - whole);
    return ema_sin_folded((((uint32_t)(int32_t)whole & 1U) != 0U) ? -rest : rest);
}

/* The quarter comes in after whole turns are gone: at |part| <= 1/2 nothing of the angle is lost. */
ema_real ema_cos(ema_real x)
{
    return ema_sin_folded(EMA_R(0.25) - ema_abs(ema_turn_part(x)));
}
