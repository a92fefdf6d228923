/* Apart from ema_motion.c so that what is worked out at a point takes no stack from the step around it. */
#include "plant/ema_forces.h"

#include <stddef.h>

#include "base/ema_math.h"
#include "blocks/ema_gearbox.h"
#include "blocks/ema_motor.h"
#include "blocks/ema_screw.h"
#include "effects/ema_effect_sums.h"

/* Speed as the forces see it: past a reversal that is not located yet the friction keeps the direction of the motion.
 */
static ema_real ema_force_speed(int32_t motion, ema_real speed_rad_s)
{
    ema_real kept_rad_s = speed_rad_s;
    if (motion == (int32_t)EMA_MOTION_FORWARD) {
        kept_rad_s = ema_max(speed_rad_s, EMA_R(0.0));
    } else if (motion == (int32_t)EMA_MOTION_BACKWARD) {
        kept_rad_s = ema_min(speed_rad_s, EMA_R(0.0));
    } else {
        /* at rest there is none, and an elastic contact has no direction to keep */
    }
    return kept_rad_s;
}

/* Sites that most machines have no effect at, in the two groups that are passed by together. */
#define EMA_SITES_OF_INPUT                                                                                             \
    (((uint32_t)1 << (uint32_t)EMA_SITE_VOLTAGE) | ((uint32_t)1 << (uint32_t)EMA_SITE_WINDING)                         \
     | ((uint32_t)1 << (uint32_t)EMA_SITE_LOAD))
#define EMA_SITES_OF_SHAFT (((uint32_t)1 << (uint32_t)EMA_SITE_GREASE) | ((uint32_t)1 << (uint32_t)EMA_SITE_MOTOR))

/* Dry friction against the site's direction. */
static ema_real ema_level(const ema_plant_t* plant, uint32_t sites, const ema_site_t* site, ema_real level_Nm,
                          ema_real load_Nm)
{
    const ema_real own_Nm = ema_screw_level(&plant->screw, level_Nm, site->direction);
    ema_real total_Nm = own_Nm;
    if (load_Nm != EMA_R(0.0)) {
        total_Nm += ema_gearbox_lost(&plant->gearbox, load_Nm, site->direction);
    }
    if (ema_acts_among(sites, EMA_SITE_GREASE)) {
        total_Nm += site->grease * own_Nm;
    }
    if (ema_acts_among(sites, EMA_SITE_FRICTION)) {
        total_Nm += ema_site_friction(plant, site, own_Nm);
    }
    return ema_max(total_Nm, EMA_R(0.0));
}

/* Torque of dry friction on a shaft that slides, or of a stretched contact, which an end of travel alone can hold at
 * rest; of a shaft that rests both levels. One place asks for a level, so that it is no call. */
static ema_real ema_dry_friction(const ema_plant_t* plant, uint32_t sites, const ema_state_t* state, ema_site_t* site,
                                 ema_real load_Nm, bool rests, ema_forces_t* forces)
{
    const ema_real kept_Nm = rests ? plant->screw.static_Nm : plant->screw.dynamic_Nm;
    ema_real share = rests ? EMA_R(1.0) : (ema_real)state->motion;
    site->direction = share;
    if (ema_acts_among(sites, EMA_SITE_PRESLIDING)) {
        share = ema_site_presliding(plant, state->effect_memory, site->angle_rad - state->angle_rad);
        site->direction = (share < EMA_R(0.0)) ? EMA_R(-1.0) : EMA_R(1.0);
    }
    ema_real level_Nm = EMA_R(0.0);
    /* forward, then backward, or the one way that it slides */
    uint32_t k = 1U;
    if (rests) {
        k = 0U;
    }
    while (k < 2U) {
        level_Nm = ema_level(plant, sites, site, kept_Nm, load_Nm);
        if (k == 0U) {
            forces->level_forward_Nm = level_Nm;
            site->direction = EMA_R(-1.0);
        }
        ++k;
    }
    forces->level_backward_Nm = rests ? level_Nm : EMA_R(0.0);
    return -share * level_Nm;
}

void ema_forces_at(const ema_plant_t* plant, const ema_state_t* state, ema_step_scratch_t* work,
                   const ema_point_t* point)
{
    const bool starts = point == &work->segment.start;
    const ema_drive_output_t* const applied = &work->applied;
    ema_forces_t* const forces = &work->forces;
    ema_site_t site = {plant,
                       ema_force_speed(state->motion, point->speed_rad_s),
                       point->angle_rad,
                       plant->gearbox.lead_mm_per_rad * point->angle_rad,
                       point->current_A,
                       applied->input,
                       EMA_R(0.0),
                       EMA_R(0.0)};
    const uint32_t sites = plant->active.sites;
    /* kept out of the structure: each call would have them written and read again */
    ema_real input = applied->input;
    ema_real load_Nm = plant->screw.load_torque_Nm;
    if (((uint32_t)EMA_SITES_HELD & sites & EMA_SITES_OF_INPUT) != 0U) {
        if (!ema_drive_follows(applied) && ema_acts_among(sites, EMA_SITE_VOLTAGE)) {
            input += ema_site_voltage(plant, &site);
        }
        if (!ema_drive_follows(applied) && ema_acts_among(sites, EMA_SITE_WINDING)) {
            /* it warms between steps alone */
            if (starts) {
                work->winding_ohm = ema_site_winding(plant, state->effect_memory) * plant->motor.resistance_ohm;
            }
            input -= work->winding_ohm * site.current_A;
        }
        if (ema_acts_among(sites, EMA_SITE_LOAD)) {
            load_Nm += ema_site_load(plant, &site);
        }
    }
    ema_real torque_Nm = -load_Nm;
    if (ema_acts_among(sites, EMA_SITE_TORQUE)) {
        torque_Nm += ema_site_torque(plant, &site);
    }
    if (((uint32_t)EMA_SITES_HELD & sites & EMA_SITES_OF_SHAFT) != 0U) {
        if (ema_acts_among(sites, EMA_SITE_GREASE)) {
            site.grease = ema_site_grease(plant, state->effect_memory);
            torque_Nm -= (site.grease * plant->screw.viscous_Nm_s_per_rad) * site.speed_rad_s;
        }
        if (ema_acts_among(sites, EMA_SITE_MOTOR)) {
            const ema_real change = ema_site_motor(plant, &site);
            const ema_real changed_A = (EMA_R(1.0) + change) * site.current_A;
            /* the limit holds for the torque with its change */
            torque_Nm += ema_motor_torque(&plant->motor, changed_A) - ema_motor_torque(&plant->motor, site.current_A);
            input -= ema_drive_follows(applied) ? EMA_R(0.0)
                                                : (change * plant->motor.back_emf_V_s_per_rad * point->speed_rad_s);
        }
    }
    /* a shaft at rest breaks away by the levels at the start */
    const bool rests = (state->motion == (int32_t)EMA_MOTION_STUCK) && !ema_acts_among(sites, EMA_SITE_PRESLIDING);
    ema_real friction_Nm = work->segment.forces.level_forward_Nm;
    if (starts || (!rests && ema_friction_varies(sites))) {
        friction_Nm = ema_dry_friction(plant, sites, state, &site, load_Nm, rests, forces);
    }
    if (!rests) {
        forces->level_forward_Nm = friction_Nm;
        torque_Nm += friction_Nm;
    }
    forces->input = input;
    forces->torque_Nm = torque_Nm;
}

void ema_segment_open(const ema_plant_t* plant, const ema_state_t* state, ema_step_scratch_t* work)
{
    ema_segment_t* const segment = &work->segment;
    ema_span_t* const span = &work->span;
    span->current_A = state->current_A;
    span->speed_rad_s = state->speed_rad_s;
    segment->start.current_A = state->current_A;
    segment->start.speed_rad_s = state->speed_rad_s;
    segment->start.angle_rad = state->angle_rad;
    work->spent += EMA_WORK_FORCES;
    ema_forces_at(plant, state, work, &segment->start);
    /* one by one: a copy of the whole waits for the writes to its parts */
    const ema_real input = work->forces.input;
    const ema_real torque_Nm = work->forces.torque_Nm;
    segment->forces.input = input;
    segment->forces.torque_Nm = torque_Nm;
    segment->forces.level_forward_Nm = work->forces.level_forward_Nm;
    segment->forces.level_backward_Nm = work->forces.level_backward_Nm;
    span->input = input;
    span->torque_Nm = torque_Nm;
    segment->end.current_A = EMA_R(0.0);
    segment->end.speed_rad_s = EMA_R(0.0);
    segment->turn_rad = EMA_R(0.0);
    span->input_rise = EMA_R(0.0);
    span->torque_rise_Nm = EMA_R(0.0);
}

void ema_segment_correct(const ema_plant_t* plant, const ema_state_t* state, ema_step_scratch_t* work)
{
    ema_segment_t* const segment = &work->segment;
    ema_span_t* const span = &work->span;
    ema_real reaction_Nm = EMA_R(0.0);
    span->torque_Nm = EMA_R(0.0);
    if (ema_acts(plant, EMA_SITE_TRANSMISSION)) {
        const ema_real play_end_mm =
            ema_screw_play_at(&plant->screw, state->play_mm, plant->gearbox.lead_mm_per_rad * segment->end.angle_rad);
        ema_site_transmission_trial(plant, state, play_end_mm, work->span_s, &work->rod);
        span->torque_Nm = work->rod.reaction_start_Nm;
        segment->forces.torque_Nm += span->torque_Nm;
        reaction_Nm = work->rod.reaction_end_Nm;
    }
    work->spent += EMA_WORK_FORCES;
    ema_forces_at(plant, state, work, &segment->end);
    span->torque_rise_Nm = (work->forces.torque_Nm + reaction_Nm) - segment->forces.torque_Nm;
    span->input_rise = work->forces.input - segment->forces.input;
}

void ema_segment_respond(int32_t motion, ema_step_scratch_t* work, uint32_t from, uint32_t to)
{
    const ema_responses_t* const responses = work->responses;
    const ema_real* const current = (const ema_real*)(const void*)&responses->current; /* EMA-D4 */
    const ema_real* const speed = (const ema_real*)(const void*)&responses->speed;     /* EMA-D4 */
    const ema_real* const angle = (const ema_real*)(const void*)&responses->angle;     /* EMA-D4 */
    const ema_real* const stuck = &responses->stuck_from_current;
    const ema_real* const driven = (const ema_real*)(const void*)&work->span; /* EMA-D4 */
    ema_segment_t* const segment = &work->segment;
    ema_real current_A = segment->end.current_A;
    if (motion != (int32_t)EMA_MOTION_STUCK) {
        ema_real speed_rad_s = segment->end.speed_rad_s;
        ema_real turn_rad = segment->turn_rad;
        uint32_t k = from;
        do {
            const ema_real drive = driven[k];
            current_A += current[k] * drive;
            speed_rad_s += speed[k] * drive;
            turn_rad += angle[k] * drive;
            ++k;
        } while (k < to);
        segment->end.speed_rad_s = speed_rad_s;
        segment->turn_rad = turn_rad;
    } else {
        /* torques drive nothing */
        for (uint32_t k = (from + 1U) / 2U; k < (to / 2U); ++k) {
            current_A += stuck[k] * driven[(size_t)2U * k];
        }
    }
    segment->end.current_A = current_A;
    segment->end.angle_rad = segment->start.angle_rad + segment->turn_rad;
}
