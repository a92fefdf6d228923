/* What must hold over all rows of a recording, however it was stored: a constant rate, enough rows, lengths in
 * millimetres. */
#ifndef EMA_CSV_ROWS_H
#define EMA_CSV_ROWS_H

#include <stdint.h>

#include "ema_csv_columns.h"
#include "ema_csv_text.h"

/* Everything kept of the rows seen; memory does not grow with them. */
typedef struct {
    int64_t count;
    int64_t last_row; /* as the caller numbers rows */
    double first_time_s;
    double last_time_s;
    double median_step_s; /* of the first rows, known from row EMA_CSV_ROWS_MIN on */
    double early_time_s[EMA_CSV_ROWS_MIN];
    int64_t early_row[EMA_CSV_ROWS_MIN];
    double first_mm[2]; /* command and position */
    double lowest_mm[2];
    double highest_mm[2];
    double sum_mm[2]; /* of the differences to the first row */
    double square_mm2[2];
    double product_mm2;
} ema_csv_rows_t;

void ema_csv_rows_start(ema_csv_rows_t* rows);

/* Takes the next row, numbered `row` for messages, all used values finite. `why` gets "row N, column: ..." after
 * whatever it holds. Errors: EMA_CSV_TIME. A step in the first rows that differs from their median is only known once
 * there are EMA_CSV_ROWS_MIN of them. */
ema_csv_status_t ema_csv_rows_add(ema_csv_rows_t* rows, int64_t row, const double value[EMA_COLUMN_COUNT],
                                  ema_text_t* why);

/* After the last row. Errors: EMA_CSV_EMPTY, EMA_CSV_SHORT. */
ema_csv_status_t ema_csv_rows_end(const ema_csv_rows_t* rows, ema_text_t* why);

/* Mean time between two rows. */
double ema_csv_rows_period_s(const ema_csv_rows_t* rows);

/* Whether rows that ended well can be of an actuator with ends of travel at plus and minus `travel_mm` that records
 * every `record_period_s`: lengths in metres or micrometres and time in milliseconds show here. A rod that does not
 * follow its command is no error. Errors: EMA_CSV_UNIT, EMA_CSV_PERIOD. */
ema_csv_status_t ema_csv_rows_fit(const ema_csv_rows_t* rows, double travel_mm, double record_period_s,
                                  ema_text_t* why);

/* Adds "row N, column: ". */
void ema_csv_rows_where(ema_text_t* why, int64_t row, const char* column);

#endif
