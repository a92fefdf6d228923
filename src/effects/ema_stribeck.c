#include "effects/ema_stribeck.h"

#include "base/ema_math.h"

/* Where the exponential is below the resolution of the level. */
#if EMA_REAL64
#define EMA_FADED EMA_R(40.0)
#else
#define EMA_FADED EMA_R(18.0)
#endif

ema_real ema_stribeck(ema_real rise_Nm, ema_real speed_rad_s, ema_real fallen_rad_s, ema_real shape)
{
    const ema_real ratio = ema_abs(speed_rad_s) / fallen_rad_s;
    ema_real power = EMA_R(0.0);
    /* ratio^shape; the two usual shapes need no logarithm */
    if (shape == EMA_R(1.0)) {
        power = ratio;
    } else if (shape == EMA_R(2.0)) {
        power = ratio * ratio;
    } else if (ratio > EMA_R(1.0e-30)) {
        power = ema_exp(shape * ema_log(ratio));
    } else {
        /* at rest the rise is whole */
    }
    return rise_Nm * ((power < EMA_FADED) ? ema_exp_inside(-power) : EMA_R(0.0));
}
