/* Break-away friction that falls with speed, of another size in each direction. */
#include "effects/ema_effect_sites.h"
#include "effects/ema_stribeck.h"

ema_real ema_effect_directional_stribeck(const ema_effect_directional_stribeck_t* effect, const ema_site_t* site,
                                         ema_real level_Nm)
{
    const ema_real rise = effect->rise * (EMA_R(1.0) + (effect->asymmetry * site->direction));
    return ema_stribeck(level_Nm * rise, site->speed_rad_s, effect->speed_rad_s, effect->shape);
}
