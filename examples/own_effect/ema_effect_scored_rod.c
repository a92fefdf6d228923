/* A scored rod: the seal drags on the scored length that is drawn in, in both directions of motion. */
#include "base/ema_math.h"
#include "effects/ema_effect_sites.h"

ema_real ema_effect_scored_rod(const ema_effect_scored_rod_t* effect, const ema_site_t* site, ema_real level_Nm)
{
    const ema_real drawn_in_mm = effect->start_mm - site->position_mm;
    (void)level_Nm;
    return (drawn_in_mm > EMA_R(0.0)) ? effect->drag_Nm_per_mm * drawn_in_mm : EMA_R(0.0);
}
