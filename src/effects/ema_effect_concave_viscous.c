/* Drag that grows with the square root of speed. */
#include "base/ema_math.h"
#include "effects/ema_effect_sites.h"

ema_real ema_effect_concave_viscous(const ema_effect_concave_viscous_t* effect, const ema_site_t* site)
{
    const ema_real drag_Nm = effect->drag_Nm_per_sqrt_rad_s * ema_sqrt(ema_abs(site->speed_rad_s));
    return (site->speed_rad_s > EMA_R(0.0)) ? -drag_Nm : drag_Nm;
}
