/* Turbulent drag on the rotor. */
#include "base/ema_math.h"
#include "effects/ema_effect_sites.h"

ema_real ema_effect_quadratic_viscous(const ema_effect_quadratic_viscous_t* effect, const ema_site_t* site)
{
    return -effect->drag_Nm_s2_per_rad2 * site->speed_rad_s * ema_abs(site->speed_rad_s);
}
