/* Torque constant and back-EMF that vary with the motor angle. */
#include "base/ema_math.h"
#include "effects/ema_effect_sites.h"

ema_real ema_effect_torque_ripple(const ema_effect_torque_ripple_t* effect, const ema_site_t* site)
{
    return effect->ratio * ema_cos((effect->periods * site->angle_rad) + effect->phase_rad);
}
