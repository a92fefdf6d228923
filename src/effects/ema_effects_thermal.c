/* Optional effects of temperature during a run (sites WINDING and GREASE). Equations and sources: ema/ema_effects.def;
 * signatures of the functions: ema_effect_sites.h. */
#include "base/ema_math.h"
#include "effects/ema_effect_sites.h"

/* A winding that its own loss warms while the record runs. The memory is its temperature over the start's, degC. */
ema_real ema_effect_winding_warming(const ema_effect_winding_warming_t* effect, ema_real memory)
{
    (void)effect;
    return EMA_COPPER_PER_DEGC * memory;
}

ema_real ema_effect_winding_warming_warm(const ema_effect_winding_warming_t* effect, ema_real memory, ema_real heat_W,
                                         ema_real span_s)
{
    const ema_real left = ema_exp(-span_s / effect->time_s);
    const ema_real end_degC = effect->rise_degC_per_W * heat_W;
    return end_degC + ((memory - end_degC) * left);
}

/* Grease that softens while the record runs. The memory is how far it has come, 0 to 1. */
ema_real ema_effect_grease_warming(const ema_effect_grease_warming_t* effect, ema_real memory)
{
    return -effect->fall * memory;
}

ema_real ema_effect_grease_warming_warm(const ema_effect_grease_warming_t* effect, ema_real memory, ema_real heat_W,
                                        ema_real span_s)
{
    (void)heat_W;
    return EMA_R(1.0) + ((memory - EMA_R(1.0)) * ema_exp(-span_s / effect->time_s));
}
