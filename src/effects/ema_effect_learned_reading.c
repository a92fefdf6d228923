/* Error of the rod sensor that was learned against one axis. */
#include "effects/ema_effect_sites.h"
#include "effects/ema_table.h"

ema_real ema_effect_learned_reading(const ema_effect_learned_reading_t* effect, const ema_site_t* site)
{
    return ema_table_value(EMA_TABLE_OF(effect), site);
}
