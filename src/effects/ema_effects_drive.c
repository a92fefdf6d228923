/* Optional effects of drive and motor (sites VOLTAGE and MOTOR). Equations and sources: ema/ema_effects.def; signatures
 * of the functions: ema_effect_sites.h. */
#include "base/ema_math.h"
#include "effects/ema_effect_sites.h"
#include "effects/ema_table.h"

/* Voltage that the inverter's dead time takes off against the current, smooth near zero current. */
ema_real ema_effect_inverter_dead_time(const ema_effect_inverter_dead_time_t* effect, const ema_site_t* site)
{
    const ema_real current_A = site->current_A;
    return -effect->drop_V * (current_A / ema_sqrt((current_A * current_A) + (effect->width_A * effect->width_A)));
}

/* Bus voltage that falls with the current drawn: the motor sees the same share of less. */
ema_real ema_effect_source_resistance(const ema_effect_source_resistance_t* effect, const ema_site_t* site)
{
    return -effect->resistance_ohm * ema_abs(site->current_A) * (site->voltage_V / site->plant->drive.supply_V);
}

/* Change of the motor voltage that was learned against one axis. */
ema_real ema_effect_learned_voltage(const ema_effect_learned_voltage_t* effect, const ema_site_t* site)
{
    return ema_table_value(EMA_TABLE_OF(effect), site);
}

/* Torque constant and back-EMF that vary with the motor angle. */
ema_real ema_effect_torque_ripple(const ema_effect_torque_ripple_t* effect, const ema_site_t* site)
{
    return effect->ratio * ema_cos((effect->periods * site->angle_rad) + effect->phase_rad);
}
