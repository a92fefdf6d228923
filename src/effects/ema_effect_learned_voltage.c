/* Change of the motor voltage that was learned against one axis. */
#include "effects/ema_effect_sites.h"
#include "effects/ema_table.h"

ema_real ema_effect_learned_voltage(const ema_effect_learned_voltage_t* effect, const ema_site_t* site)
{
    return ema_table_value(EMA_TABLE_OF(effect), site);
}
