/* Break-away friction above the sliding level that falls with speed. */
#include "ema_effect_sites.h"
#include "ema_math.h"

ema_real ema_effect_stribeck_friction(const ema_effect_stribeck_friction_t* effect, const ema_site_t* site, ema_real level_Nm)
{
    const ema_real ratio = ema_abs(site->speed_rad_s) / effect->speed_rad_s;
    const ema_real power = (ratio > EMA_R(1.0e-30)) ? ema_exp(effect->shape * ema_log(ratio)) : EMA_R(0.0);
    return level_Nm * effect->rise * ema_exp(-power);
}
