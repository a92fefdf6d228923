/* How far a value is read apart from one healthy run to the next. */
#ifndef EMA_SCATTER_H
#define EMA_SCATTER_H

#include "ema/ema_actuator.h"

/* In % of it; zero of what the actuator says nothing of. */
static inline ema_real ema_scatter_percent(const ema_params_t* params, ema_value_id_t id)
{
    if (id == EMA_VALUE_ID(csj_Nm)) {
        return params->csj_scatter_percent;
    }
    return (id == EMA_VALUE_ID(blk_mm)) ? params->blk_scatter_percent : EMA_R(0.0);
}

#endif
