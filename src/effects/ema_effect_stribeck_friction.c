/* Break-away friction above the sliding level that falls with speed. */
#include "effects/ema_effect_sites.h"
#include "effects/ema_stribeck.h"

ema_real ema_effect_stribeck_friction(const ema_effect_stribeck_friction_t* effect, const ema_site_t* site,
                                      ema_real level_Nm)
{
    return ema_stribeck(level_Nm * effect->rise, site->speed_rad_s, effect->speed_rad_s, effect->shape);
}
