#include "base/ema_effect_rows.h"

const ema_effect_row_t ema_effect_rows[EMA_EFFECT_COUNT] = {
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters)                            \
    {(uint8_t)(sizeof(ema_effect_##name##_t) / sizeof(ema_real)), (uint8_t)EMA_SITE_##site, (substeps##U),             \
     (EMA_HAS_##name != 0)},
#include "ema/ema_effects.def"
};
