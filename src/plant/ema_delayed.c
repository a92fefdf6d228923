/* Apart from ema_tick.c so that its frame is not that of every step. */
#include "plant/ema_delayed.h"

#include "plant/ema_motion.h"

void ema_delayed_output(const ema_plant_t* plant, ema_state_t* state, ema_step_scratch_t* work, ema_real output)
{
    state->delay_output[state->step & (EMA_DELAY_SAMPLES - 1U)] = output;
    const bool parted = plant->drive.delay_part > EMA_R(0.0);
    ema_drive_late(plant, state, plant->drive.delay_steps + (parted ? 1U : 0U), &work->applied);
}

void ema_delayed_step(const ema_plant_t* plant, ema_state_t* state, ema_step_scratch_t* work)
{
    const ema_real first_s = plant->drive.delay_part * plant->step_s;
    if (first_s > EMA_R(0.0)) {
        ema_motion_span(plant, state, work, &plant->responses[0], first_s);
        ema_drive_late(plant, state, plant->drive.delay_steps, &work->applied);
        ema_drive_current(plant, state, &work->applied);
    }
    ema_motion_span(plant, state, work, &plant->responses[1], plant->step_s - first_s);
}
