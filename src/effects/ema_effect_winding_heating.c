/* Copper resistance grows with the winding's temperature. */
#include "ema_effect_sites.h"

#define EMA_COPPER_PER_DEGC EMA_R(0.00393)

void ema_effect_winding_heating_adjust(const ema_effect_winding_heating_t* effect, ema_params_t* params)
{
    params->resistance_ohm *= EMA_R(1.0) + (EMA_COPPER_PER_DEGC * effect->rise_degC);
}
