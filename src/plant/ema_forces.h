/* What acts on circuit and shaft over a span of the motion: drive, load, dry friction, and the effects. */
#ifndef EMA_FORCES_H
#define EMA_FORCES_H

#include "ema_drive.h"

/* What acts on circuit and shaft at a point of the motion, beside the motor's own torque; and what holds the shaft at rest. */
typedef struct {
    ema_real input;             /* of the circuit */
    ema_real torque_Nm;
    ema_real level_forward_Nm;  /* dry friction at rest against each direction */
    ema_real level_backward_Nm;
} ema_forces_t;

/* A point of the motion. */
typedef struct {
    ema_real current_A;
    ema_real speed_rad_s;
    ema_real angle_rad;
} ema_point_t;

/* A span of the motion without events: what its ends are. */
typedef struct {
    ema_point_t start;
    ema_point_t end;
    ema_forces_t forces;      /* at the start */
    ema_real input_rise;
    ema_real torque_rise_Nm;
} ema_segment_t;

/* The forces at a point of the motion. */
void ema_forces_at(const ema_plant_t* plant, const ema_state_t* state, const ema_drive_output_t* applied, const ema_point_t* point, ema_forces_t* forces);

/* Opens a segment at the state: the forces at its start, held over it until its end is known. */
void ema_segment_open(const ema_plant_t* plant, const ema_state_t* state, const ema_drive_output_t* applied, ema_real span_s, ema_segment_t* segment);

/* Lets the forces rise evenly to those at the predicted end. */
void ema_segment_correct(const ema_plant_t* plant, const ema_state_t* state, const ema_drive_output_t* applied, ema_real span_s, ema_segment_t* segment);

#endif
