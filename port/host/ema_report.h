/* One identification as text for a person and as JSON for a program. */
#ifndef EMA_REPORT_H
#define EMA_REPORT_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "ema/ema.h"

/* Everything that is told about one identification. */
typedef struct {
    const char* record; /* path as given */
    int64_t rows;
    double period_s;
    bool int16;
    const ema_session_config_t* config;
    ema_result_t result;
    double search_s; /* from the first to the last model step */
    double wall_s;   /* from the command line to the answer */
} ema_report_t;

/* Both write to `out`; whether it took everything is ferror's to say. */
void ema_report_text(const ema_report_t* report, FILE* out);
void ema_report_json(const ema_report_t* report, FILE* out);

#endif
