/* A spot of the raceway with more dry friction, passed in both directions. */
#include "base/ema_math.h"
#include "effects/ema_effect_sites.h"

ema_real ema_effect_jam_spot(const ema_effect_jam_spot_t* effect, const ema_site_t* site, ema_real level_Nm)
{
    const ema_real away = (site->position_mm - effect->place_mm) / effect->width_mm;
    (void)level_Nm;
    return effect->amplitude_Nm * ema_exp(-(away * away));
}
