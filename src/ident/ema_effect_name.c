#include "ema/detail/ema_onboard.h"

static const char* const ema_effect_names[] = {
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters) #name,
#include "ema/ema_effects.def"
};

const char* ema_effect_name(ema_effect_id_t effect)
{
    return ((uint32_t)effect < (uint32_t)EMA_EFFECT_COUNT) ? ema_effect_names[effect] : "none";
}
