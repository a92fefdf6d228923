#include "blocks/ema_gearbox.h"

void ema_gearbox_prepare(ema_gearbox_t* gearbox, const ema_params_t* params)
{
    gearbox->lead_mm = params->lead_mm;
    gearbox->lead_mm_per_rad = params->lead_mm / (EMA_TURN_RAD * params->ratio);
    gearbox->loss_opposing = (EMA_R(1.0) / params->efficiency) - EMA_R(1.0);
    gearbox->loss_aiding = EMA_R(1.0) - params->efficiency;
}

ema_real ema_gearbox_loss(const ema_gearbox_t* gearbox, ema_real load_torque_Nm, ema_real direction)
{
    return ema_gearbox_lost(gearbox, load_torque_Nm, direction);
}
