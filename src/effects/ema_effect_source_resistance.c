/* Bus voltage that falls with the current drawn: the motor sees the same share of less. */
#include "base/ema_math.h"
#include "effects/ema_effect_sites.h"

ema_real ema_effect_source_resistance(const ema_effect_source_resistance_t* effect, const ema_site_t* site)
{
    return -effect->resistance_ohm * ema_abs(site->current_A) * (site->voltage_V / site->plant->drive.supply_V);
}
