/* What the co-simulation units show: names and value references, from the two lists. A unit's library and the program
 * that writes its modelDescription.xml both read them here. */
#ifndef EMA_FMI_LIST_H
#define EMA_FMI_LIST_H

#include "ema/ema.h"

/* 1: the plant alone, its input the drive's output as a share of the full one; 0: with the controller, its input the
 * commanded position in mm. */
#ifndef EMA_FMI_PLANT
#define EMA_FMI_PLANT 0
#endif

enum {
    EMA_FMI_TIME = 0,
    EMA_FMI_INPUT = 1,
    EMA_FMI_POSITION = 2, /* first of the five outputs, in the order of ema_output_t */
    EMA_FMI_OUTPUTS = 5,
    EMA_FMI_START = 7,
    EMA_FMI_VALUE = 16, /* first of the actuator's real values, by their ids; the options follow them */
    EMA_FMI_OPTION = EMA_FMI_VALUE + (int)EMA_VALUE_COUNT,
    EMA_FMI_END = EMA_FMI_OPTION + (int)EMA_OPTION_COUNT
};

/* Which tables of the actuator a unit shows: not what steers identification and verdict, and without a controller none
 * of its gains. The length of the step is a value; rows of a record are the importer's. */
#define EMA_FMI_SHOWS_control (!EMA_FMI_PLANT)
#define EMA_FMI_SHOWS_drive 1
#define EMA_FMI_SHOWS_motor 1
#define EMA_FMI_SHOWS_gearbox 1
#define EMA_FMI_SHOWS_screw 1
#define EMA_FMI_SHOWS_encoder 1
#define EMA_FMI_SHOWS_timing 1
#define EMA_FMI_SHOWS_search 0
#define EMA_FMI_SHOWS_verdict 0

#endif
