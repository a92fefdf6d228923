/* Apart from ema_image.c so that firmware which does without the texts links none of them. */
#include "ema/ema_image.h"

const char* ema_image_text(ema_image_status_t status)
{
    const char* text;
    switch (status) {
#define EMA_IMAGE_CASE(name, value, message)                                                                           \
    case (name):                                                                                                       \
        text = (message);                                                                                              \
        break;
        EMA_IMAGE_STATUS_LIST(EMA_IMAGE_CASE)
#undef EMA_IMAGE_CASE
    default:
        text = "unknown status";
        break;
    }
    return text;
}
