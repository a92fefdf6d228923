/* A recorded machine in the place of the simulated one: its sensors say, tick by tick, what a record holds, whatever is
 * commanded. So firmware is tried on the chirp of a real machine, on any board. */
#include <string.h>

#include "ace_plant.h"
#include "ace_record.h"

#define ROD 1U
#define CURRENT 2U

static uint32_t next_row;

static float number(uint32_t bits)
{
    float value = 0.0f;
    (void)memcpy(&value, &bits, sizeof value);
    return value;
}

void ace_plant_reset(void)
{
    next_row = 0U;
}

/* After its last row it rests there. The motor's encoder is not in the record: the loop gets the rod's place for it,
 * and moves nothing. */
ace_sensors_t ace_plant_sensors(void)
{
    const uint32_t* const row = ace_record[next_row];
    next_row += ((next_row + 1U) < ace_record_rows) ? 1U : 0U;
    const ace_sensors_t sensors = {number(row[ROD]), number(row[ROD]), number(row[CURRENT])};
    return sensors;
}

void ace_plant_drive(float voltage_V)
{
    (void)voltage_V;
}
