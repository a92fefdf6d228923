/* Block 4: gearbox. Equations: docs/DESIGN.md, "Gearbox". */
#ifndef EMA_GEARBOX_H
#define EMA_GEARBOX_H

#include "base/ema_math.h"
#include "ema/detail/ema_plant.h"

void ema_gearbox_prepare(ema_gearbox_t* gearbox, const ema_params_t* params);

/* Dry friction that a load torque adds, for motion (or breaking away) in `direction`: -1 or 1. */
static inline ema_real ema_gearbox_lost(const ema_gearbox_t* gearbox, ema_real load_torque_Nm, ema_real direction)
{
    const ema_real against_Nm = load_torque_Nm * direction;
    return (against_Nm > EMA_R(0.0)) ? (gearbox->loss_opposing * against_Nm) : (gearbox->loss_aiding * -against_Nm);
}

/* The same as a function, where it is not in the way of every model step. */
ema_real ema_gearbox_loss(const ema_gearbox_t* gearbox, ema_real load_torque_Nm, ema_real direction);

#endif
