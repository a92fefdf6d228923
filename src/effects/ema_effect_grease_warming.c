/* Grease that softens while the record runs. The memory is how far it has come, 0 to 1. */
#include "base/ema_math.h"
#include "effects/ema_effect_sites.h"

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
