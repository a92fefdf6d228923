/* What a board supplies to the example firmware: a counter, a timer interrupt, three sensors and a drive.
 *
 * A new board copies ace_board.c of this folder, which needs no hardware, and replaces its functions one by one;
 * port/cortex_m/ace_board.c is one that was filled in. Nothing here knows the module, and the module knows nothing of
 * this.
 */
#ifndef ACE_BOARD_H
#define ACE_BOARD_H

#include <stdint.h>

/* What the sensors say at this instant: both encoders in mm at the rod, and the motor's current. */
typedef struct {
    float rod_mm;
    float motor_mm;
    float current_A;
} ace_sensors_t;

/* What the timer interrupt calls. */
typedef void (*ace_tick_t)(void);

/* Starts the counter and a timer interrupt every `period_ticks` of it; its first call of `tick` comes one period from
 * now. The result is the counter at this instant. */
uint32_t ace_board_start(uint32_t period_ticks, ace_tick_t tick);

/* Stops the interrupt. */
void ace_board_stop(void);

/* A free-running counter of 32 bits that wraps; its rate stands in ace_board_hz. Cost: a few cycles. */
uint32_t ace_board_now(void);
uint32_t ace_board_hz(void);

/* Called from the interrupt: reads the sensors, and holds a voltage on the motor until the next call. */
ace_sensors_t ace_board_sensors(void);
void ace_board_drive(float voltage_V);

/* Sleeps until the next interrupt, or returns at once. */
void ace_board_wait(void);

#endif
