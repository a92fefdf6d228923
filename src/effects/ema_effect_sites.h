/* Where optional effects act. Declared and dispatched from the rows of ema_effects.def alone: a new effect is one row
 * and one file with the function of its site.
 */
#ifndef EMA_EFFECT_SITES_H
#define EMA_EFFECT_SITES_H

#include "ema/ema_work.h"
#include "ema_effect_rows.h"

/* What an effect may look at, all at the same instant. */
typedef struct {
    const ema_plant_t* plant;
    ema_real speed_rad_s; /* motor shaft */
    ema_real angle_rad;
    ema_real position_mm; /* motor position expressed at the rod */
    ema_real current_A;
    ema_real voltage_V; /* applied by the drive */
} ema_site_t;

/* One integration step of what lies behind the play. */
typedef struct {
    ema_real play_start_mm; /* output of the play at the start and at the end of the step */
    ema_real play_end_mm;
    ema_real step_s;
    ema_real lead_mm_per_rad;
} ema_transmission_t;

/* The function that an effect's file supplies, by site. */
#define EMA_DECLARE_PARAMETER(name)                                                                                    \
    void ema_effect_##name##_adjust(const ema_effect_##name##_t* effect, ema_params_t* params);
#define EMA_DECLARE_FRICTION(name)                                                                                     \
    ema_real ema_effect_##name(const ema_effect_##name##_t* effect, const ema_site_t* site, ema_real level_Nm);
#define EMA_DECLARE_TORQUE(name)                                                                                       \
    ema_real ema_effect_##name(const ema_effect_##name##_t* effect, const ema_site_t* site);
#define EMA_DECLARE_LOAD(name) ema_real ema_effect_##name(const ema_effect_##name##_t* effect, const ema_site_t* site);
#define EMA_DECLARE_VOLTAGE(name)                                                                                      \
    ema_real ema_effect_##name(const ema_effect_##name##_t* effect, const ema_site_t* site);
#define EMA_DECLARE_MOTOR(name) ema_real ema_effect_##name(const ema_effect_##name##_t* effect, const ema_site_t* site);
#define EMA_DECLARE_PRESLIDING(name)                                                                                   \
    ema_real ema_effect_##name(const ema_effect_##name##_t* effect, ema_real stretch, ema_real turn_rad);
#define EMA_DECLARE_TRANSMISSION(name)                                                                                 \
    void ema_effect_##name##_adjust(const ema_effect_##name##_t* effect, ema_params_t* params);                        \
    ema_rod_t ema_effect_##name(const ema_effect_##name##_t* effect, const ema_transmission_t* step, ema_real* memory);
#define EMA_DECLARE_FRICTION_TABLE(name) EMA_DECLARE_FRICTION(name)
#define EMA_DECLARE_TORQUE_TABLE(name) EMA_DECLARE_TORQUE(name)
#define EMA_DECLARE_VOLTAGE_TABLE(name) EMA_DECLARE_VOLTAGE(name)
#define EMA_DECLARE_READING_TABLE(name)                                                                                \
    ema_real ema_effect_##name(const ema_effect_##name##_t* effect, const ema_site_t* site);
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters) EMA_DECLARE_##site(name)
#include "ema/ema_effects.def"
#undef EMA_EFFECT
#undef EMA_DECLARE_PARAMETER
#undef EMA_DECLARE_FRICTION
#undef EMA_DECLARE_TORQUE
#undef EMA_DECLARE_LOAD
#undef EMA_DECLARE_VOLTAGE
#undef EMA_DECLARE_MOTOR
#undef EMA_DECLARE_PRESLIDING
#undef EMA_DECLARE_TRANSMISSION
#undef EMA_DECLARE_FRICTION_TABLE
#undef EMA_DECLARE_TORQUE_TABLE
#undef EMA_DECLARE_VOLTAGE_TABLE
#undef EMA_DECLARE_READING_TABLE

/* Before the run: what those at site PARAMETER make of the parameters. */
void ema_effects_adjust(const ema_effects_t* effects, ema_params_t* params);
/* Gives the plant the sets of effects that differ from zero, the substeps that they need, and the values that they look
 * at while it runs. */
void ema_effects_hold(ema_plant_t* plant, const ema_effects_t* effects);

/* Whether effects act at a site of this plant; constant where the build has none there. */
static inline bool ema_acts(const ema_plant_t* plant, ema_effect_site_t site)
{
    return ((((uint32_t)EMA_SITES_HELD >> (uint32_t)site) & 1U) != 0U) && (plant->active.at[site] != 0U);
}

/* Whether any acts on the motion, and whether a learned table acts. */
static inline bool ema_acts_on_motion(const ema_plant_t* plant)
{
    return (((uint32_t)EMA_SITES_HELD
             & ~(((uint32_t)1 << (uint32_t)EMA_SITE_PARAMETER) | ((uint32_t)1 << (uint32_t)EMA_SITE_READING)))
            != 0U)
           && plant->active.any;
}

static inline bool ema_acts_by_table(const ema_plant_t* plant)
{
    return (EMA_TABLES_HELD != 0) && (plant->active.tables != 0U);
}

/* While it runs: the sum over the active effects of a site. */
ema_real ema_site_friction(const ema_plant_t* plant, const ema_site_t* site, ema_real level_Nm);
ema_real ema_site_torque(const ema_plant_t* plant, const ema_site_t* site);
ema_real ema_site_load(const ema_plant_t* plant, const ema_site_t* site);
ema_real ema_site_voltage(const ema_plant_t* plant, const ema_site_t* site);
/* Relative change of torque constant and back-EMF. */
ema_real ema_site_motor(const ema_plant_t* plant, const ema_site_t* site);
/* Share of dry friction, -1 to 1, that the contact carries after a turn from the share that `memory` holds; without
 * changing it. */
ema_real ema_site_presliding(const ema_plant_t* plant, const ema_real* memory, ema_real turn_rad);
/* Keeps that share. */
void ema_site_presliding_keep(const ema_plant_t* plant, ema_real* memory, ema_real share);
/* What the rod sensor reads on top; the site's position is the rod's. */
ema_real ema_site_reading(const ema_plant_t* plant, const ema_site_t* site);
/* What learned tables add to the rod sensor's reading at this state; keeps in it how far tables are used outside the
 * range that they were seen in. */
ema_real ema_site_learned(const ema_plant_t* plant, ema_state_t* state);
void ema_site_transmission(const ema_plant_t* plant, const ema_transmission_t* step, ema_real* memory, ema_rod_t* rod);
/* The same from the state, which it leaves as it is, to the end `play_end_mm` of the play. */
void ema_site_transmission_trial(const ema_plant_t* plant, const ema_state_t* state, ema_real play_end_mm,
                                 ema_real span_s, ema_rod_t* rod);

#endif
