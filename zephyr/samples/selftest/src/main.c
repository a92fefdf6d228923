/* Whether the module works out here what it works out everywhere, to the bit. */
#include <stdio.h>

#include "ema/ema.h"

int main(void)
{
    static ema_selftest_t memory;
    const uint32_t answer = (uint32_t)ema_selftest(&memory, EMA_SELFTEST_BUILD);
    if (answer == (uint32_t)EMA_SELFTEST_PASSED) {
        printf("ema: self-test passed\n");
    } else {
        printf("ema: self-test failed, 0x%lx: trust no verdict\n", (unsigned long)answer);
    }
    return 0;
}
