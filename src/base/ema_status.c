#include "ema/detail/ema_status.h"

const char* ema_status_text(ema_status_t status)
{
    const char* text;
    switch (status) {
#define EMA_STATUS_CASE(name, value, message)                                                                          \
    case (name):                                                                                                       \
        text = (message);                                                                                              \
        break;
        EMA_STATUS_LIST(EMA_STATUS_CASE)
#undef EMA_STATUS_CASE
    default:
        text = "unknown status";
        break;
    }
    return text;
}
