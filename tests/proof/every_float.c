/* Calls each elementary function of one argument with every float32 there is: 2^32 of them, NaN and infinities too.
 * What it asserts is what contracts.h states.
 *
 * Built with the sanitizers of conversions and shifts, which end the program: so none of these functions converts a
 * number that does not fit.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/ema_math.h"

static int wrong;

static void claim(bool holds, const char* text, uint32_t bits, ema_real result)
{
    if (!holds && (wrong < 10)) {
        (void)printf("0x%08lx: %s, not %.9g\n", (unsigned long)bits, text, (double)result);
        ++wrong;
    }
}

static void one(uint32_t bits)
{
    ema_real x;
    (void)memcpy(&x, &bits, sizeof x);
    const bool nan = isnan(x) != 0;
    const bool finite = isfinite(x) != 0;
    claim(ema_is_finite(x) == finite, "ema_is_finite", bits, x);
    claim(!isnan(ema_min(x, EMA_R(1.0))) && !isnan(ema_max(x, EMA_R(1.0))), "ema_min and ema_max give a number", bits,
          x);
    const ema_real whole = ema_floor(x);
    claim(nan || !isnan(whole), "ema_floor is a number", bits, whole);
    claim(!finite || (isfinite(whole) && (!(fabsf(x) <= EMA_R(1.0e35)) || (fabsf(whole) <= EMA_R(1.0e35)))),
          "ema_floor is finite", bits, whole);
    claim(!(fabsf(x) <= EMA_R(65536.0)) || (fabsf(whole) <= EMA_R(65536.0)), "ema_floor is small", bits, whole);
    claim(!(fabsf(x) <= EMA_R(2147483000.0)) || (fabsf(whole) <= EMA_R(2147483648.0)), "ema_floor is middling", bits,
          whole);
    const ema_real power = ema_exp(x);
    claim((power >= EMA_R(0.0)) && (power <= FLT_MAX) && (!(x <= EMA_R(0.0)) || (power <= EMA_R(1.0))), "ema_exp", bits,
          power);
    const ema_real logarithm = ema_log(x);
    claim((logarithm >= EMA_R(-89.0)) && (logarithm <= EMA_R(89.5))
              && (!((x > EMA_R(0.0)) && (x <= EMA_R(1.0))) || (logarithm <= EMA_R(0.0))),
          "ema_log", bits, logarithm);
    const ema_real sine = ema_sin(x);
    const ema_real cosine = ema_cos(x);
    claim(!finite || (fabsf(sine) <= EMA_R(1.000001)), "ema_sin", bits, sine);
    claim(!finite || (fabsf(cosine) <= EMA_R(1.000001)), "ema_cos", bits, cosine);
    if (fabsf(x) < EMA_R(2147483648.0)) {
        (void)ema_turn64(x);
    }
}

/* Which quarter of them: 0 to 3. */
int main(int count, char** words)
{
    if ((count != 2) || (words[1][0] < '0') || (words[1][0] > '3')) {
        (void)printf("every_float: name the quarter, 0 to 3\n");
        return 2;
    }
    const uint32_t first = (uint32_t)(words[1][0] - '0') << 30U;
    for (uint32_t k = 0U; k < (UINT32_C(1) << 30U); ++k) {
        one(first | k);
    }
    if (wrong == 0) {
        (void)printf("a quarter of all float32 arguments of the elementary functions: as stated\n");
    }
    return (wrong == 0) ? 0 : 1;
}
