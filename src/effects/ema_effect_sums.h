/* What the active effects of a site say at a point of the motion, summed. One place asks, so that none of it is a call.
 */
#ifndef EMA_EFFECT_SUMS_H
#define EMA_EFFECT_SUMS_H

#include "effects/ema_effect_sites.h"

static inline ema_real ema_site_friction(const ema_plant_t* plant, const ema_site_t* site, ema_real level_Nm)
{
    const uint32_t present[] = EMA_PRESENT(plant);
    ema_real change_Nm = EMA_R(0.0);
#define EMA_EFFECT_AT_FRICTION(name)                                                                                   \
    if (EMA_RUNS(present, name)) {                                                                                     \
        change_Nm += ema_effect_##name(&plant->effects.name, site, level_Nm);                                          \
    }
#define EMA_EFFECT_AT_FRICTION_TABLE(name)                                                                             \
    if (EMA_RUNS(present, name)) {                                                                                     \
        change_Nm += ema_effect_##name(EMA_LEARNED(plant, name), site, level_Nm);                                      \
    }
#include "ema/ema_effects.def"
    return change_Nm;
}

static inline ema_real ema_site_torque(const ema_plant_t* plant, const ema_site_t* site)
{
    const uint32_t present[] = EMA_PRESENT(plant);
    ema_real torque_Nm = EMA_R(0.0);
#define EMA_EFFECT_AT_TORQUE(name) EMA_ADD(torque_Nm, name, &plant->effects.name)
#define EMA_EFFECT_AT_TORQUE_TABLE(name) EMA_ADD(torque_Nm, name, EMA_LEARNED(plant, name))
#include "ema/ema_effects.def"
    return torque_Nm;
}

static inline ema_real ema_site_load(const ema_plant_t* plant, const ema_site_t* site)
{
    const uint32_t present[] = EMA_PRESENT(plant);
    ema_real load_Nm = EMA_R(0.0);
#define EMA_EFFECT_AT_LOAD(name) EMA_ADD(load_Nm, name, &plant->effects.name)
#include "ema/ema_effects.def"
    return load_Nm;
}

static inline ema_real ema_site_voltage(const ema_plant_t* plant, const ema_site_t* site)
{
    const uint32_t present[] = EMA_PRESENT(plant);
    ema_real voltage_V = EMA_R(0.0);
#define EMA_EFFECT_AT_VOLTAGE(name) EMA_ADD(voltage_V, name, &plant->effects.name)
#define EMA_EFFECT_AT_VOLTAGE_TABLE(name) EMA_ADD(voltage_V, name, EMA_LEARNED(plant, name))
#include "ema/ema_effects.def"
    return voltage_V;
}

/* Relative change of torque constant and back-EMF. */
static inline ema_real ema_site_motor(const ema_plant_t* plant, const ema_site_t* site)
{
    const uint32_t present[] = EMA_PRESENT(plant);
    ema_real change = EMA_R(0.0);
#define EMA_EFFECT_AT_MOTOR(name) EMA_ADD(change, name, &plant->effects.name)
#include "ema/ema_effects.def"
    return change;
}

#endif
