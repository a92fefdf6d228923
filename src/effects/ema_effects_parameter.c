/* Optional effects that change parameters before a run (site PARAMETER). Equations and sources: ema/ema_effects.def;
 * signatures of the functions: ema_effect_sites.h. */
#include "effects/ema_effect_sites.h"

/* Constant torque against extension. */
void ema_effect_constant_load_adjust(const ema_effect_constant_load_t* effect, ema_params_t* params)
{
    params->load_torque_Nm += effect->torque_Nm;
}

/* Dry friction that differs between the directions. */
void ema_effect_coulomb_asymmetry_adjust(const ema_effect_coulomb_asymmetry_t* effect, ema_params_t* params)
{
    params->friction_asymmetry += effect->asymmetry;
}

/* More viscous damping, as in cold grease. */
void ema_effect_viscous_rise_adjust(const ema_effect_viscous_rise_t* effect, ema_params_t* params)
{
    params->viscous_Nm_s_per_rad *= EMA_R(1.0) + effect->rise;
}

/* Added or removed mass. */
void ema_effect_inertia_change_adjust(const ema_effect_inertia_change_t* effect, ema_params_t* params)
{
    params->inertia_kgm2 *= EMA_R(1.0) + effect->change;
}

/* Copper resistance grows with the winding's temperature. */
void ema_effect_winding_heating_adjust(const ema_effect_winding_heating_t* effect, ema_params_t* params)
{
    params->resistance_ohm *= EMA_R(1.0) + (EMA_COPPER_PER_DEGC * effect->rise_degC);
}

/* Magnets that lost flux: torque constant and back-EMF fall together. */
void ema_effect_magnet_weakening_adjust(const ema_effect_magnet_weakening_t* effect, ema_params_t* params)
{
    params->torque_constant_Nm_per_A *= EMA_R(1.0) - effect->loss;
    params->back_emf_V_s_per_rad *= EMA_R(1.0) - effect->loss;
}

/* A bus voltage below its nominal value. */
void ema_effect_supply_sag_adjust(const ema_effect_supply_sag_t* effect, ema_params_t* params)
{
    params->supply_V *= EMA_R(1.0) - effect->sag;
}

/* The drive limits the current; the tighter of two limits counts. */
void ema_effect_current_limit_adjust(const ema_effect_current_limit_t* effect, ema_params_t* params)
{
    if (!(params->current_limit_A > EMA_R(0.0)) || (effect->limit_A < params->current_limit_A)) {
        params->current_limit_A = effect->limit_A;
    }
}

/* Scale error of the rod sensor. */
void ema_effect_sensor_gain_adjust(const ema_effect_sensor_gain_t* effect, ema_params_t* params)
{
    params->rod_gain_error += effect->error;
}

/* Zero shift of the rod sensor. */
void ema_effect_sensor_offset_adjust(const ema_effect_sensor_offset_t* effect, ema_params_t* params)
{
    params->rod_offset_mm += effect->offset_mm;
}

/* The position loop sees an older position. */
void ema_effect_feedback_delay_adjust(const ema_effect_feedback_delay_t* effect, ema_params_t* params)
{
    params->delay_s += effect->delay_s;
}

/* The motor sees the controller's output later. */
void ema_effect_actuation_delay_adjust(const ema_effect_actuation_delay_t* effect, ema_params_t* params)
{
    params->output_delay_s += effect->delay_s;
}

/* The position gain of the control law has drifted, in either structure. */
void ema_effect_gain_drift_adjust(const ema_effect_gain_drift_t* effect, ema_params_t* params)
{
    params->kp_per_m *= EMA_R(1.0) + effect->drift;
    params->position_gain_per_s *= EMA_R(1.0) + effect->drift;
}
