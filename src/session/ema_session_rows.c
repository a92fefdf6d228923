#include "ema/ema_session.h"

static bool ema_session_feeds(const ema_session_t* session)
{
    return (session->config != NULL) && (session->phase == EMA_PHASE_FEEDING);
}

ema_status_t ema_session_adopt(ema_session_t* session, uint32_t rows)
{
    if (session == NULL) {
        return EMA_ERR_NULL;
    }
    return ema_session_feeds(session) ? ema_record_adopt(&session->record, rows) : EMA_ERR_ORDER;
}

ema_status_t ema_session_gap(ema_session_t* session)
{
    if (session == NULL) {
        return EMA_ERR_NULL;
    }
    if (!ema_session_feeds(session)) {
        return EMA_ERR_ORDER;
    }
    session->gap = true;
    return EMA_OK;
}
