/* Block 4: gearbox. Equations: docs/DESIGN.md, "Gearbox". */
#ifndef EMA_GEARBOX_H
#define EMA_GEARBOX_H

#include "ema/ema_plant.h"
#include "ema_math.h"

void ema_gearbox_prepare(ema_gearbox_t* gearbox, const ema_params_t* params);

/* Dry friction that a load torque adds, for motion (or breaking away) in `direction`: -1 or 1. */
ema_real ema_gearbox_loss(const ema_gearbox_t* gearbox, ema_real load_torque_Nm, ema_real direction);

#endif
