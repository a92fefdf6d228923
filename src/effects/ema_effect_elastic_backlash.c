/* Dry friction behind a play with elastic ends, exact for a turn in one direction.
 *
 * The share of friction that is carried says where the shaft stands in the play, so that it is the whole memory: inside
 * the gap it runs over a part of the friction that nothing tells from none.
 */
#include "base/ema_math.h"
#include "effects/ema_effect_sites.h"

#define EMA_IN_GAP EMA_R(1.0e-5)

ema_real ema_effect_elastic_backlash(const ema_effect_elastic_backlash_t* effect, ema_real turn_rad, ema_real stretch,
                                     ema_real lead_mm_per_rad)
{
    const ema_real half_mm = EMA_R(0.5) * effect->gap_mm;
    const ema_real share_per_mm = (EMA_R(1.0) - EMA_IN_GAP) / effect->contact_mm;
    const ema_real carried = ema_abs(stretch);
    const ema_real from_middle_mm = (ema_min(carried, EMA_IN_GAP) * (half_mm / EMA_IN_GAP))
                                    + (ema_max(carried - EMA_IN_GAP, EMA_R(0.0)) / share_per_mm);
    const ema_real place_mm =
        ((stretch < EMA_R(0.0)) ? -from_middle_mm : from_middle_mm) + (turn_rad * lead_mm_per_rad);
    const ema_real away_mm = ema_abs(place_mm);
    const ema_real share =
        (ema_min(away_mm, half_mm) * (EMA_IN_GAP / half_mm)) + (ema_max(away_mm - half_mm, EMA_R(0.0)) * share_per_mm);
    const ema_real within = ema_min(share, EMA_R(1.0));
    return (place_mm < EMA_R(0.0)) ? -within : within;
}
