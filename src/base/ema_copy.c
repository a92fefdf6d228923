#include "ema_copy.h"

void ema_copy(void* to, const void* from, size_t size)
{
    unsigned char* const place = (unsigned char*)to;
    const unsigned char* const value = (const unsigned char*)from;
    for (size_t k = 0; k < size; ++k) {
        place[k] = value[k];
    }
}
