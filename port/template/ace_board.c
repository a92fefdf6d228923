/* A board without hardware: it runs anywhere, with the example's simulated machine on its pins.
 *
 * Time passes only while the firmware waits, a period at a time; a slice takes none. Each function says what a real
 * board does in its place.
 */
#include "ace_board.h"

#include <stddef.h>

#include "ace_plant.h"

#define COUNTER_HZ 1000000U

static uint32_t counter;
static uint32_t period;
static ace_tick_t on_tick;

/* Real: start a free-running timer, program the tick timer's reload, enable its interrupt below the drive's and above
 * everything that may wait. */
uint32_t ace_board_start(uint32_t period_ticks, ace_tick_t tick)
{
    period = period_ticks;
    on_tick = tick;
    ace_plant_reset();
    return counter;
}

/* Real: disable the interrupt. */
void ace_board_stop(void)
{
    on_tick = NULL;
}

/* Real: the timer's register, or the core's cycle counter. */
uint32_t ace_board_now(void)
{
    return counter;
}

uint32_t ace_board_hz(void)
{
    return COUNTER_HZ;
}

/* Real: read both encoders and scale them to mm at the rod; the current as the drive last converted it, scaled to A. */
ace_sensors_t ace_board_sensors(void)
{
    return ace_plant_sensors();
}

/* Real: the duty cycle of the inverter. */
void ace_board_drive(float voltage_V)
{
    ace_plant_drive(voltage_V);
}

/* Real: wait for interrupt. Here it comes at once. */
void ace_board_wait(void)
{
    if (on_tick != NULL) {
        counter += period;
        on_tick();
    }
}
