/* A free-running counter of the MPS2 boards: timer 0 of the CMSDK, 32 bits; at 25 MHz it wraps after 171 s.
 *
 * Under QEMU's -icount shift=N an instruction takes 2^N ns of the emulated time, so that differences count
 * instructions: 25 ticks are 1000 ns at 25 MHz.
 */
#ifndef EMA_COUNTER_H
#define EMA_COUNTER_H

#include <stdint.h>

#ifdef EMA_BOARD_AN505
#define EMA_COUNTER_HZ 20000000U
#else
#define EMA_COUNTER_HZ 25000000U
#endif

void ema_counter_start(void);

/* Ticks since the start, modulo 2^32. */
uint32_t ema_counter_now(void);

#endif
