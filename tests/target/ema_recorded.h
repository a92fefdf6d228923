/* The recorded cases and a worn unit, fed to a session: the same bits on host and target. */
#ifndef EMA_RECORDED_H
#define EMA_RECORDED_H

#include <stdbool.h>

#include "ema/ema.h"

#define EMA_RECORDED_ROWS 10000U

/* A session on the reference actuator, or on the unit's own model, with the record's memory. */
typedef struct {
    ema_actuator_t actuator;
    ema_session_config_t config;
    ema_session_t session;
    union {
        ema_real real[2U * EMA_RECORDED_ROWS];
        int16_t int16[2U * EMA_RECORDED_ROWS];
    } buffer;
} ema_recorded_t;

/* Command, rod position and current of row `row` of case 'a', 'b' or 'c', or of the unit 'u'; false for another name or
 * beyond the last row. */
bool ema_recorded_row(char name, uint32_t row, ema_sample_t* sample);

/* Starts a session with `seed` and feeds it the whole recording. The unit has standing effects in its model, and grease
 * and winding of the day are searched too. Errors: those of the session; EMA_ERR_SHORT for an unknown name. */
ema_status_t ema_recorded_start(ema_recorded_t* recorded, char name, uint32_t seed, ema_record_format_t format,
                                ema_search_t search);

#endif
