/* A machine whose sensors say, tick by tick, what a file holds: rod position in mm and current in A, a pair of floats
 * for each tick, in the order of bytes of this machine. For tests alone: a file per run instead of a firmware per
 * record. */
#include <stdio.h>

#include "ace_plant.h"

#define FILE_NAME "ace_record.bin"
#define MOST_ROWS 20000U
#define ROD 0U
#define CURRENT 1U

static struct {
    float rows[MOST_ROWS][2];
    size_t count;
    size_t next;
} played;

/* Without its file there is nothing to play: the sensors say what no sensor says, and the record is refused. */
void ace_plant_reset(void)
{
    FILE* const file = fopen(FILE_NAME, "rb");
    played.next = 0U;
    played.count = 0U;
    if (file != NULL) {
        played.count = fread(played.rows, sizeof played.rows[0], MOST_ROWS, file);
        (void)fclose(file);
    }
    if (played.count == 0U) {
        played.rows[0][ROD] = 1.0e30f;
        played.count = 1U;
    }
}

/* After its last row it rests there. The motor's encoder is not in the file: the loop gets the rod's place for it, and
 * moves nothing. */
ace_sensors_t ace_plant_sensors(void)
{
    const float* const row = played.rows[played.next];
    played.next += ((played.next + 1U) < played.count) ? 1U : 0U;
    const ace_sensors_t sensors = {row[ROD], row[ROD], row[CURRENT]};
    return sensors;
}

void ace_plant_drive(float voltage_V)
{
    (void)voltage_V;
}
