/* A healthy actuator from flat text: lines `section.field = value`, `#` comments. Values that the file does not name
 * are the reference actuator's. */
#ifndef EMA_CONFIG_H
#define EMA_CONFIG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "ema/ema.h"

/* Reads and checks the actuator in the file at `path`. False when that fails, with one line in `message` that names
 * file, row and value. */
bool ema_config_read(ema_actuator_t* actuator, const char* path, char* message, size_t message_size);

/* The same from a file that is open; `name` is the one that messages show. The file stays open. */
bool ema_config_take(ema_actuator_t* actuator, FILE* file, const char* name, char* message, size_t message_size);

#endif
