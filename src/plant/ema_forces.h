/* What acts on circuit and shaft over a span of the motion: drive, load, dry friction, and the effects. */
#ifndef EMA_FORCES_H
#define EMA_FORCES_H

#include "blocks/ema_drive.h"

/* The forces at a point of the work's segment, into the work's `forces`. All of them at its own start; at any other the
 * levels that hold a shaft at rest are left out, and a dry friction that nothing changes on the way is the one at the
 * start. Who asks counts it as EMA_WORK_FORCES. */
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
