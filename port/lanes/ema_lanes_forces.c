/* ema_forces_at for all lanes at once. An effect is the function of its own file, asked lane by lane. */
#include "ema_lanes.h"

#include "ema_effect_sites.h"
#include "ema_gearbox.h"
#include "ema_motor.h"
#include "ema_screw.h"

/* What an effect may look at, of every lane. */
typedef struct {
    ema_lane_t speed_rad_s;
    ema_lane_t angle_rad;
    ema_lane_t position_mm;
    ema_lane_t current_A;
    ema_lane_t voltage_V;
    ema_lane_t direction;
} ema_lanes_site_t;

#define EMA_LANE_RUNS(name)                                                                                            \
    (((lanes->plant[0].active.present[(uint32_t)EMA_EFFECT_ID_##name / 32U] >> ((uint32_t)EMA_EFFECT_ID_##name % 32U)) \
      & 1U)                                                                                                            \
     != 0U)

/* Adds to `sum` what an effect makes of its values at the lanes' sites; `...` is what else it is given. What the
 * project's own effects look at is copied together lane by lane, which leaves nothing to do but to load it. */
#define EMA_LANES_ADD(name, ...)                                                                                       \
    if (EMA_LANE_RUNS(name)) {                                                                                         \
        EMA_EACH_LANE                                                                                                  \
        {                                                                                                              \
            const ema_plant_t plant = ema_lane_plant(lanes, l);                                                        \
            const ema_effect_##name##_t effect = ema_lane_effect_##name(lanes, l);                                     \
            const ema_site_t here = ema_lane_site(EMA_LANE_OWN(name) ? &lanes->plant[l] : &plant, site, l);            \
            sum[l] += ema_effect_##name(&effect, __VA_ARGS__);                                                         \
        }                                                                                                              \
    }
#define EMA_LANE_PLACE(name) ((size_t)offsetof(ema_held_effects_t, name) / sizeof(ema_real))
#define EMA_LANE_VALUES(name) (sizeof(ema_effect_##name##_t) / sizeof(ema_real))
/* The same for dry friction, with the effect's last value known. */
#define EMA_LANES_ADD_SHAPED(name, shape)                                                                              \
    EMA_EACH_LANE                                                                                                      \
    {                                                                                                                  \
        const ema_plant_t plant = ema_lane_plant(lanes, l);                                                            \
        ema_effect_##name##_t effect = ema_lane_effect_##name(lanes, l);                                               \
        ema_real* const value = (ema_real*)(void*)&effect;                                                             \
        const ema_site_t here = ema_lane_site(EMA_LANE_OWN(name) ? &lanes->plant[l] : &plant, site, l);                \
        value[EMA_LANE_VALUES(name) - 1U] = (shape);                                                                   \
        sum[l] += ema_effect_##name(&effect, &here, level_Nm[l]);                                                      \
    }
/* A table is read where it lies. */
#define EMA_LANES_ADD_TABLE(name, ...)                                                                                 \
    if (EMA_LANE_RUNS(name)) {                                                                                         \
        EMA_EACH_LANE                                                                                                  \
        {                                                                                                              \
            const ema_plant_t* const plant = &lanes->plant[l];                                                         \
            const ema_site_t here = ema_lane_site(plant, site, l);                                                     \
            sum[l] += ema_effect_##name(&plant->learned->name, __VA_ARGS__);                                           \
        }                                                                                                              \
    }
#define EMA_LANE_OWN(name)                                                                                             \
    ((uint32_t)EMA_EFFECT_ID_##name >= ((uint32_t)EMA_EFFECT_COUNT - (uint32_t)EMA_LANES_OWN_EFFECTS))

/* What effects look at in a plant. */
static inline ema_plant_t ema_lane_plant(const ema_lanes_t* lanes, uint32_t l)
{
    const ema_lanes_plant_t* const constant = &lanes->constant;
    const ema_plant_t plant = {
        .drive = {.supply_V = constant->supply_V[l]},
        .motor = {.torque_constant_Nm_per_A = constant->torque_constant_Nm_per_A[l],
                  .back_emf_V_s_per_rad = constant->back_emf_V_s_per_rad[l],
                  .torque_limit_Nm = constant->torque_limit_Nm[l]},
        .gearbox = {.lead_mm = constant->lead_mm[l], .lead_mm_per_rad = constant->lead_mm_per_rad[l]},
        .screw = {.inverse_inertia_per_kgm2 = constant->inverse_inertia_per_kgm2[l],
                  .viscous_Nm_s_per_rad = constant->viscous_Nm_s_per_rad[l],
                  .static_Nm = constant->static_Nm[l],
                  .dynamic_Nm = constant->dynamic_Nm[l],
                  .load_torque_Nm = constant->load_torque_Nm[l]},
    };
    return plant;
}

/* The values of an effect. */
#define EMA_LANE_EFFECT(name)                                                                                          \
    static inline ema_effect_##name##_t ema_lane_effect_##name(const ema_lanes_t* lanes, uint32_t l)                   \
    {                                                                                                                  \
        ema_effect_##name##_t effect;                                                                                  \
        ema_real* const value = (ema_real*)(void*)&effect;                                                             \
        for (size_t k = 0; k < EMA_LANE_VALUES(name); ++k) {                                                           \
            value[k] = lanes->held[EMA_LANE_PLACE(name) + k][l];                                                       \
        }                                                                                                              \
        return effect;                                                                                                 \
    }
#define EMA_EFFECT_AT_FRICTION(name) EMA_LANE_EFFECT(name)
#define EMA_EFFECT_AT_TORQUE(name) EMA_LANE_EFFECT(name)
#define EMA_EFFECT_AT_LOAD(name) EMA_LANE_EFFECT(name)
#define EMA_EFFECT_AT_VOLTAGE(name) EMA_LANE_EFFECT(name)
#define EMA_EFFECT_AT_MOTOR(name) EMA_LANE_EFFECT(name)
#define EMA_EFFECT_AT_PRESLIDING(name) EMA_LANE_EFFECT(name)
#define EMA_EFFECT_AT_TRANSMISSION(name) EMA_LANE_EFFECT(name)
#define EMA_EFFECT_AT_WINDING(name) EMA_LANE_EFFECT(name)
#define EMA_EFFECT_AT_GREASE(name) EMA_LANE_EFFECT(name)
#include "ema/ema_effects.def"

static inline ema_site_t ema_lane_site(const ema_plant_t* plant, const ema_lanes_site_t* site, uint32_t l)
{
    const ema_site_t here = {plant,
                             site->speed_rad_s[l],
                             site->angle_rad[l],
                             site->position_mm[l],
                             site->current_A[l],
                             site->voltage_V[l],
                             site->direction[l],
                             EMA_R(0.0)};
    return here;
}

/* Whether all lanes have this value. */
static bool ema_lanes_are(const ema_real* values, ema_real value)
{
    ema_lane_bit_t other = 0;
    EMA_EACH_LANE
    {
        other |= (values[l] == value) ? 0 : 1;
    }
    return other == 0;
}

static void ema_lanes_friction(const ema_lanes_t* lanes, const ema_lanes_site_t* site, const ema_lane_t level_Nm,
                               ema_lane_t sum)
{
/* A shape that all lanes have in common, 1 or 2, is given as such: of the ways that it chooses between one remains. */
#define EMA_EFFECT_AT_FRICTION(name)                                                                                   \
    if (EMA_LANE_RUNS(name)) {                                                                                         \
        const ema_real* const last = lanes->held[EMA_LANE_PLACE(name) + EMA_LANE_VALUES(name) - 1U];                   \
        if ((EMA_LANE_VALUES(name) > 2U) && ema_lanes_are(last, EMA_R(1.0))) {                                         \
            EMA_LANES_ADD_SHAPED(name, EMA_R(1.0))                                                                     \
        } else if ((EMA_LANE_VALUES(name) > 2U) && ema_lanes_are(last, EMA_R(2.0))) {                                  \
            EMA_LANES_ADD_SHAPED(name, EMA_R(2.0))                                                                     \
        } else {                                                                                                       \
            EMA_LANES_ADD(name, &here, level_Nm[l])                                                                    \
        }                                                                                                              \
    }
#define EMA_EFFECT_AT_FRICTION_TABLE(name) EMA_LANES_ADD_TABLE(name, &here, level_Nm[l])
#include "ema/ema_effects.def"
}

static void ema_lanes_torque(const ema_lanes_t* lanes, const ema_lanes_site_t* site, ema_lane_t sum)
{
#define EMA_EFFECT_AT_TORQUE(name) EMA_LANES_ADD(name, &here)
#define EMA_EFFECT_AT_TORQUE_TABLE(name) EMA_LANES_ADD_TABLE(name, &here)
#include "ema/ema_effects.def"
}

static void ema_lanes_load(const ema_lanes_t* lanes, const ema_lanes_site_t* site, ema_lane_t sum)
{
#define EMA_EFFECT_AT_LOAD(name) EMA_LANES_ADD(name, &here)
#include "ema/ema_effects.def"
}

static void ema_lanes_voltage(const ema_lanes_t* lanes, const ema_lanes_site_t* site, ema_lane_t sum)
{
#define EMA_EFFECT_AT_VOLTAGE(name) EMA_LANES_ADD(name, &here)
#define EMA_EFFECT_AT_VOLTAGE_TABLE(name) EMA_LANES_ADD_TABLE(name, &here)
#include "ema/ema_effects.def"
}

static void ema_lanes_motor(const ema_lanes_t* lanes, const ema_lanes_site_t* site, ema_lane_t sum){
#define EMA_EFFECT_AT_MOTOR(name) EMA_LANES_ADD(name, &here)
#include "ema/ema_effects.def"
}

/* Adds the relative change that an effect's memory stands for. */
#define EMA_LANES_ADD_WARMTH(name)                                                                                     \
    if (EMA_LANE_RUNS(name)) {                                                                                         \
        EMA_EACH_LANE                                                                                                  \
        {                                                                                                              \
            const ema_effect_##name##_t effect = ema_lane_effect_##name(lanes, l);                                     \
            sum[l] += ema_effect_##name(&effect, lanes->now.effect_memory[EMA_MEMORY_PLACE(name)][l]);                 \
        }                                                                                                              \
    }

static void ema_lanes_winding(const ema_lanes_t* lanes, ema_lane_t sum)
{
#define EMA_EFFECT_AT_WINDING(name) EMA_LANES_ADD_WARMTH(name)
#include "ema/ema_effects.def"
}

static void ema_lanes_grease(const ema_lanes_t* lanes, ema_lane_t sum)
{
#define EMA_EFFECT_AT_GREASE(name) EMA_LANES_ADD_WARMTH(name)
#include "ema/ema_effects.def"
}

/* ema_site_warm */
void ema_lanes_warm(ema_lanes_t* lanes, const ema_lane_t start_A)
{
    ema_lane_t heat_W;
    EMA_EACH_LANE
    {
        heat_W[l] = EMA_R(0.0);
    }
    ema_lanes_winding(lanes, heat_W);
    EMA_EACH_LANE
    {
        const ema_real square_A2 =
            ema_mean_square_A2(start_A[l], lanes->now.current_A[l], lanes->plant[l].warming_ahead_ratio);
        const ema_real resistance_ohm = lanes->constant.resistance_ohm[l] * (EMA_R(1.0) + heat_W[l]);
        heat_W[l] = ema_min(resistance_ohm * square_A2, EMA_HEAT_MAX_W);
    }
#define EMA_LANES_WARM(name, heat)                                                                                     \
    if (EMA_LANE_RUNS(name)) {                                                                                         \
        ema_real* const memory = lanes->now.effect_memory[EMA_MEMORY_PLACE(name)];                                     \
        EMA_EACH_LANE                                                                                                  \
        {                                                                                                              \
            const ema_effect_##name##_t effect = ema_lane_effect_##name(lanes, l);                                     \
            memory[l] = ema_effect_##name##_warm(&effect, memory[l], heat, lanes->constant.step_s[l]);                 \
        }                                                                                                              \
    }
#define EMA_EFFECT_AT_WINDING(name) EMA_LANES_WARM(name, heat_W[l])
#define EMA_EFFECT_AT_GREASE(name) EMA_LANES_WARM(name, EMA_R(0.0))
#include "ema/ema_effects.def"
}

void ema_lanes_presliding(const ema_lanes_t* lanes, const ema_lane_t turn_rad, ema_lane_t share)
{
#define EMA_EFFECT_AT_PRESLIDING(name)                                                                                 \
    if (EMA_LANE_RUNS(name)) {                                                                                         \
        EMA_EACH_LANE                                                                                                  \
        {                                                                                                              \
            const ema_effect_##name##_t effect = ema_lane_effect_##name(lanes, l);                                     \
            share[l] = ema_effect_##name(&effect, turn_rad[l], lanes->now.effect_memory[EMA_MEMORY_PLACE(name)][l],    \
                                         lanes->constant.lead_mm_per_rad[l]);                                          \
        }                                                                                                              \
        return;                                                                                                        \
    }
#include "ema/ema_effects.def"
}

void ema_lanes_transmission(const ema_lanes_t* lanes, const ema_lane_t play_end_mm, ema_lanes_rod_t* rod)
{
    const ema_lanes_state_t* const now = &lanes->now;
    for (uint32_t k = 0; k < (uint32_t)EMA_EFFECT_MEMORY_COUNT; ++k) {
        EMA_EACH_LANE
        {
            rod->effect_memory[k][l] = now->effect_memory[k][l];
        }
    }
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters)                            \
    EMA_LANES_BEHIND_##site(name, memory)
#define EMA_EFFECT_KEEPS(name, keeps)                                                                                  \
    if (EMA_LANE_RUNS(name)) {                                                                                         \
        EMA_EACH_LANE                                                                                                  \
        {                                                                                                              \
            const ema_effect_##name##_t effect = ema_lane_effect_##name(lanes, l);                                     \
            const ema_transmission_t step = {now->play_mm[l], play_end_mm[l], lanes->segment.span_s[l],                \
                                             lanes->constant.lead_mm_per_rad[l]};                                      \
            ema_real memory[(keeps) + 1];                                                                              \
            for (size_t k = 0; k < (size_t)(keeps); ++k) {                                                             \
                memory[k] = now->effect_memory[EMA_MEMORY_PLACE(name) + k][l];                                         \
            }                                                                                                          \
            const ema_rod_t behind = ema_effect_##name(&effect, &step, memory);                                        \
            for (size_t k = 0; k < (size_t)(keeps); ++k) {                                                             \
                rod->effect_memory[EMA_MEMORY_PLACE(name) + k][l] = memory[k];                                         \
            }                                                                                                          \
            rod->rod_mm[l] = behind.rod_mm;                                                                            \
            rod->rod_speed_mm_s[l] = behind.rod_speed_mm_s;                                                            \
            rod->reaction_start_Nm[l] = behind.reaction_start_Nm;                                                      \
            rod->reaction_end_Nm[l] = behind.reaction_end_Nm;                                                          \
        }                                                                                                              \
    }
#define EMA_LANES_BEHIND_TRANSMISSION(name, memory) EMA_EFFECT_KEEPS(name, memory)
#define EMA_LANES_BEHIND_PARAMETER(name, memory)
#define EMA_LANES_BEHIND_FRICTION(name, memory)
#define EMA_LANES_BEHIND_TORQUE(name, memory)
#define EMA_LANES_BEHIND_LOAD(name, memory)
#define EMA_LANES_BEHIND_VOLTAGE(name, memory)
#define EMA_LANES_BEHIND_MOTOR(name, memory)
#define EMA_LANES_BEHIND_PRESLIDING(name, memory)
#define EMA_LANES_BEHIND_READING(name, memory)
#define EMA_LANES_BEHIND_WINDING(name, memory)
#define EMA_LANES_BEHIND_GREASE(name, memory)
#define EMA_LANES_BEHIND_FRICTION_TABLE(name, memory)
#define EMA_LANES_BEHIND_TORQUE_TABLE(name, memory)
#define EMA_LANES_BEHIND_VOLTAGE_TABLE(name, memory)
#define EMA_LANES_BEHIND_READING_TABLE(name, memory)
#include "ema/ema_effects.def"
}

void ema_lanes_presliding_keep(ema_lanes_t* lanes, const ema_lane_t share)
{
#define EMA_EFFECT_AT_PRESLIDING(name)                                                                                 \
    if (EMA_LANE_RUNS(name)) {                                                                                         \
        ema_real* const memory = lanes->now.effect_memory[EMA_MEMORY_PLACE(name)];                                     \
        EMA_EACH_LANE                                                                                                  \
        {                                                                                                              \
            const ema_real stretches = ema_flag(lanes->now.motion[l] == (ema_real)EMA_MOTION_ELASTIC);                 \
            memory[l] = ema_choose(lanes->done[l] * stretches, share[l], memory[l]);                                   \
        }                                                                                                              \
    }
#include "ema/ema_effects.def"
}

/* What comes together at a point. */
typedef struct {
    ema_lane_t voltage_V; /* sums of the effects of a site */
    ema_lane_t load_Nm;   /* in the end of all loads */
    ema_lane_t torque_Nm;
    ema_lane_t change; /* of the torque constant */
    ema_lane_t share;  /* of the dry friction that a contact carries; 1 of one that slides */
    ema_lane_t direction;
    ema_lane_t own_Nm; /* the screw's own dry friction against that direction, and what effects add */
    ema_lane_t friction_Nm;
    ema_lane_t winding; /* relative changes of resistance, and of dry and viscous friction */
    ema_lane_t grease;
} ema_lanes_sums_t;

static inline ema_real ema_lane_level(const ema_lanes_t* lanes, uint32_t l, ema_real level_Nm, ema_real direction)
{
    const ema_screw_t screw = {.asymmetry = lanes->constant.asymmetry[l]};
    return ema_screw_level(&screw, level_Nm, direction);
}

/* Dry friction in all: ema_level. */
static inline ema_real ema_lane_friction(const ema_lanes_t* lanes, uint32_t l, ema_real load_Nm, ema_real direction,
                                         ema_real own_Nm, ema_real acts, ema_real change_Nm, ema_real warms,
                                         ema_real grease)
{
    const ema_gearbox_t gearbox = {.loss_opposing = lanes->constant.loss_opposing[l],
                                   .loss_aiding = lanes->constant.loss_aiding[l]};
    const ema_real plain_Nm = own_Nm + ema_gearbox_loss(&gearbox, load_Nm, direction);
    const ema_real eased_Nm = ema_choose(warms, plain_Nm + (grease * own_Nm), plain_Nm);
    return ema_max(ema_choose(acts, eased_Nm + change_Nm, eased_Nm), EMA_R(0.0));
}

/* The site at the point, and dry friction as the screw has it there; false when all lanes slide. */
static bool ema_lanes_site_at(const ema_lanes_t* lanes, const ema_lanes_point_t* point, ema_lanes_site_t* site,
                              ema_lanes_sums_t* sums)
{
    ema_lane_bit_t resting = 0;
    EMA_EACH_LANE
    {
        const ema_real motion = lanes->now.motion[l];
        const ema_real speed_rad_s = point->speed_rad_s[l];
        const ema_real stuck = ema_flag(motion == (ema_real)EMA_MOTION_STUCK);
        const ema_real elastic = ema_flag(motion == (ema_real)EMA_MOTION_ELASTIC);
        const ema_real backward = ema_flag(motion == (ema_real)EMA_MOTION_BACKWARD);
        const ema_real forward = ema_flag(motion == (ema_real)EMA_MOTION_FORWARD);
        const ema_real free_rad_s = ema_choose(elastic, speed_rad_s, EMA_R(0.0));
        const ema_real back_rad_s = ema_choose(backward, ema_min(speed_rad_s, EMA_R(0.0)), free_rad_s);
        const ema_real static_Nm = lanes->constant.static_Nm[l];
        const ema_real direction = ema_choose(stuck, EMA_R(1.0), motion);
        const ema_real level_Nm = ema_choose(stuck, static_Nm, lanes->constant.dynamic_Nm[l]);
        site->speed_rad_s[l] = ema_choose(forward, ema_max(speed_rad_s, EMA_R(0.0)), back_rad_s);
        site->angle_rad[l] = point->angle_rad[l];
        site->position_mm[l] = lanes->constant.lead_mm_per_rad[l] * point->angle_rad[l];
        site->current_A[l] = point->current_A[l];
        site->voltage_V[l] =
            ema_choose(lanes->applied.current_loop[l], lanes->applied.voltage_V[l], lanes->applied.input[l]);
        sums->voltage_V[l] = EMA_R(0.0);
        sums->load_Nm[l] = EMA_R(0.0);
        sums->torque_Nm[l] = EMA_R(0.0);
        sums->change[l] = EMA_R(0.0);
        sums->friction_Nm[l] = EMA_R(0.0);
        sums->winding[l] = EMA_R(0.0);
        sums->grease[l] = EMA_R(0.0);
        sums->share[l] = direction;
        sums->direction[l] = direction;
        site->direction[l] = direction;
        sums->own_Nm[l] = ema_lane_level(lanes, l, level_Nm, direction);
        resting |= (motion == (ema_real)EMA_MOTION_STUCK) ? 1 : 0;
    }
    return resting != 0;
}

/* The same of a contact that stretches before it slides. */
static void ema_lanes_contact(const ema_lanes_t* lanes, ema_lanes_site_t* site, ema_lanes_sums_t* sums)
{
    ema_lane_t turn_rad;
    EMA_EACH_LANE
    {
        turn_rad[l] = site->angle_rad[l] - lanes->now.angle_rad[l];
    }
    ema_lanes_presliding(lanes, turn_rad, sums->share);
    EMA_EACH_LANE
    {
        const ema_real direction = ema_choose(ema_flag(sums->share[l] < EMA_R(0.0)), EMA_R(-1.0), EMA_R(1.0));
        sums->direction[l] = direction;
        site->direction[l] = direction;
        sums->own_Nm[l] = ema_lane_level(lanes, l, lanes->constant.dynamic_Nm[l], direction);
    }
}

static ema_real ema_lanes_acts(const ema_lanes_t* lanes, ema_effect_site_t site)
{
    return ema_flag(ema_acts(&lanes->plant[0], site));
}

/* At which sites something acts, as flags; and whether dry friction slides, or stretches a contact. */
typedef struct {
    ema_real voltage;
    ema_real load;
    ema_real torque;
    ema_real motor;
    ema_real friction;
    ema_real slides;
    ema_real winding;
    ema_real grease;
} ema_lanes_on_t;

/* What holds lanes at rest against going backward. */
static void ema_lanes_backward(ema_lanes_t* lanes, ema_lanes_site_t* site, ema_lanes_sums_t* sums, ema_lanes_on_t on)
{
    ema_lane_t own_Nm;
    EMA_EACH_LANE
    {
        own_Nm[l] = ema_lane_level(lanes, l, lanes->constant.static_Nm[l], EMA_R(-1.0));
        site->direction[l] = EMA_R(-1.0);
        sums->friction_Nm[l] = EMA_R(0.0);
    }
    if (on.friction != EMA_R(0.0)) {
        ema_lanes_friction(lanes, site, own_Nm, sums->friction_Nm);
    }
    EMA_EACH_LANE
    {
        const ema_real stuck = ema_flag(lanes->now.motion[l] == (ema_real)EMA_MOTION_STUCK);
        const ema_real backward_Nm = ema_lane_friction(lanes, l, sums->load_Nm[l], EMA_R(-1.0), own_Nm[l], on.friction,
                                                       sums->friction_Nm[l], on.grease, sums->grease[l]);
        lanes->forces.level_backward_Nm[l] = ema_choose(stuck, backward_Nm, EMA_R(0.0));
    }
}

/* All together. Inlined, so that what does not act is not there where the flags are known. */
static inline void ema_lanes_total(ema_lanes_t* lanes, const ema_lanes_point_t* point, const ema_lanes_site_t* site,
                                   ema_lanes_sums_t* sums, ema_lanes_on_t on)
{
    ema_lanes_forces_t* const forces = &lanes->forces;
    EMA_EACH_LANE
    {
        const ema_motor_t motor = {.torque_constant_Nm_per_A = lanes->constant.torque_constant_Nm_per_A[l],
                                   .torque_limit_Nm = lanes->constant.torque_limit_Nm[l]};
        const ema_real stuck = ema_flag(lanes->now.motion[l] == (ema_real)EMA_MOTION_STUCK) * on.slides;
        const ema_real by_voltage = ema_not(lanes->applied.current_loop[l]);
        const ema_real own_load_Nm = lanes->constant.load_torque_Nm[l];
        const ema_real load_Nm = ema_choose(on.load, own_load_Nm + sums->load_Nm[l], own_load_Nm);
        const ema_real pushed_Nm = ema_choose(on.torque, -load_Nm + sums->torque_Nm[l], -load_Nm);
        const ema_real eased_Nm = (sums->grease[l] * lanes->constant.viscous_Nm_s_per_rad[l]) * site->speed_rad_s[l];
        const ema_real free_Nm = ema_choose(on.grease, pushed_Nm - eased_Nm, pushed_Nm);
        const ema_real changed_A = (EMA_R(1.0) + sums->change[l]) * site->current_A[l];
        const ema_real change_Nm = ema_motor_torque(&motor, changed_A) - ema_motor_torque(&motor, site->current_A[l]);
        const ema_real torque_Nm = ema_choose(on.motor, free_Nm + change_Nm, free_Nm);
        const ema_real friction_Nm = ema_lane_friction(lanes, l, load_Nm, sums->direction[l], sums->own_Nm[l],
                                                       on.friction, sums->friction_Nm[l], on.grease, sums->grease[l]);
        const ema_real own_input = lanes->applied.input[l];
        const ema_real fed_input = ema_choose(on.voltage * by_voltage, own_input + sums->voltage_V[l], own_input);
        const ema_real lost_V = (sums->winding[l] * lanes->constant.resistance_ohm[l]) * site->current_A[l];
        const ema_real input = ema_choose(on.winding * by_voltage, fed_input - lost_V, fed_input);
        const ema_real emf_V = sums->change[l] * lanes->constant.back_emf_V_s_per_rad[l] * point->speed_rad_s[l];
        forces->input[l] = ema_choose(on.motor * by_voltage, input - emf_V, input);
        forces->torque_Nm[l] = ema_choose(stuck, torque_Nm, torque_Nm + (-sums->share[l] * friction_Nm));
        forces->level_forward_Nm[l] = ema_choose(stuck, friction_Nm, EMA_R(0.0));
        forces->level_backward_Nm[l] = EMA_R(0.0);
        sums->load_Nm[l] = load_Nm;
    }
}

void ema_lanes_forces_at(ema_lanes_t* lanes, const ema_lanes_point_t* point)
{
    const ema_lanes_on_t on = {
        ema_lanes_acts(lanes, EMA_SITE_VOLTAGE),  ema_lanes_acts(lanes, EMA_SITE_LOAD),
        ema_lanes_acts(lanes, EMA_SITE_TORQUE),   ema_lanes_acts(lanes, EMA_SITE_MOTOR),
        ema_lanes_acts(lanes, EMA_SITE_FRICTION), ema_not(ema_lanes_acts(lanes, EMA_SITE_PRESLIDING)),
        ema_lanes_acts(lanes, EMA_SITE_WINDING),  ema_lanes_acts(lanes, EMA_SITE_GREASE)};
    const ema_real warms = on.winding + on.grease;
    const ema_real alone = on.voltage + on.load + on.torque + on.motor + on.friction + ema_not(on.slides);
    ema_lanes_site_t site;
    ema_lanes_sums_t sums;
    bool resting = ema_lanes_site_at(lanes, point, &site, &sums);
    if (on.slides == EMA_R(0.0)) {
        resting = false;
        ema_lanes_contact(lanes, &site, &sums);
    }
    if (on.voltage != EMA_R(0.0)) {
        ema_lanes_voltage(lanes, &site, sums.voltage_V);
    }
    if (on.load != EMA_R(0.0)) {
        ema_lanes_load(lanes, &site, sums.load_Nm);
    }
    if (on.torque != EMA_R(0.0)) {
        ema_lanes_torque(lanes, &site, sums.torque_Nm);
    }
    if (on.motor != EMA_R(0.0)) {
        ema_lanes_motor(lanes, &site, sums.change);
    }
    if (on.friction != EMA_R(0.0)) {
        ema_lanes_friction(lanes, &site, sums.own_Nm, sums.friction_Nm);
    }
    if (warms != EMA_R(0.0)) {
        ema_lanes_winding(lanes, sums.winding);
        ema_lanes_grease(lanes, sums.grease);
    }
    /* one effect at a time is what the tools ask for most */
    if ((alone + (EMA_R(2.0) * warms)) > EMA_R(1.0)) {
        ema_lanes_total(lanes, point, &site, &sums, on);
    } else if (on.voltage != EMA_R(0.0)) {
        ema_lanes_total(lanes, point, &site, &sums, (ema_lanes_on_t){.voltage = EMA_R(1.0), .slides = EMA_R(1.0)});
    } else if (on.load != EMA_R(0.0)) {
        ema_lanes_total(lanes, point, &site, &sums, (ema_lanes_on_t){.load = EMA_R(1.0), .slides = EMA_R(1.0)});
    } else if (on.torque != EMA_R(0.0)) {
        ema_lanes_total(lanes, point, &site, &sums, (ema_lanes_on_t){.torque = EMA_R(1.0), .slides = EMA_R(1.0)});
    } else if (on.motor != EMA_R(0.0)) {
        ema_lanes_total(lanes, point, &site, &sums, (ema_lanes_on_t){.motor = EMA_R(1.0), .slides = EMA_R(1.0)});
    } else if (on.friction != EMA_R(0.0)) {
        ema_lanes_total(lanes, point, &site, &sums, (ema_lanes_on_t){.friction = EMA_R(1.0), .slides = EMA_R(1.0)});
    } else {
        ema_lanes_total(lanes, point, &site, &sums, (ema_lanes_on_t){.slides = on.slides});
    }
    if (resting) {
        ema_lanes_backward(lanes, &site, &sums, on);
    }
}
