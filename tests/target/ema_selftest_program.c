/* The self-test alone: its outcome is the exit code. */
#include "ema/ema.h"

static ema_selftest_t memory;

int main(void)
{
    return (int)ema_selftest(&memory, EMA_SELFTEST_BUILD);
}
