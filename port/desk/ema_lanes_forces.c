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
} ema_lanes_site_t;

#define EMA_LANE_RUNS(acts_at, name)                                                                                   \
    ((lanes->plant[0].active.at[acts_at] & ((ema_effect_set_t)1 << (uint32_t)EMA_EFFECT_ID_##name)) != 0U)

/* Adds to `sum` what an effect makes of its values at the lanes' sites; `...` is what else it is given. */
#define EMA_LANES_ADD(acts_at, name, values, ...)                                                                      \
    if (EMA_LANE_RUNS(acts_at, name)) {                                                                                \
        EMA_EACH_LANE                                                                                                  \
        {                                                                                                              \
            const ema_plant_t* const plant = &lanes->plant[l];                                                         \
            const ema_site_t here = ema_lane_site(plant, site, l);                                                     \
            sum[l] += ema_effect_##name(values, __VA_ARGS__);                                                          \
        }                                                                                                              \
    }
#define EMA_LANE_HELD(name) (&plant->effects.name)
#define EMA_LANE_LEARNED(name) (&plant->learned->name)

static inline ema_site_t ema_lane_site(const ema_plant_t* plant, const ema_lanes_site_t* site, uint32_t l)
{
    const ema_site_t here = {plant,
                             site->speed_rad_s[l],
                             site->angle_rad[l],
                             site->position_mm[l],
                             site->current_A[l],
                             site->voltage_V[l]};
    return here;
}

static void ema_lanes_none(ema_lane_t sum)
{
    EMA_EACH_LANE
    {
        sum[l] = EMA_R(0.0);
    }
}

static void ema_lanes_friction(const ema_lanes_t* lanes, const ema_lanes_site_t* site, const ema_lane_t level_Nm,
                               ema_lane_t sum)
{
    ema_lanes_none(sum);
#define EMA_EFFECT_AT_FRICTION(name) EMA_LANES_ADD(EMA_SITE_FRICTION, name, EMA_LANE_HELD(name), &here, level_Nm[l])
#define EMA_EFFECT_AT_FRICTION_TABLE(name)                                                                             \
    EMA_LANES_ADD(EMA_SITE_FRICTION, name, EMA_LANE_LEARNED(name), &here, level_Nm[l])
#include "ema/ema_effects.def"
}

static void ema_lanes_torque(const ema_lanes_t* lanes, const ema_lanes_site_t* site, ema_lane_t sum)
{
    ema_lanes_none(sum);
#define EMA_EFFECT_AT_TORQUE(name) EMA_LANES_ADD(EMA_SITE_TORQUE, name, EMA_LANE_HELD(name), &here)
#define EMA_EFFECT_AT_TORQUE_TABLE(name) EMA_LANES_ADD(EMA_SITE_TORQUE, name, EMA_LANE_LEARNED(name), &here)
#include "ema/ema_effects.def"
}

static void ema_lanes_load(const ema_lanes_t* lanes, const ema_lanes_site_t* site, ema_lane_t sum)
{
    ema_lanes_none(sum);
#define EMA_EFFECT_AT_LOAD(name) EMA_LANES_ADD(EMA_SITE_LOAD, name, EMA_LANE_HELD(name), &here)
#include "ema/ema_effects.def"
}

static void ema_lanes_voltage(const ema_lanes_t* lanes, const ema_lanes_site_t* site, ema_lane_t sum)
{
    ema_lanes_none(sum);
#define EMA_EFFECT_AT_VOLTAGE(name) EMA_LANES_ADD(EMA_SITE_VOLTAGE, name, EMA_LANE_HELD(name), &here)
#define EMA_EFFECT_AT_VOLTAGE_TABLE(name) EMA_LANES_ADD(EMA_SITE_VOLTAGE, name, EMA_LANE_LEARNED(name), &here)
#include "ema/ema_effects.def"
}

static void ema_lanes_motor(const ema_lanes_t* lanes, const ema_lanes_site_t* site, ema_lane_t sum)
{
    ema_lanes_none(sum);
#define EMA_EFFECT_AT_MOTOR(name) EMA_LANES_ADD(EMA_SITE_MOTOR, name, EMA_LANE_HELD(name), &here)
#include "ema/ema_effects.def"
}

void ema_lanes_presliding(const ema_lanes_t* lanes, const ema_lane_t turn_rad, ema_lane_t share)
{
    ema_lanes_none(share);
#define EMA_EFFECT_AT_PRESLIDING(name)                                                                                 \
    if (EMA_LANE_RUNS(EMA_SITE_PRESLIDING, name)) {                                                                    \
        EMA_EACH_LANE                                                                                                  \
        {                                                                                                              \
            share[l] = ema_effect_##name(&lanes->plant[l].effects.name,                                                          \
                                       lanes->state[l].effect_memory[EMA_MEMORY_PLACE(name)], turn_rad[l]);            \
        }                                                                                                              \
    }
#include "ema/ema_effects.def"
}

/* Dry friction against the motion in `direction`: ema_level. */
static void ema_lanes_level(const ema_lanes_t* lanes, const ema_lanes_site_t* site, const ema_lane_t level_Nm,
                            const ema_lane_t load_Nm, const ema_lane_t direction, ema_lane_t total_Nm)
{
    ema_lane_t own_Nm;
    EMA_EACH_LANE
    {
        const ema_screw_t screw = {.asymmetry = lanes->constant.asymmetry[l]};
        const ema_gearbox_t gearbox = {.loss_opposing = lanes->constant.loss_opposing[l],
                                       .loss_aiding = lanes->constant.loss_aiding[l]};
        own_Nm[l] = ema_screw_level(&screw, level_Nm[l], direction[l]);
        total_Nm[l] = own_Nm[l] + ema_gearbox_loss(&gearbox, load_Nm[l], direction[l]);
    }
    if (ema_acts(&lanes->plant[0], EMA_SITE_FRICTION)) {
        ema_lane_t change_Nm;
        ema_lanes_friction(lanes, site, own_Nm, change_Nm);
        EMA_EACH_LANE
        {
            total_Nm[l] += change_Nm[l];
        }
    }
    EMA_EACH_LANE
    {
        total_Nm[l] = ema_max(total_Nm[l], EMA_R(0.0));
    }
}

/* Dry friction of lanes that slide, and the levels that hold those at rest. */
static void ema_lanes_dry_friction(ema_lanes_t* lanes, const ema_lanes_site_t* site, const ema_lane_t load_Nm)
{
    ema_lanes_forces_t* const forces = &lanes->forces;
    ema_lane_t own_Nm;
    ema_lane_t direction;
    ema_lane_t total_Nm;
    ema_real resting = EMA_R(0.0);
    EMA_EACH_LANE
    {
        const bool stuck = lanes->now.motion[l] == EMA_R(0.0);
        own_Nm[l] = stuck ? lanes->constant.static_Nm[l] : lanes->constant.dynamic_Nm[l];
        direction[l] = stuck ? EMA_R(1.0) : lanes->now.motion[l];
        resting += stuck ? EMA_R(1.0) : EMA_R(0.0);
    }
    ema_lanes_level(lanes, site, own_Nm, load_Nm, direction, total_Nm);
    EMA_EACH_LANE
    {
        const bool stuck = lanes->now.motion[l] == EMA_R(0.0);
        const ema_real torque_Nm = forces->torque_Nm[l] + (-direction[l] * total_Nm[l]);
        forces->torque_Nm[l] = stuck ? forces->torque_Nm[l] : torque_Nm;
        forces->level_forward_Nm[l] = stuck ? total_Nm[l] : EMA_R(0.0);
    }
    if (resting > EMA_R(0.0)) {
        EMA_EACH_LANE
        {
            own_Nm[l] = lanes->constant.static_Nm[l];
            direction[l] = EMA_R(-1.0);
        }
        ema_lanes_level(lanes, site, own_Nm, load_Nm, direction, total_Nm);
        EMA_EACH_LANE
        {
            forces->level_backward_Nm[l] = (lanes->now.motion[l] == EMA_R(0.0)) ? total_Nm[l] : EMA_R(0.0);
        }
    }
}

/* Torque of a contact that stretches before it slides. */
static void ema_lanes_contact(ema_lanes_t* lanes, const ema_lanes_site_t* site, const ema_lane_t load_Nm)
{
    ema_lane_t turn_rad;
    ema_lane_t share;
    ema_lane_t direction;
    ema_lane_t total_Nm;
    EMA_EACH_LANE
    {
        turn_rad[l] = site->angle_rad[l] - lanes->now.angle_rad[l];
    }
    ema_lanes_presliding(lanes, turn_rad, share);
    EMA_EACH_LANE
    {
        direction[l] = (share[l] < EMA_R(0.0)) ? EMA_R(-1.0) : EMA_R(1.0);
    }
    ema_lanes_level(lanes, site, lanes->constant.dynamic_Nm, load_Nm, direction, total_Nm);
    EMA_EACH_LANE
    {
        lanes->forces.torque_Nm[l] += -share[l] * total_Nm[l];
    }
}

/* Torque constant and back-EMF that an effect changes. */
static void ema_lanes_motor_change(ema_lanes_t* lanes, const ema_lanes_site_t* site, const ema_lane_t speed_rad_s)
{
    ema_lane_t change;
    ema_lanes_motor(lanes, site, change);
    EMA_EACH_LANE
    {
        const ema_motor_t motor = {.torque_constant_Nm_per_A = lanes->constant.torque_constant_Nm_per_A[l],
                                   .torque_limit_Nm = lanes->constant.torque_limit_Nm[l]};
        const ema_real changed_A = (EMA_R(1.0) + change[l]) * site->current_A[l];
        const ema_real emf_V = change[l] * lanes->constant.back_emf_V_s_per_rad[l] * speed_rad_s[l];
        lanes->forces.torque_Nm[l] +=
            ema_motor_torque(&motor, changed_A) - ema_motor_torque(&motor, site->current_A[l]);
        lanes->forces.input[l] -= (lanes->applied.current_loop[l] != EMA_R(0.0)) ? EMA_R(0.0) : emf_V;
    }
}

void ema_lanes_forces_at(ema_lanes_t* lanes, const ema_lanes_point_t* point)
{
    const ema_plant_t* const shape = &lanes->plant[0];
    ema_lanes_forces_t* const forces = &lanes->forces;
    ema_lanes_site_t site;
    ema_lane_t load_Nm;
    ema_lane_t sum;
    EMA_EACH_LANE
    {
        const ema_real motion = lanes->now.motion[l];
        const ema_real speed_rad_s = point->speed_rad_s[l];
        const ema_real forward = ema_max(speed_rad_s, EMA_R(0.0));
        const ema_real backward = ema_min(speed_rad_s, EMA_R(0.0));
        const ema_real free = (motion == (ema_real)EMA_MOTION_ELASTIC) ? speed_rad_s : EMA_R(0.0);
        const ema_real turned = (motion == (ema_real)EMA_MOTION_BACKWARD) ? backward : free;
        site.speed_rad_s[l] = (motion == (ema_real)EMA_MOTION_FORWARD) ? forward : turned;
        site.angle_rad[l] = point->angle_rad[l];
        site.position_mm[l] = lanes->constant.lead_mm_per_rad[l] * point->angle_rad[l];
        site.current_A[l] = point->current_A[l];
        site.voltage_V[l] =
            (lanes->applied.current_loop[l] != EMA_R(0.0)) ? lanes->applied.voltage_V[l] : lanes->applied.input[l];
        forces->input[l] = lanes->applied.input[l];
        forces->level_forward_Nm[l] = EMA_R(0.0);
        forces->level_backward_Nm[l] = EMA_R(0.0);
        load_Nm[l] = lanes->constant.load_torque_Nm[l];
    }
    if (ema_acts(shape, EMA_SITE_VOLTAGE)) {
        ema_lanes_voltage(lanes, &site, sum);
        EMA_EACH_LANE
        {
            const ema_real input = forces->input[l] + sum[l];
            forces->input[l] = (lanes->applied.current_loop[l] != EMA_R(0.0)) ? forces->input[l] : input;
        }
    }
    if (ema_acts(shape, EMA_SITE_LOAD)) {
        ema_lanes_load(lanes, &site, sum);
        EMA_EACH_LANE
        {
            load_Nm[l] += sum[l];
        }
    }
    EMA_EACH_LANE
    {
        forces->torque_Nm[l] = -load_Nm[l];
    }
    if (ema_acts(shape, EMA_SITE_TORQUE)) {
        ema_lanes_torque(lanes, &site, sum);
        EMA_EACH_LANE
        {
            forces->torque_Nm[l] += sum[l];
        }
    }
    if (ema_acts(shape, EMA_SITE_MOTOR)) {
        ema_lanes_motor_change(lanes, &site, point->speed_rad_s);
    }
    if (ema_acts(shape, EMA_SITE_PRESLIDING)) {
        ema_lanes_contact(lanes, &site, load_Nm);
    } else {
        ema_lanes_dry_friction(lanes, &site, load_Nm);
    }
}
