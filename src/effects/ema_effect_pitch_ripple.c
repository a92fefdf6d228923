/* Dry friction that varies once per lead of the screw. */
#include "base/ema_math.h"
#include "effects/ema_effect_sites.h"

ema_real ema_effect_pitch_ripple(const ema_effect_pitch_ripple_t* effect, const ema_site_t* site, ema_real level_Nm)
{
    const ema_real lead_mm = site->plant->gearbox.lead_mm;
    return level_Nm * effect->ratio * ema_sin(((site->position_mm / lead_mm) * EMA_TURN_RAD) + effect->phase_rad);
}
