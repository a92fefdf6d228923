#include "ema_counter.h"

#ifdef EMA_BOARD_AN505
#define TIMER0 0x50000000U
#else
#define TIMER0 0x40000000U
#endif
#define TIMER0_CONTROL (*(volatile uint32_t*)TIMER0)
#define TIMER0_VALUE (*(volatile uint32_t*)(TIMER0 + 4U))
#define TIMER0_RELOAD (*(volatile uint32_t*)(TIMER0 + 8U))
#define TIMER0_ENABLE 1U

void ema_counter_start(void)
{
    TIMER0_CONTROL = 0U;
    TIMER0_RELOAD = UINT32_MAX;
    TIMER0_VALUE = UINT32_MAX;
    TIMER0_CONTROL = TIMER0_ENABLE;
}

uint32_t ema_counter_now(void)
{
    /* it counts down */
    return UINT32_MAX - TIMER0_VALUE;
}
