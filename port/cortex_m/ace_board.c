/* The example's board on MPS2: SysTick is the tick, the CMSDK timer the counter, both at the same rate; sensors and
 * drive belong to the simulated machine. */
#include "ace_board.h"

#include "ace_plant.h"
#include "ema_counter.h"

#define SYSTICK_CONTROL (*(volatile uint32_t*)0xE000E010U)
#define SYSTICK_RELOAD (*(volatile uint32_t*)0xE000E014U)
#define SYSTICK_VALUE (*(volatile uint32_t*)0xE000E018U)
#define SYSTICK_CORE_CLOCK_INTERRUPT_ENABLE 7U

void ema_systick(void);

static ace_tick_t on_tick;

uint32_t ace_board_start(uint32_t period_ticks, ace_tick_t tick)
{
    on_tick = tick;
    ema_counter_start();
    ace_plant_reset();
    SYSTICK_RELOAD = period_ticks - 1U;
    SYSTICK_VALUE = 0U;
    SYSTICK_CONTROL = SYSTICK_CORE_CLOCK_INTERRUPT_ENABLE;
    return ema_counter_now();
}

void ace_board_stop(void)
{
    SYSTICK_CONTROL = 0U;
}

uint32_t ace_board_now(void)
{
    return ema_counter_now();
}

uint32_t ace_board_hz(void)
{
    return EMA_COUNTER_HZ;
}

ace_sensors_t ace_board_sensors(void)
{
    return ace_plant_sensors();
}

void ace_board_drive(float voltage_V)
{
    ace_plant_drive(voltage_V);
}

void ace_board_wait(void)
{
    /* Awake: asleep (wfi), QEMU's counted time runs away from the timers. A real board sleeps here. */
    __asm__ volatile("nop" ::: "memory");
}

void ema_systick(void)
{
    on_tick();
}
