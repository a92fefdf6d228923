/* One model step after the other beside a record. What a row is compared with, and how many steps make a slice, is the
 * caller's:
 *
 *     ema_tick(..., ema_cursor_command(cursor, step), &shown)      for each run of the model
 *     if (ema_cursor_row_due(cursor)) { shown against row cursor->row }
 *     ema_cursor_pass(cursor)
 */
#ifndef EMA_CURSOR_STEP_H
#define EMA_CURSOR_STEP_H

#include "ema/ema_record.h"
#include "ident/ema_record_row.h"

/* To the first step of a run of `actuator`, which passes all rows of the record. */
void ema_cursor_start(ema_cursor_t* cursor, const ema_record_t* record, const ema_actuator_t* actuator);

static inline bool ema_cursor_ended(const ema_cursor_t* cursor)
{
    return cursor->row >= cursor->rows;
}

/* Command of the present step, which is model step `step`: one that was recorded is held from row to row. */
static inline ema_real ema_cursor_command(const ema_cursor_t* cursor, uint32_t step)
{
    return ema_record_command(cursor->record, cursor->row, step);
}

/* Whether the present step shows a row. */
static inline bool ema_cursor_row_due(const ema_cursor_t* cursor)
{
    return cursor->step_in_row == 0U;
}

/* To the next step. */
static inline void ema_cursor_pass(ema_cursor_t* cursor)
{
    ++cursor->step_in_row;
    if (cursor->step_in_row == cursor->every_steps) {
        cursor->step_in_row = 0U;
        ++cursor->row;
    }
}

#endif
