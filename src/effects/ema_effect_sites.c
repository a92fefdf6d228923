#include "effects/ema_effect_sites.h"

#include <stddef.h>

#include "base/ema_copy.h"
#include "base/ema_math.h"
#include "effects/ema_table.h"

_Static_assert((size_t)EMA_EFFECT_COUNT <= (8U * sizeof(ema_effect_set_t)), "a set of effects has a bit for each");
_Static_assert((uint32_t)EMA_SITE_COUNT <= EMA_TABLES_BIT, "a bit for each site, and one for tables");

void ema_effects_hold(ema_plant_t* plant, const ema_effects_t* effects)
{
    ema_active_t* const active = &plant->active;
    const ema_real* value = (const ema_real*)(const void*)effects; /* EMA-D4 */
    ema_real* held = (ema_real*)(void*)&plant->effects;            /* EMA-D4 */
    uint32_t acting = 0U;
    ema_clear(active, sizeof *active);
    active->substeps = 1U;
    for (uint32_t k = 0; EMA_ROW_HELD(k); ++k) {
        const ema_effect_row_t* const row = &ema_effect_rows[k];
        const uint32_t site = row->site & (uint32_t)EMA_SITE_MASK;
        const bool table = row->site != site;
        if (*value != EMA_R(0.0)) {
            active->present[k / 32U] |= (uint32_t)1 << (k % 32U);
            active->sites |= (uint16_t)(((uint32_t)1 << site) | (table ? ((uint32_t)1 << EMA_TABLES_BIT) : 0U));
            acting += ((site != (uint32_t)EMA_SITE_PARAMETER) && (site != (uint32_t)EMA_SITE_READING)) ? 1U : 0U;
            active->substeps = (row->substeps > active->substeps) ? row->substeps : active->substeps;
        }
        if ((site != (uint32_t)EMA_SITE_PARAMETER) && !table) {
            ema_copy(held, value, row->values * sizeof(ema_real));
            held = &held[row->values];
        }
        value = &value[row->values];
    }
    active->any = acting > 0U;
    plant->forces_work = (uint8_t)EMA_WORK_FORCES(acting);
    plant->step_work = (uint8_t)(1U + (ema_acts_on_reading(plant) ? EMA_WORK_READING : 0U));
    plant->learned = (((uint32_t)active->sites >> EMA_TABLES_BIT) != 0U) ? effects : NULL;
}

/* The effects of this build that differ from zero: the first value of an effect is its size, and the list's nominal for
 * it is zero. */
static void ema_effects_present(const ema_effects_t* effects, uint32_t present[EMA_EFFECT_WORDS])
{
    const ema_real* value = (const ema_real*)(const void*)effects; /* EMA-D4 */
    for (uint32_t k = 0; k < EMA_EFFECT_WORDS; ++k) {
        present[k] = 0U;
    }
    for (uint32_t k = 0; EMA_ROW_HELD(k); ++k) {
        if (*value != EMA_R(0.0)) {
            present[k / 32U] |= (uint32_t)1 << (k % 32U);
        }
        value = &value[ema_effect_rows[k].values];
    }
}

void ema_effects_adjust(const ema_effects_t* effects, ema_params_t* params)
{
    uint32_t present[EMA_EFFECT_WORDS];
    ema_effects_present(effects, present);
/* EMA-D1, EMA-D2 */
#define EMA_ADJUST(name)                                                                                               \
    if (EMA_RUNS(present, name)) {                                                                                     \
        ema_effect_##name##_adjust(&effects->name, params);                                                            \
    }
#define EMA_EFFECT_AT_PARAMETER(name) EMA_ADJUST(name)
#include "ema/ema_effects.def"
    /* a transmission takes its mass off the total inertia, so that total must be known before */
#define EMA_EFFECT_AT_TRANSMISSION(name) EMA_ADJUST(name)
#include "ema/ema_effects.def"
}

ema_real ema_site_reading(const ema_plant_t* plant, const ema_site_t* site)
{
    const uint32_t present[] = EMA_PRESENT(plant);
    ema_real reading_mm = EMA_R(0.0);
#define EMA_EFFECT_AT_READING(name) EMA_ADD(reading_mm, name, &plant->effects.name)
#define EMA_EFFECT_AT_READING_TABLE(name) EMA_ADD(reading_mm, name, EMA_LEARNED(plant, name))
#include "ema/ema_effects.def"
    return reading_mm;
}

/* How far the tables in use are outside the range that they were seen in, the farthest of them, over that range; zero
 * inside. Tables of readings look at the rod's position. */
static ema_real ema_site_outside(const ema_plant_t* plant, const ema_state_t* state, ema_site_t* site)
{
    ema_real outside_ratio = EMA_R(0.0);
#define EMA_OUTSIDE(name, seen_mm)                                                                                     \
    if (EMA_RUNS(plant->active.present, name)) {                                                                       \
        site->position_mm = (seen_mm);                                                                                 \
        outside_ratio = ema_table_outside(EMA_TABLE_OF(EMA_LEARNED(plant, name)), site, outside_ratio);                \
    }
#define EMA_EFFECT_AT_FRICTION_TABLE(name) EMA_OUTSIDE(name, state->motor_mm)
#define EMA_EFFECT_AT_TORQUE_TABLE(name) EMA_OUTSIDE(name, state->motor_mm)
#define EMA_EFFECT_AT_VOLTAGE_TABLE(name) EMA_OUTSIDE(name, state->motor_mm)
#define EMA_EFFECT_AT_READING_TABLE(name) EMA_OUTSIDE(name, state->rod_mm)
#include "ema/ema_effects.def"
    return outside_ratio;
}

ema_real ema_site_seen(const ema_plant_t* plant, ema_state_t* state)
{
    ema_site_t site = {.plant = plant,
                       .speed_rad_s = state->speed_rad_s,
                       .angle_rad = state->angle_rad,
                       .position_mm = state->rod_mm,
                       .current_A = state->current_A};
    state->outside_ratio = ema_max(ema_site_outside(plant, state, &site), state->outside_ratio);
    if (!ema_acts(plant, EMA_SITE_READING)) {
        return EMA_R(0.0);
    }
    site.position_mm = state->rod_mm;
    return ema_site_reading(plant, &site);
}

ema_real ema_site_presliding(const ema_plant_t* plant, const ema_real* memory, ema_real turn_rad)
{
#define EMA_EFFECT_AT_PRESLIDING(name)                                                                                 \
    if (EMA_RUNS(plant->active.present, name)) {                                                                       \
        return ema_effect_##name(&plant->effects.name, turn_rad, memory[EMA_MEMORY_PLACE(name)],                       \
                                 plant->gearbox.lead_mm_per_rad);                                                      \
    }
#include "ema/ema_effects.def"
    return EMA_R(0.0);
}

void ema_site_presliding_keep(const ema_plant_t* plant, ema_real* memory, ema_real share)
{
#define EMA_EFFECT_AT_PRESLIDING(name)                                                                                 \
    if (EMA_RUNS(plant->active.present, name)) {                                                                       \
        memory[EMA_MEMORY_PLACE(name)] = share;                                                                        \
    }
#include "ema/ema_effects.def"
}

/* Adds the relative change that an effect's memory stands for. */
#define EMA_ADD_WARMTH(sum, name)                                                                                      \
    if (EMA_RUNS(plant->active.present, name)) {                                                                       \
        (sum) += ema_effect_##name(&plant->effects.name, memory[EMA_MEMORY_PLACE(name)]);                              \
    }

ema_real ema_site_winding(const ema_plant_t* plant, const ema_real* memory)
{
    ema_real change = EMA_R(0.0);
#define EMA_EFFECT_AT_WINDING(name) EMA_ADD_WARMTH(change, name)
#include "ema/ema_effects.def"
    return change;
}

ema_real ema_site_grease(const ema_plant_t* plant, const ema_real* memory)
{
    ema_real change = EMA_R(0.0);
#define EMA_EFFECT_AT_GREASE(name) EMA_ADD_WARMTH(change, name)
#include "ema/ema_effects.def"
    return change;
}

ema_real ema_site_ahead(const ema_plant_t* plant)
{
    /* the step over the winding's time constant */
    const ema_real steps = plant->step_s * plant->motor_circuit.rate_current;
    ema_real ahead = EMA_R(0.0);
    if (!plant->motor_circuit.algebraic && (steps < EMA_R(-0.1))) {
        ahead = (EMA_R(1.0) / (EMA_R(1.0) - ema_exp(steps))) + (EMA_R(1.0) / steps) - EMA_R(0.5);
    } else if (!plant->motor_circuit.algebraic) {
        /* of small steps the first term alone is left of that difference */
        ahead = steps / EMA_R(-12.0);
    } else {
        /* the current follows at once */
    }
    return ahead;
}

void ema_site_warm(const ema_plant_t* plant, ema_state_t* state, ema_real start_A, ema_real ahead, ema_real span_s)
{
    ema_real* const memory = state->effect_memory;
    const ema_real square_A2 = ema_mean_square_A2(start_A, state->current_A, ahead);
    const ema_real resistance_ohm = plant->motor.resistance_ohm * (EMA_R(1.0) + ema_site_winding(plant, memory));
    const ema_real heat_W = ema_min(resistance_ohm * square_A2, EMA_HEAT_MAX_W);
/* EMA-D2 */
#define EMA_WARM(name, heat)                                                                                           \
    if (EMA_RUNS(plant->active.present, name)) {                                                                       \
        ema_real* const place = &memory[EMA_MEMORY_PLACE(name)];                                                       \
        *place = ema_effect_##name##_warm(&plant->effects.name, *place, heat, span_s);                                 \
    }
#define EMA_EFFECT_AT_WINDING(name) EMA_WARM(name, heat_W)
#define EMA_EFFECT_AT_GREASE(name) EMA_WARM(name, EMA_R(0.0))
#include "ema/ema_effects.def"
}

void ema_site_transmission(const ema_plant_t* plant, const ema_transmission_t* step, ema_real* memory, ema_rod_t* rod)
{
    const ema_rod_t rigid = {step->play_end_mm, EMA_R(0.0), EMA_R(0.0), EMA_R(0.0)};
    *rod = rigid;
#define EMA_EFFECT_AT_TRANSMISSION(name)                                                                               \
    if (EMA_RUNS(plant->active.present, name)) {                                                                       \
        *rod = ema_effect_##name(&plant->effects.name, step, &memory[EMA_MEMORY_PLACE(name)]);                         \
    }
#include "ema/ema_effects.def"
}

void ema_site_transmission_trial(const ema_plant_t* plant, const ema_state_t* state, ema_real play_end_mm,
                                 ema_real span_s, ema_rod_t* rod)
{
    ema_real memory[EMA_EFFECT_MEMORY_LENGTH];
    for (uint32_t k = 0; k < (uint32_t)EMA_EFFECT_MEMORY_COUNT; ++k) {
        memory[k] = state->effect_memory[k];
    }
    const ema_transmission_t step = {state->play_mm, play_end_mm, span_s, plant->gearbox.lead_mm_per_rad};
    ema_site_transmission(plant, &step, memory, rod);
}
