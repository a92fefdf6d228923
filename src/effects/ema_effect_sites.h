/* Where optional effects act. Declared and dispatched from the rows of ema_effects.def alone: a new effect is one row
 * and one function of its site.
 */
#ifndef EMA_EFFECT_SITES_H
#define EMA_EFFECT_SITES_H

#include <stddef.h>

#include "base/ema_choice.h"
#include "base/ema_effect_rows.h"
#include "effects/ema_site.h"
#include "ema/detail/ema_step_scratch.h"

/* The function that an effect supplies, by site. */
#define EMA_EFFECT_AT_PARAMETER(name)                                                                                  \
    void ema_effect_##name##_adjust(const ema_effect_##name##_t* effect, ema_params_t* params);
#define EMA_EFFECT_AT_FRICTION(name)                                                                                   \
    ema_real ema_effect_##name(const ema_effect_##name##_t* effect, const ema_site_t* site, ema_real level_Nm);
#define EMA_EFFECT_AT_TORQUE(name)                                                                                     \
    ema_real ema_effect_##name(const ema_effect_##name##_t* effect, const ema_site_t* site);
#define EMA_EFFECT_AT_LOAD(name)                                                                                       \
    ema_real ema_effect_##name(const ema_effect_##name##_t* effect, const ema_site_t* site);
#define EMA_EFFECT_AT_VOLTAGE(name)                                                                                    \
    ema_real ema_effect_##name(const ema_effect_##name##_t* effect, const ema_site_t* site);
#define EMA_EFFECT_AT_MOTOR(name)                                                                                      \
    ema_real ema_effect_##name(const ema_effect_##name##_t* effect, const ema_site_t* site);
#define EMA_EFFECT_AT_PRESLIDING(name)                                                                                 \
    ema_real ema_effect_##name(const ema_effect_##name##_t* effect, ema_real turn_rad, ema_real stretch,               \
                               ema_real lead_mm_per_rad);
#define EMA_EFFECT_AT_TRANSMISSION(name)                                                                               \
    void ema_effect_##name##_adjust(const ema_effect_##name##_t* effect, ema_params_t* params);                        \
    ema_rod_t ema_effect_##name(const ema_effect_##name##_t* effect, const ema_transmission_t* step, ema_real* memory);
#define EMA_EFFECT_AT_FRICTION_TABLE(name) EMA_EFFECT_AT_FRICTION(name)
#define EMA_EFFECT_AT_TORQUE_TABLE(name) EMA_EFFECT_AT_TORQUE(name)
#define EMA_EFFECT_AT_VOLTAGE_TABLE(name) EMA_EFFECT_AT_VOLTAGE(name)
#define EMA_EFFECT_AT_READING(name)                                                                                    \
    ema_real ema_effect_##name(const ema_effect_##name##_t* effect, const ema_site_t* site);
#define EMA_EFFECT_AT_READING_TABLE(name) EMA_EFFECT_AT_READING(name)
#define EMA_EFFECT_AT_WINDING(name) EMA_EFFECT_THAT_WARMS(name)
#define EMA_EFFECT_AT_GREASE(name) EMA_EFFECT_THAT_WARMS(name)
/* The relative change that its memory stands for, and the memory after `span_s` in which `heat_W` was lost in it. */
#define EMA_EFFECT_THAT_WARMS(name)                                                                                    \
    ema_real ema_effect_##name(const ema_effect_##name##_t* effect, ema_real memory);                                  \
    ema_real ema_effect_##name##_warm(const ema_effect_##name##_t* effect, ema_real memory, ema_real heat_W,           \
                                      ema_real span_s);
#include "ema/ema_effects.def"
#undef EMA_EFFECT_THAT_WARMS

/* The places of effects with state, one after the other. */
typedef struct {
/* EMA-D1 */
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters) ema_real name[(memory) + 1];
#include "ema/ema_effects.def"
} ema_memory_shape_t;

/* EMA-D2 */
#define EMA_MEMORY_PLACE(name)                                                                                         \
    (((size_t)offsetof(ema_memory_shape_t, name) / sizeof(ema_real)) - (size_t)EMA_EFFECT_ID_##name)

/* Whether an effect acts in this run; known beforehand of one that this build leaves out, so that nothing of it is
 * compiled. */
#define EMA_RUNS(words, name)                                                                                          \
    ((EMA_HAS_##name != 0)                                                                                             \
     && ((((words)[(uint32_t)EMA_EFFECT_ID_##name / 32U] >> ((uint32_t)EMA_EFFECT_ID_##name % 32U)) & 1U) != 0U))

/* A copy of these words, since each call would have them read again. */
#define EMA_PRESENT(plant) {(plant)->active.present[0], (plant)->active.present[EMA_EFFECT_WORDS - 1U]}
_Static_assert(EMA_EFFECT_WORDS <= 2U, "the copy has two words");

/* A learned table lies where the configuration does. */
#define EMA_LEARNED(plant, name) (&(plant)->learned->name)

/* Adds what an effect at a site makes of its values. */
#define EMA_ADD(sum, name, values)                                                                                     \
    if (EMA_RUNS(present, name)) {                                                                                     \
        (sum) += ema_effect_##name(values, site);                                                                      \
    }

/* Before the run: what those at site PARAMETER make of the parameters. */
void ema_effects_adjust(const ema_effects_t* effects, ema_params_t* params);
/* Gives the plant the sets of effects that differ from zero, the substeps that they need, and the values that they look
 * at while it runs. */
void ema_effects_hold(ema_plant_t* plant, const ema_effects_t* effects);

/* Whether effects act at a site of those that they act at; constant where the build has none there. */
static inline bool ema_acts_among(uint32_t sites, ema_effect_site_t site)
{
    return ((((uint32_t)EMA_SITES_HELD & sites) >> (uint32_t)site) & 1U) != 0U;
}

/* The same of this plant's. */
static inline bool ema_acts(const ema_plant_t* plant, ema_effect_site_t site)
{
    return ema_acts_among(plant->active.sites, site);
}

/* Whether any acts on the motion. */
static inline bool ema_acts_on_motion(const ema_plant_t* plant)
{
    return (((uint32_t)EMA_SITES_HELD
             & ~(((uint32_t)1 << (uint32_t)EMA_SITE_PARAMETER) | ((uint32_t)1 << (uint32_t)EMA_SITE_READING)))
            != 0U)
           && plant->active.any;
}

/* Whether a model step is tried in one: for an effect, or for a drive that is late. */
static inline bool ema_tries_whole(const ema_plant_t* plant)
{
    return ((EMA_SITES_HELD != 0) || (EMA_ONLY_VOLTAGE == 0)) && plant->tries_whole_step;
}

/* Whether any keeps a temperature. */
static inline bool ema_acts_by_warmth(const ema_plant_t* plant)
{
    const uint32_t asked = (uint32_t)EMA_SITES_HELD
                           & (((uint32_t)1 << (uint32_t)EMA_SITE_WINDING) | ((uint32_t)1 << (uint32_t)EMA_SITE_GREASE));
    return ((uint32_t)plant->active.sites & asked) != 0U;
}

/* Whether the dry friction of a shaft that keeps its direction changes on the way. */
static inline bool ema_friction_varies(uint32_t sites)
{
    const uint32_t asked = (uint32_t)EMA_SITES_HELD
                           & (((uint32_t)1 << (uint32_t)EMA_SITE_FRICTION) | ((uint32_t)1 << (uint32_t)EMA_SITE_LOAD)
                              | ((uint32_t)1 << (uint32_t)EMA_SITE_PRESLIDING));
    return (sites & asked) != 0U;
}

/* Whether laws of dry friction are all that acts while the model runs, and none of them is a table. */
static inline bool ema_friction_alone(const ema_plant_t* plant)
{
    const uint32_t apart = ((uint32_t)1 << (uint32_t)EMA_SITE_PARAMETER) | ((uint32_t)1 << (uint32_t)EMA_SITE_READING);
    const uint32_t friction = (uint32_t)1 << (uint32_t)EMA_SITE_FRICTION;
    return (plant->active.sites | apart) == (friction | apart);
}

/* Whether something adds to the rod sensor's reading, or a learned table acts: how far it is used is watched there. */
static inline bool ema_acts_on_reading(const ema_plant_t* plant)
{
    const uint32_t asked = ((uint32_t)EMA_SITES_HELD & ((uint32_t)1 << (uint32_t)EMA_SITE_READING))
                           | ((EMA_TABLES_HELD != 0) ? ((uint32_t)1 << EMA_TABLES_BIT) : 0U);
    return ((uint32_t)plant->active.sites & asked) != 0U;
}

/* What they say at a point of the motion: ema_effect_sums.h. */
/* Share of dry friction, -1 to 1, that the contact carries after a turn from the share that `memory` holds; without
 * changing it. Of several such effects the first of the list. */
ema_real ema_site_presliding(const ema_plant_t* plant, const ema_real* memory, ema_real turn_rad);
/* Keeps that share. */
void ema_site_presliding_keep(const ema_plant_t* plant, ema_real* memory, ema_real share);
/* Relative change of the winding's resistance, and of dry and viscous friction together. */
ema_real ema_site_winding(const ema_plant_t* plant, const ema_real* memory);
ema_real ema_site_grease(const ema_plant_t* plant, const ema_real* memory);
/* After a span in which the current was `start_A` at first; its mean lies beyond the middle of its ends by the share
 * `ahead` of its change. */
void ema_site_warm(const ema_plant_t* plant, ema_state_t* state, ema_real start_A, ema_real ahead, ema_real span_s);
/* That share in a step of a motor at a voltage that is held: the winding's own answer, at first the fastest. */
ema_real ema_site_ahead(const ema_plant_t* plant);
/* No winding loses more; a model that runs away stays finite here, until its current tells. */
#define EMA_HEAT_MAX_W EMA_R(1.0e9)

/* Mean square of such a current. */
static inline ema_real ema_mean_square_A2(ema_real start_A, ema_real end_A, ema_real ahead)
{
    const ema_real bow_A = ahead * (end_A - start_A);
    /* of a parabola with these ends and that mean */
    return (((start_A * start_A) + (start_A * end_A) + (end_A * end_A)) / EMA_R(3.0))
           + (bow_A * (start_A + end_A + (EMA_R(1.2) * bow_A)));
}
/* What the rod sensor reads on top; the site's position is the rod's. */
ema_real ema_site_reading(const ema_plant_t* plant, const ema_site_t* site);
/* The same at this state, in which it keeps how far learned tables are used outside the range that they were seen in.
 */
ema_real ema_site_seen(const ema_plant_t* plant, ema_state_t* state);
void ema_site_transmission(const ema_plant_t* plant, const ema_transmission_t* step, ema_real* memory, ema_rod_t* rod);
/* The same from the state, which it leaves as it is, to the end `play_end_mm` of the play. */
void ema_site_transmission_trial(const ema_plant_t* plant, const ema_state_t* state, ema_real play_end_mm,
                                 ema_real span_s, ema_rod_t* rod);

#endif
