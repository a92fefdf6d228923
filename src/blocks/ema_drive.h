/* Block 2: controller and drive electronics. Equations: docs/DESIGN.md, "Controller and drive electronics". */
#ifndef EMA_DRIVE_H
#define EMA_DRIVE_H

#include "ema/ema_plant.h"
#include "ema_math.h"

void ema_drive_prepare(ema_drive_t* drive, const ema_params_t* params, const ema_options_t* options);

/* What the drive applies over one step. */
typedef struct {
    ema_real input;      /* voltage on the motor circuit in V, or reference of the current loop in A */
    ema_real voltage_V;  /* as it is recorded */
    bool current_loop;   /* which of the two circuits the input drives */
} ema_drive_output_t;

/* Current mode: the loop follows its reference while the bus voltage suffices, else the bus voltage is applied. */
ema_drive_output_t ema_drive_current_mode(const ema_drive_t* drive, const ema_motor_t* motor, ema_real output, ema_real current_A, ema_real speed_rad_s);

/* The step below as a function, where it is not in the way of every model step. */
ema_drive_output_t ema_drive_apply(const ema_drive_t* drive, const ema_motor_t* motor, ema_real output, ema_real current_A, ema_real speed_rad_s);

static inline ema_drive_output_t ema_drive_step(const ema_drive_t* drive, const ema_motor_t* motor, ema_real output, ema_real current_A, ema_real speed_rad_s)
{
    if (drive->current_mode) {
        return ema_drive_current_mode(drive, motor, output, current_A, speed_rad_s);
    }
    const ema_real voltage_V = output * drive->supply_V;
    const ema_drive_output_t applied = {voltage_V, voltage_V, false};
    return applied;
}

#endif
