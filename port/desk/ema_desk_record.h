/* A record of the module from the desk's arrays. */
#ifndef EMA_DESK_RECORD_H
#define EMA_DESK_RECORD_H

#include "ema/ema.h"

/* Row `row` of the arrays. */
ema_sample_t ema_sample_from(const double* command_mm, const double* channels, int32_t row);

/* A buffer of reals, or of int16 scaled to the largest value of each column, with the channels that have a weight or
 * are to be kept. The buffer is to be freed. Errors: EMA_ERR_FULL without memory. */
ema_status_t ema_record_config_from(ema_record_config_t* config, const double* command_mm, const double* channels,
                                    const double* weight, const bool* keep, int32_t rows, int32_t int16_record);

#endif
