/* Break-away friction that grows with the torque that is transmitted, and falls with speed. */
#include "base/ema_math.h"
#include "effects/ema_effect_sites.h"
#include "effects/ema_stribeck.h"

ema_real ema_effect_load_dependent_stribeck(const ema_effect_load_dependent_stribeck_t* effect, const ema_site_t* site,
                                            ema_real level_Nm)
{
    const ema_real torque_Nm = site->plant->motor.torque_constant_Nm_per_A * site->current_A;
    (void)level_Nm;
    return ema_stribeck(effect->ratio * ema_abs(torque_Nm), site->speed_rad_s, effect->speed_rad_s, effect->shape);
}
