#include "ema_copy.h"

#include <stdint.h>
#include <string.h>

void ema_copy(void* to, const void* from, size_t size)
{
    unsigned char* const place = (unsigned char*)to;
    const unsigned char* const value = (const unsigned char*)from;
    for (size_t k = 0; k < size; k += sizeof(uint32_t)) {
        uint32_t word;
        (void)memcpy(&word, &value[k], sizeof word); /* EMA-D3 */
        (void)memcpy(&place[k], &word, sizeof word); /* EMA-D3 */
    }
}

void ema_clear(void* place, size_t size)
{
    (void)memset(place, 0, size);
}
