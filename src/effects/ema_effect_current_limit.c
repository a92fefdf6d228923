/* The drive limits the current; the tighter of two limits counts. */
#include "effects/ema_effect_sites.h"

void ema_effect_current_limit_adjust(const ema_effect_current_limit_t* effect, ema_params_t* params)
{
    if (!(params->current_limit_A > EMA_R(0.0)) || (effect->limit_A < params->current_limit_A)) {
        params->current_limit_A = effect->limit_A;
    }
}
