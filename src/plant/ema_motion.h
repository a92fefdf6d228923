/* Moves current, speed and angle of motor, gearbox and screw over one model step.
 *
 * Between events the plant is linear and its inputs are held, so a step is one product with prepared responses. A step
 * in which something happens (reversal, break-away, end stop, saturation), or in which effects act, goes through
 * ema_motion_located.
 */
#ifndef EMA_MOTION_H
#define EMA_MOTION_H

#include "blocks/ema_drive.h"
#include "blocks/ema_mechanics.h"
#include "effects/ema_effect_sites.h"

/* An integration step, or a part of one, with effects or with events, which are located inside it. */
void ema_motion_located(const ema_plant_t* plant, ema_state_t* state, ema_step_scratch_t* work, ema_real span_s);

/* The same with its events alone, over the work's span: ema_motion_events.c. */
void ema_motion_events(const ema_plant_t* plant, ema_state_t* state, ema_step_scratch_t* work);

/* Moves a rod whose transmission yields over `span_s`, in which the play came from `play_start_mm`:
 * ema_motion_events.c. */
void ema_motion_rod(const ema_plant_t* plant, ema_state_t* state, ema_step_scratch_t* work, ema_real play_start_mm,
                    ema_real span_s);

/* Turns the shaft; an elastic contact follows. */
void ema_motion_turn(const ema_plant_t* plant, ema_state_t* state, ema_real turn_rad);

/* `span_s` with effects: in one by the responses, if nothing happens in it that needs its substeps. */
void ema_motion_span(const ema_plant_t* plant, ema_state_t* state, ema_step_scratch_t* work,
                     const ema_responses_t* responses, ema_real span_s);

static inline ema_real ema_response_at(const ema_response_t* response, ema_real current_A, ema_real speed_rad_s,
                                       ema_real input, ema_real torque_Nm)
{
    return (response->from_current * current_A) + (response->from_speed * speed_rad_s)
           + ((response->from_voltage * input) + (response->from_torque * torque_Nm));
}

/* One integration step in which nothing happens; false, and nothing changed, when something would. NaN answers false.
 */
static inline bool ema_motion_plain(const ema_plant_t* plant, ema_state_t* state, const ema_drive_output_t* applied)
{
    const ema_responses_t* const responses = &plant->responses[ema_drive_keeps(&plant->drive, applied) ? 0U : 1U];
    const ema_real current_A = state->current_A;
    /* on a limit or beyond it, the step is not the linear one even when it ends inside */
    bool plain = ema_abs(current_A) < plant->linear_current_A;
    if (state->motion != (int32_t)EMA_MOTION_STUCK) {
        const bool forward = state->motion > 0;
        const ema_real torque_Nm = forward ? plant->screw.forward_torque_Nm : plant->screw.backward_torque_Nm;
        const ema_real speed_rad_s = state->speed_rad_s;
        const ema_real next_A = ema_response_at(&responses->current, current_A, speed_rad_s, applied->input, torque_Nm);
        const ema_real next_rad_s =
            ema_response_at(&responses->speed, current_A, speed_rad_s, applied->input, torque_Nm);
        ema_real angle_rad = state->angle_rad;
        ema_real low_rad = state->angle_low_rad;
        ema_add_compensated(&angle_rad, &low_rad,
                            ema_response_at(&responses->angle, current_A, speed_rad_s, applied->input, torque_Nm));
        plain = plain && (forward ? (next_rad_s > EMA_R(0.0)) : (next_rad_s < EMA_R(0.0)))
                && (ema_abs(next_A) <= plant->linear_current_A) && (angle_rad < plant->screw.stop_upper_rad)
                && (angle_rad > plant->screw.stop_lower_rad);
        if (plain) {
            state->current_A = next_A;
            state->speed_rad_s = next_rad_s;
            state->angle_rad = angle_rad;
            state->angle_low_rad = low_rad;
        }
    } else {
        const ema_real next_A =
            (responses->stuck_from_current * current_A) + (responses->stuck_from_voltage * applied->input);
        const ema_real torque_Nm = plant->motor.torque_constant_Nm_per_A * next_A;
        plain = plain && (torque_Nm <= plant->screw.hold_upper_Nm) && (torque_Nm >= plant->screw.hold_lower_Nm)
                && (ema_abs(next_A) <= plant->linear_current_A);
        if (plain) {
            state->current_A = next_A;
        }
    }
    return plain;
}

/* What the work says that the drive applies, over a whole model step in which no effect acts. */
static inline void ema_motion_plain_step(const ema_plant_t* plant, ema_state_t* state, ema_step_scratch_t* work)
{
    uint32_t left = plant->substeps;
    work->spent += left + (plant->step_work - 1U);
    do {
        if (!ema_motion_plain(plant, state, &work->applied)) {
            ema_motion_located(plant, state, work, plant->substep_s);
        }
        --left;
    } while (left > 0U);
}

/* Where the motion has brought motor and rod. */
static inline void ema_motion_arrive(const ema_plant_t* plant, ema_state_t* state)
{
    state->motor_mm =
        (plant->gearbox.lead_mm_per_rad * state->angle_rad) + (plant->gearbox.lead_mm_per_rad * state->angle_low_rad);
    ema_screw_play(&plant->screw, state, state->motor_mm);
    if (!ema_acts(plant, EMA_SITE_TRANSMISSION)) {
        state->rod_mm = state->play_mm;
    }
}

/* With a drive that passes its output on with a delay: keeps the output; what is applied at the start of the model step
 * goes to the work. */
void ema_delayed_output(const ema_plant_t* plant, ema_state_t* state, ema_step_scratch_t* work, ema_real output);

/* The model step with such a drive: first what was asked before, over its share, then what was asked later; each in as
 * many integration steps as a whole one. */
void ema_delayed_step(const ema_plant_t* plant, ema_state_t* state, ema_step_scratch_t* work);

/* The forces at a point of the work's segment, into the work's `forces`. All of them at its own start; at any other the
 * levels that hold a shaft at rest are left out, and a dry friction that nothing changes on the way is the one at the
 * start. Who asks counts it as the plant's forces_work. */
void ema_forces_at(const ema_plant_t* plant, const ema_state_t* state, ema_step_scratch_t* work,
                   const ema_point_t* point);

/* Opens the work's segment at the state, over the work's span: the forces at its start, held over it until its end is
 * known. */
void ema_segment_open(const ema_plant_t* plant, const ema_state_t* state, ema_step_scratch_t* work);

/* Lets the forces rise evenly to those at the predicted end. The span's torque is then what has come to that at the
 * start: the reaction of what lies behind the play. */
void ema_segment_correct(const ema_plant_t* plant, const ema_state_t* state, ema_step_scratch_t* work);

/* Adds to the segment's end what the work's span drives by the responses in the columns `from` to `to`. */
void ema_segment_respond(int32_t motion, ema_step_scratch_t* work, uint32_t from, uint32_t to);

#endif
