/* Viscous damping that differs between the directions. */
#include "base/ema_math.h"
#include "effects/ema_effect_sites.h"

ema_real ema_effect_viscous_asymmetry(const ema_effect_viscous_asymmetry_t* effect, const ema_site_t* site)
{
    return -site->plant->screw.viscous_Nm_s_per_rad * effect->asymmetry * ema_abs(site->speed_rad_s);
}
