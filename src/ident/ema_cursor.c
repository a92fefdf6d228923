#include "ident/ema_cursor_step.h"

void ema_cursor_start(ema_cursor_t* cursor, const ema_record_t* record, const ema_actuator_t* actuator)
{
    cursor->record = record;
    cursor->every_steps = (uint32_t)actuator->options.record_every_steps;
    cursor->rows = record->count;
    cursor->row = 0U;
    cursor->step_in_row = 0U;
}
