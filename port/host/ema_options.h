/* The command line of ema_identify. */
#ifndef EMA_OPTIONS_H
#define EMA_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct {
    const char* record;
    const char* config; /* NULL: the reference actuator */
    const char* json;   /* NULL: no file */
    uint32_t slice_steps;
    uint64_t seed;
    bool seed_given; /* else the actuator's */
    bool int16;
    double full_scale_mm; /* of the 16-bit integers; 0: from the actuator's travel */
    bool force;
    bool help;
} ema_options_cli_t;

extern const char* const ema_usage_text;

/* Reads the arguments. False when they are wrong, with one line in `message` that says which one and what to do. */
bool ema_options_read(ema_options_cli_t* options, int argc, char* const argv[], char* message, size_t message_size);

#endif
