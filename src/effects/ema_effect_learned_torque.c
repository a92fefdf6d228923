/* Torque on the shaft that was learned against one axis. */
#include "effects/ema_effect_sites.h"
#include "effects/ema_table.h"

ema_real ema_effect_learned_torque(const ema_effect_learned_torque_t* effect, const ema_site_t* site)
{
    return ema_table_value(EMA_TABLE_OF(effect), site);
}
