/* Pull of the magnets towards the slots, periodic in the motor angle. */
#include "base/ema_math.h"
#include "effects/ema_effect_sites.h"

ema_real ema_effect_cogging_torque(const ema_effect_cogging_torque_t* effect, const ema_site_t* site)
{
    const ema_real wave = ema_sin((effect->periods * site->angle_rad) + effect->phase_rad);
    return effect->amplitude_Nm * wave;
}
