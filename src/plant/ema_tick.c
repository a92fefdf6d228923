#include "plant/ema_run.h"

#include "blocks/ema_drive.h"
#include "blocks/ema_encoder.h"
#include "blocks/ema_pid.h"
#include "effects/ema_effect_sites.h"
#include "plant/ema_motion.h"

void ema_tick(const ema_plant_t* plant, ema_state_t* state, ema_step_scratch_t* work, ema_real command_mm,
              ema_output_t* row)
{
    ema_real position_mm = ema_encoder_rod(&plant->encoder, state->rod_mm);
    if (ema_acts_on_reading(plant)) {
        position_mm += ema_site_seen(plant, state);
    }
    row->position_mm = position_mm;
    row->motor_position_mm = state->motor_mm;
    const ema_real feedback_mm = ema_encoder_step(&plant->encoder, state, state->motor_mm, position_mm);
    const ema_real output = ema_pid_step(&plant->pid, state, command_mm, feedback_mm);
    ema_drive_step(&plant->drive, &plant->motor, output, state->current_A, state->speed_rad_s, &work->applied);
    row->voltage_V = work->applied.voltage_V;
    if (ema_drive_delays(&plant->drive)) {
        ema_delayed_output(plant, state, work, output);
    }
    ema_drive_current(plant, state, &work->applied);
    row->current_A = state->current_A;
    if (!ema_drive_delays(&plant->drive) && !ema_acts_on_motion(plant)) {
        ema_motion_plain_step(plant, state, work);
    } else {
        if (ema_drive_delays(&plant->drive)) {
            ema_delayed_step(plant, state, work);
        } else {
            ema_motion_span(plant, state, work, &plant->responses[1], plant->step_s);
        }
        if (ema_acts_by_warmth(plant)) {
            ema_site_warm(plant, state, row->current_A, plant->warming_ahead_ratio, plant->step_s);
        }
    }
    ema_motion_arrive(plant, state);
    ++state->step;
}
