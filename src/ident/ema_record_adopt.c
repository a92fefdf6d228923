#include "base/ema_math.h"
#include "ident/ema_record_row.h"

ema_status_t ema_record_adopt(ema_record_t* record, uint32_t rows)
{
    if (record == NULL) {
        return EMA_ERR_NULL;
    }
    if (rows > (record->capacity - record->count)) {
        return EMA_ERR_FULL;
    }
    const uint32_t end = record->count + rows;
    /* every count is a number */
    if (!ema_record_counts(record)) {
        for (uint32_t row = record->count; row < end; ++row) {
            for (uint32_t place = 0; place < record->stride; ++place) {
                if (!ema_is_finite(ema_record_value(record, row, place))) {
                    return EMA_ERR_NOT_FINITE;
                }
            }
        }
    }
    /* in the order in which rows are appended, so that the sum is the same to the bit */
    for (uint32_t row = (record->count > 0U) ? record->count : 1U; (ema_record_function(record) == NULL) && (row < end);
         ++row) {
        record->asked_mm += ema_abs(ema_record_value(record, row, 0U) - ema_record_value(record, row - 1U, 0U));
    }
    record->count = end;
    return EMA_OK;
}
