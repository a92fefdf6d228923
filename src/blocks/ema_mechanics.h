/* Block 5: ball screw with dry friction, ends of travel and backlash. Equations: docs/DESIGN.md, "Ball screw". */
#ifndef EMA_MECHANICS_H
#define EMA_MECHANICS_H

#include "base/ema_math.h"
#include "ema/detail/ema_plant.h"

void ema_screw_prepare(ema_screw_t* screw, const ema_gearbox_t* gearbox, const ema_params_t* params);

/* Level of dry friction for motion in `direction`: -1 or 1. */
static inline ema_real ema_screw_level(const ema_screw_t* screw, ema_real level_Nm, ema_real direction)
{
    return level_Nm * (EMA_R(1.0) + (direction * screw->asymmetry));
}

/* The same without moving it, from the output `play_mm`. */
static inline ema_real ema_screw_play_at(const ema_screw_t* screw, ema_real play_mm, ema_real input_mm)
{
    const ema_real gap_mm = input_mm - play_mm;
    ema_real output_mm = play_mm;
    if (gap_mm > screw->half_play_mm) {
        output_mm = input_mm - screw->half_play_mm;
    } else if (gap_mm < -screw->half_play_mm) {
        output_mm = input_mm + screw->half_play_mm;
    } else {
        /* inside the play the rod rests */
    }
    return output_mm;
}

/* The function below where it is not in the way of every model step. */
void ema_screw_play_keep(const ema_screw_t* screw, ema_state_t* state, ema_real input_mm);

/* Output of the play for the motor position `input_mm`: stays while inside, then follows at half its width. */
static inline void ema_screw_play(const ema_screw_t* screw, ema_state_t* state, ema_real input_mm)
{
    const ema_real gap_mm = input_mm - state->play_mm;
    state->play_side = 0;
    if (gap_mm > screw->half_play_mm) {
        state->play_mm = input_mm - screw->half_play_mm;
        state->play_side = 1;
    } else if (gap_mm < -screw->half_play_mm) {
        state->play_mm = input_mm + screw->half_play_mm;
        state->play_side = -1;
    } else {
        /* inside the play the rod rests */
    }
}

/* Which way a shaft at rest goes under a net torque, for the levels of dry friction against each direction.
 * At an end stop it can only leave inward. */
ema_motion_t ema_screw_break_away(const ema_screw_t* screw, ema_real angle_rad, ema_real torque_Nm,
                                  ema_real level_forward_Nm, ema_real level_backward_Nm);

void ema_gearbox_prepare(ema_gearbox_t* gearbox, const ema_params_t* params);

/* Dry friction that a load torque adds, for motion (or breaking away) in `direction`: -1 or 1. */
static inline ema_real ema_gearbox_lost(const ema_gearbox_t* gearbox, ema_real load_torque_Nm, ema_real direction)
{
    const ema_real against_Nm = load_torque_Nm * direction;
    return (against_Nm > EMA_R(0.0)) ? (gearbox->loss_opposing * against_Nm) : (gearbox->loss_aiding * -against_Nm);
}

/* The same as a function, where it is not in the way of every model step. */
ema_real ema_gearbox_loss(const ema_gearbox_t* gearbox, ema_real load_torque_Nm, ema_real direction);

void ema_motor_prepare(ema_motor_t* motor, const ema_params_t* params);

/* Torque on the shaft, saturated by the induction flux. */
static inline ema_real ema_motor_torque(const ema_motor_t* motor, ema_real current_A)
{
    /* the call of a function would take longer than this */
    const ema_real torque_Nm = motor->torque_constant_Nm_per_A * current_A;
    return ema_min(ema_max(torque_Nm, -motor->torque_limit_Nm), motor->torque_limit_Nm);
}

#endif
