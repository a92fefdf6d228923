/* Where runs of a model stand beside a record.
 *
 * A plain structure: a copy is a checkpoint. The record's address is read at every step, so a copy may be given another
 * place of the same record.
 */
#ifndef EMA_CURSOR_H
#define EMA_CURSOR_H

#include "ema/ema_record.h"

typedef struct {
    const ema_record_t* record;
    uint32_t every_steps; /* model steps between two rows */
    uint32_t rows;        /* after which the runs end */
    uint32_t row;
    uint32_t step_in_row; /* 0: the present model step shows the row */
} ema_cursor_t;

#endif
