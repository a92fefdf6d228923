/* Dry friction that differs between the directions. */
#include "effects/ema_effect_sites.h"

void ema_effect_coulomb_asymmetry_adjust(const ema_effect_coulomb_asymmetry_t* effect, ema_params_t* params)
{
    params->friction_asymmetry += effect->asymmetry;
}
