/* Voltage that the inverter's dead time takes off against the current, smooth near zero current. */
#include "base/ema_math.h"
#include "effects/ema_effect_sites.h"

ema_real ema_effect_inverter_dead_time(const ema_effect_inverter_dead_time_t* effect, const ema_site_t* site)
{
    const ema_real current_A = site->current_A;
    return -effect->drop_V * (current_A / ema_sqrt((current_A * current_A) + (effect->width_A * effect->width_A)));
}
