/* Turbulent drag on the rotor. */
#include "ema_effect_sites.h"
#include "ema_math.h"

ema_real ema_effect_quadratic_viscous(const ema_effect_quadratic_viscous_t* effect, const ema_site_t* site)
{
    return -effect->drag_Nm_s2_per_rad2 * site->speed_rad_s * ema_abs(site->speed_rad_s);
}
