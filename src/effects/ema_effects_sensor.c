/* Optional effects of the rod sensor (site READING). Equations and sources: ema/ema_effects.def; signatures of the
 * functions: ema_effect_sites.h. */
#include "effects/ema_effect_sites.h"
#include "effects/ema_table.h"

/* Error of the rod sensor that was learned against one axis. */
ema_real ema_effect_learned_reading(const ema_effect_learned_reading_t* effect, const ema_site_t* site)
{
    return ema_table_value(EMA_TABLE_OF(effect), site);
}
