#include "blocks/ema_mechanics.h"

#include "blocks/ema_limits.h"

void ema_screw_prepare(ema_screw_t* screw, const ema_gearbox_t* gearbox, const ema_params_t* params)
{
    const ema_real load_Nm = params->load_torque_Nm;
    const ema_real loss_forward_Nm = ema_gearbox_loss(gearbox, load_Nm, EMA_R(1.0));
    const ema_real loss_backward_Nm = ema_gearbox_loss(gearbox, load_Nm, EMA_R(-1.0));
    screw->inverse_inertia_per_kgm2 = EMA_R(1.0) / params->inertia_kgm2;
    screw->viscous_Nm_s_per_rad = params->viscous_Nm_s_per_rad;
    screw->static_Nm = params->csj_Nm;
    screw->dynamic_Nm = params->csj_Nm * params->dynamic_ratio;
    screw->asymmetry = params->friction_asymmetry;
    screw->load_torque_Nm = load_Nm;
    screw->forward_torque_Nm = -load_Nm - (ema_screw_level(screw, screw->dynamic_Nm, EMA_R(1.0)) + loss_forward_Nm);
    screw->backward_torque_Nm = -load_Nm + (ema_screw_level(screw, screw->dynamic_Nm, EMA_R(-1.0)) + loss_backward_Nm);
    screw->hold_upper_Nm = load_Nm + (ema_screw_level(screw, screw->static_Nm, EMA_R(1.0)) + loss_forward_Nm);
    screw->hold_lower_Nm = load_Nm - (ema_screw_level(screw, screw->static_Nm, EMA_R(-1.0)) + loss_backward_Nm);
    screw->stop_upper_rad = params->travel_mm / gearbox->lead_mm_per_rad;
    screw->stop_lower_rad = -screw->stop_upper_rad;
    screw->half_play_mm = EMA_R(0.5) * params->blk_mm;
}

void ema_screw_play_keep(const ema_screw_t* screw, ema_state_t* state, ema_real input_mm)
{
    ema_screw_play(screw, state, input_mm);
}

ema_motion_t ema_screw_break_away(const ema_screw_t* screw, ema_real angle_rad, ema_real torque_Nm,
                                  ema_real level_forward_Nm, ema_real level_backward_Nm)
{
    ema_motion_t motion = EMA_MOTION_STUCK;
    if ((torque_Nm > level_forward_Nm) && (angle_rad < screw->stop_upper_rad)) {
        motion = EMA_MOTION_FORWARD;
    } else if ((torque_Nm < -level_backward_Nm) && (angle_rad > screw->stop_lower_rad)) {
        motion = EMA_MOTION_BACKWARD;
    } else {
        /* held by dry friction or by the stop */
    }
    return motion;
}

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

void ema_motor_prepare(ema_motor_t* motor, const ema_params_t* params)
{
    motor->torque_constant_Nm_per_A = params->torque_constant_Nm_per_A;
    motor->back_emf_V_s_per_rad = params->back_emf_V_s_per_rad;
    motor->resistance_ohm = params->resistance_ohm;
    motor->inductance_H = params->inductance_H;
    motor->torque_limit_Nm = ema_limit_or_none(params->torque_limit_Nm);
}
