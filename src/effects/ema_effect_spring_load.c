/* Load that grows with the rod's displacement. */
#include "effects/ema_effect_sites.h"

ema_real ema_effect_spring_load(const ema_effect_spring_load_t* effect, const ema_site_t* site)
{
    return effect->stiffness_Nm_per_mm * site->position_mm;
}
