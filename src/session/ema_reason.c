#include "ema/ema_session.h"

const char* ema_reason_text(uint32_t reason)
{
    const char* text;
    switch (reason) {
#define EMA_REASON_CASE(name, bit, message)                                                                            \
    case (uint32_t)(name):                                                                                             \
        text = (message);                                                                                              \
        break;
        EMA_REASON_LIST(EMA_REASON_CASE)
#undef EMA_REASON_CASE
    default:
        text = "unknown reason";
        break;
    }
    return text;
}
