/* Dry friction that was learned against one axis. */
#include "effects/ema_effect_sites.h"
#include "effects/ema_table.h"

ema_real ema_effect_learned_friction(const ema_effect_learned_friction_t* effect, const ema_site_t* site,
                                     ema_real level_Nm)
{
    (void)level_Nm;
    return ema_table_value(EMA_TABLE_OF(effect), site);
}
