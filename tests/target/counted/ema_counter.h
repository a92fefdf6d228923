/* The boards' counter (port/cortex_m/ema_counter.h) for programs that run on no board: it counts instructions, said by
 * what runs the program. Each passes as one tick, which is as long as an instruction under QEMU's -icount shift=6.
 */
#ifndef EMA_COUNTER_H
#define EMA_COUNTER_H

#include <stdint.h>

#define EMA_COUNTER_HZ 15625000U

void ema_counter_start(void);

/* Instructions since the start, modulo 2^32. */
uint32_t ema_counter_now(void);

#endif
