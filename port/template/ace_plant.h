/* The machine that the example's board would drive: motor, gears, screw with dry friction and play, integrated in small
 * steps. Not part of the module, and written without it. */
#ifndef ACE_PLANT_H
#define ACE_PLANT_H

#include "ace_board.h"

/* Dry friction and play of this machine, unless the build names another: case A of the project's recordings. */
#ifndef ACE_PLANT_CSJ_NM
#define ACE_PLANT_CSJ_NM 0.3f
#define ACE_PLANT_BLK_MM 0.04125f
#endif

/* What the inverter's dead time takes off the voltage, against the current: the firmware's model has nothing of it. */
#ifndef ACE_PLANT_DEAD_TIME_V
#define ACE_PLANT_DEAD_TIME_V 0.0f
#endif

/* At rest in the middle of its travel and its play, no voltage. */
void ace_plant_reset(void);

/* Moves the machine on by one period with the voltage that was held, and reads its encoders. The first call reads the
 * machine at rest. */
ace_sensors_t ace_plant_sensors(void);

/* The voltage from now on. */
void ace_plant_drive(float voltage_V);

#endif
