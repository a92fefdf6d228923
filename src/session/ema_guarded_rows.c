#include "ema/ema_guarded.h"

ema_status_t ema_guarded_adopt(ema_guarded_t* guarded, uint32_t rows)
{
    if (guarded == NULL) {
        return EMA_ERR_NULL;
    }
    return (guarded->phase == EMA_GUARDED_FEEDING) ? ema_session_adopt(&guarded->session, rows) : EMA_ERR_ORDER;
}

ema_status_t ema_guarded_gap(ema_guarded_t* guarded)
{
    if (guarded == NULL) {
        return EMA_ERR_NULL;
    }
    return (guarded->phase == EMA_GUARDED_FEEDING) ? ema_session_gap(&guarded->session) : EMA_ERR_ORDER;
}
