#include "base/ema_copy.h"

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
    const uint32_t zero = 0U;
    unsigned char* at = (unsigned char*)place;
    size_t left = size;
    /* four words at once: what a round takes besides is half of it otherwise */
    while (left >= (4U * sizeof zero)) {
        (void)memcpy(&at[0], &zero, sizeof zero);                /* EMA-D3 */
        (void)memcpy(&at[sizeof zero], &zero, sizeof zero);      /* EMA-D3 */
        (void)memcpy(&at[2U * sizeof zero], &zero, sizeof zero); /* EMA-D3 */
        (void)memcpy(&at[3U * sizeof zero], &zero, sizeof zero); /* EMA-D3 */
        at = &at[4U * sizeof zero];
        left -= 4U * sizeof zero;
    }
    while (left > 0U) {
        (void)memcpy(at, &zero, sizeof zero); /* EMA-D3 */
        at = &at[sizeof zero];
        left -= sizeof zero;
    }
}
