#include "ema_guarded_place.h"

#include "ema_math.h"

/* The table is linear in CSJ and BLK: farther than to half or twice the healthy value its shifts are not followed. */
#define EMA_START_LOWER EMA_R(0.5)
#define EMA_START_UPPER EMA_R(2.0)

void ema_guarded_place(ema_guarded_t* guarded)
{
    const ema_session_config_t* const config = guarded->session.config;
    const ema_signatures_t* const table = guarded->signatures;
    ema_annealer_config_t annealer = guarded->session.annealer.config;
    for (uint32_t i = 0; i < config->identified_count; ++i) {
        const ema_identified_t* const identified = &config->identified[i];
        ema_real value = EMA_R(0.0);
        (void)ema_actuator_get(config->actuator, identified->id, &value);
        ema_real start = value;
        for (uint32_t k = 0; k < table->faults; ++k) {
            if (table->fault[k].id == identified->id) {
                start = ema_clamp(value + guarded->finding.moved[k], EMA_START_LOWER * value, EMA_START_UPPER * value);
            }
        }
        annealer.start[i] =
            ema_clamp((start - identified->lower) / (identified->upper - identified->lower), EMA_R(0.0), EMA_R(1.0));
    }
    /* nothing but the start differs from what was checked */
    (void)ema_annealer_init(&guarded->session.annealer, &annealer);
    guarded->session.starts_healthy = false;
}
