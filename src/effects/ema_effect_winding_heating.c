/* Copper resistance grows with the winding's temperature. */
#include "effects/ema_copper.h"
#include "effects/ema_effect_sites.h"

void ema_effect_winding_heating_adjust(const ema_effect_winding_heating_t* effect, ema_params_t* params)
{
    params->resistance_ohm *= EMA_R(1.0) + (EMA_COPPER_PER_DEGC * effect->rise_degC);
}
