/* Under a machine for WebAssembly that counts instructions and says so by a function of its own (run_wasm.py). */
#include "ema_counter.h"

__attribute__((import_module("ema"), import_name("counted"))) uint32_t ema_counted(void);

void ema_counter_start(void)
{
}

uint32_t ema_counter_now(void)
{
    return ema_counted();
}
