/* Apart from ema_motion.c so that what is worked out at a point takes no stack from the step around it. */
#include "ema_forces.h"

#include <stddef.h>

#include "ema_effect_sites.h"
#include "ema_gearbox.h"
#include "ema_math.h"
#include "ema_motor.h"
#include "ema_screw.h"

static ema_real ema_level(const ema_plant_t* plant, ema_site_t* site, ema_real level_Nm, ema_real load_Nm,
                          ema_real direction)
{
    const ema_real own_Nm = ema_screw_level(&plant->screw, level_Nm, direction);
    ema_real total_Nm = own_Nm + ema_gearbox_loss(&plant->gearbox, load_Nm, direction);
    if (ema_acts(plant, EMA_SITE_GREASE)) {
        total_Nm += site->grease * own_Nm;
    }
    if (ema_acts(plant, EMA_SITE_FRICTION)) {
        site->direction = direction;
        total_Nm += ema_site_friction(plant, site, own_Nm);
    }
    return ema_max(total_Nm, EMA_R(0.0));
}

/* Torque of dry friction on a shaft that slides, or of a stretched contact, which an end of travel alone can hold at
 * rest. */
static ema_real ema_sliding_friction(const ema_plant_t* plant, const ema_state_t* state, ema_site_t* site,
                                     ema_real load_Nm)
{
    if (!ema_acts(plant, EMA_SITE_PRESLIDING)) {
        const ema_real direction = (ema_real)state->motion;
        return -direction * ema_level(plant, site, plant->screw.dynamic_Nm, load_Nm, direction);
    }
    const ema_real share = ema_site_presliding(plant, state->effect_memory, site->angle_rad - state->angle_rad);
    return -share
           * ema_level(plant, site, plant->screw.dynamic_Nm, load_Nm, (share < EMA_R(0.0)) ? EMA_R(-1.0) : EMA_R(1.0));
}

/* Speed as the forces see it: past a reversal that is not located yet the friction keeps the direction of the motion.
 */
static ema_real ema_force_speed(int32_t motion, ema_real speed_rad_s)
{
    ema_real speed = speed_rad_s;
    if (motion == (int32_t)EMA_MOTION_STUCK) {
        speed = EMA_R(0.0);
    } else if (motion == (int32_t)EMA_MOTION_FORWARD) {
        speed = ema_max(speed_rad_s, EMA_R(0.0));
    } else if (motion == (int32_t)EMA_MOTION_BACKWARD) {
        speed = ema_min(speed_rad_s, EMA_R(0.0));
    } else {
        /* an elastic contact has no direction to keep */
    }
    return speed;
}

void ema_forces_at(const ema_plant_t* plant, const ema_state_t* state, ema_work_t* work, const ema_point_t* point)
{
    const bool starts = point == &work->segment.start;
    const ema_drive_output_t* const applied = &work->applied;
    ema_forces_t* const forces = &work->forces;
    ema_site_t site = {plant,
                       ema_force_speed(state->motion, point->speed_rad_s),
                       point->angle_rad,
                       plant->gearbox.lead_mm_per_rad * point->angle_rad,
                       point->current_A,
                       applied->current_loop ? applied->voltage_V : applied->input,
                       EMA_R(0.0),
                       EMA_R(0.0)};
    const uint32_t sites = plant->active.sites;
    work->spent += EMA_WORK_FORCES;
    forces->input = applied->input;
    forces->level_forward_Nm = EMA_R(0.0);
    forces->level_backward_Nm = EMA_R(0.0);
    if (!applied->current_loop && ema_acts_among(sites, EMA_SITE_VOLTAGE)) {
        forces->input += ema_site_voltage(plant, &site);
    }
    if (!applied->current_loop && ema_acts_among(sites, EMA_SITE_WINDING)) {
        /* it warms between steps alone */
        if (starts) {
            work->winding_ohm = ema_site_winding(plant, state->effect_memory) * plant->motor.resistance_ohm;
        }
        forces->input -= work->winding_ohm * site.current_A;
    }
    ema_real load_Nm = plant->screw.load_torque_Nm;
    if (ema_acts_among(sites, EMA_SITE_LOAD)) {
        load_Nm += ema_site_load(plant, &site);
    }
    forces->torque_Nm = -load_Nm;
    if (ema_acts_among(sites, EMA_SITE_TORQUE)) {
        forces->torque_Nm += ema_site_torque(plant, &site);
    }
    if (ema_acts_among(sites, EMA_SITE_GREASE)) {
        site.grease = ema_site_grease(plant, state->effect_memory);
        forces->torque_Nm -= (site.grease * plant->screw.viscous_Nm_s_per_rad) * site.speed_rad_s;
    }
    if (ema_acts_among(sites, EMA_SITE_MOTOR)) {
        const ema_real change = ema_site_motor(plant, &site);
        const ema_real changed_A = (EMA_R(1.0) + change) * site.current_A;
        /* the limit holds for the torque with its change */
        forces->torque_Nm +=
            ema_motor_torque(&plant->motor, changed_A) - ema_motor_torque(&plant->motor, site.current_A);
        forces->input -=
            applied->current_loop ? EMA_R(0.0) : (change * plant->motor.back_emf_V_s_per_rad * point->speed_rad_s);
    }
    if ((state->motion != (int32_t)EMA_MOTION_STUCK) || ema_acts_among(sites, EMA_SITE_PRESLIDING)) {
        const ema_real friction_Nm = (starts || ema_friction_varies(plant))
                                         ? ema_sliding_friction(plant, state, &site, load_Nm)
                                         : work->segment.forces.level_forward_Nm;
        forces->level_forward_Nm = friction_Nm;
        forces->torque_Nm += friction_Nm;
    } else if (starts) {
        forces->level_forward_Nm = ema_level(plant, &site, plant->screw.static_Nm, load_Nm, EMA_R(1.0));
        forces->level_backward_Nm = ema_level(plant, &site, plant->screw.static_Nm, load_Nm, EMA_R(-1.0));
    } else {
        /* a shaft at rest breaks away by the levels at the start */
    }
}

void ema_segment_open(const ema_plant_t* plant, const ema_state_t* state, ema_work_t* work)
{
    ema_segment_t* const segment = &work->segment;
    ema_span_t* const span = &work->span;
    span->current_A = state->current_A;
    span->speed_rad_s = state->speed_rad_s;
    segment->start.current_A = state->current_A;
    segment->start.speed_rad_s = state->speed_rad_s;
    segment->start.angle_rad = state->angle_rad;
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

void ema_segment_correct(const ema_plant_t* plant, const ema_state_t* state, ema_work_t* work)
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
    ema_forces_at(plant, state, work, &segment->end);
    span->torque_rise_Nm = (work->forces.torque_Nm + reaction_Nm) - segment->forces.torque_Nm;
    span->input_rise = work->forces.input - segment->forces.input;
}

void ema_segment_respond(int32_t motion, ema_work_t* work, uint32_t from, uint32_t to)
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
