/* Dry friction that grows with the torque that is transmitted. */
#include "base/ema_math.h"
#include "effects/ema_effect_sites.h"

ema_real ema_effect_load_dependent_friction(const ema_effect_load_dependent_friction_t* effect, const ema_site_t* site,
                                            ema_real level_Nm)
{
    (void)level_Nm;
    return effect->ratio * ema_abs(site->plant->motor.torque_constant_Nm_per_A * site->current_A);
}
