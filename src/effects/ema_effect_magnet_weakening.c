/* Magnets that lost flux: torque constant and back-EMF fall together. */
#include "effects/ema_effect_sites.h"

void ema_effect_magnet_weakening_adjust(const ema_effect_magnet_weakening_t* effect, ema_params_t* params)
{
    params->torque_constant_Nm_per_A *= EMA_R(1.0) - effect->loss;
    params->back_emf_V_s_per_rad *= EMA_R(1.0) - effect->loss;
}
