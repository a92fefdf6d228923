#include "trend/ema_first_passage.h"

#include <stdint.h>

#include "base/ema_math.h"

/* Logarithm of Mills' ratio over t = 1 / (1 + z / 2), by powers of t, the highest first: a least-squares fit, off by
 * at most 5e-8. */
#define EMA_MILLS_TERMS 12U
static const ema_real ema_mills_terms[EMA_MILLS_TERMS] = {
    EMA_R(0.404577330629),  EMA_R(-2.27769073148),  EMA_R(5.27551708249),   EMA_R(-6.19384369133),
    EMA_R(3.40716503164),   EMA_R(-0.286872446152), EMA_R(-0.165763370078), EMA_R(-0.323956195964),
    EMA_R(-0.170463409996), EMA_R(0.250275916653),  EMA_R(0.999993031142),  EMA_R(-1.61208568637)};

/* Probability of lying above z >= 0 over e^(-z^2 / 2). */
static ema_real ema_mills(ema_real z)
{
    const ema_real t = EMA_R(1.0) / (EMA_R(1.0) + (EMA_R(0.5) * z));
    ema_real sum = ema_mills_terms[0];
    for (uint32_t k = 1U; k < EMA_MILLS_TERMS; ++k) {
        sum = (sum * t) + ema_mills_terms[k];
    }
    return t * ema_exp(sum);
}

ema_real ema_normal_above(ema_real z)
{
    const ema_real size = ema_abs(z);
    const ema_real tail = ema_exp(EMA_R(-0.5) * size * size) * ema_mills(size);
    return (z < EMA_R(0.0)) ? (EMA_R(1.0) - tail) : tail;
}

ema_real ema_reached(ema_real left, ema_real advance, ema_real doubt, ema_real walked)
{
    const ema_real spread = ema_sqrt(doubt + walked);
    const ema_real below = (left - advance) / spread;
    const ema_real above = ema_normal_above(below);
    if (!(walked > EMA_R(0.0)) || !(left > EMA_R(0.0))) {
        return above;
    }
    /* those that have been there and have walked back */
    const ema_real mirrored = (left + advance + (EMA_R(2.0) * left * (doubt / walked))) / spread;
    ema_real back;
    if (mirrored > EMA_R(0.0)) {
        back = ema_exp(EMA_R(-0.5) * below * below) * ema_mills(mirrored);
    } else {
        back = ema_exp(EMA_R(0.5) * (mirrored - below) * (mirrored + below)) * ema_normal_above(mirrored);
    }
    return ema_min(above + back, EMA_R(1.0));
}
