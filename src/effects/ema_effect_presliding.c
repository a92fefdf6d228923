/* Contact that stretches like a spring before it slides, Dahl's form, exact for a turn in one direction. */
#include "base/ema_math.h"
#include "effects/ema_effect_sites.h"

ema_real ema_effect_presliding(const ema_effect_presliding_t* effect, ema_real turn_rad, ema_real stretch,
                               ema_real lead_mm_per_rad)
{
    (void)lead_mm_per_rad;
    const ema_real side = (turn_rad < EMA_R(0.0)) ? EMA_R(-1.0) : EMA_R(1.0);
    if (stretch == side) {
        /* slides already */
        return side;
    }
    return side + ((stretch - side) * ema_exp(-ema_abs(turn_rad) / effect->stretch_rad));
}
