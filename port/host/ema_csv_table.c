/* The flat calls: whole recordings as tables of doubles. */
#include "ema_csv.h"

#include <math.h>
#include <string.h>

static ema_text_t ema_table_message(char* message, int32_t message_size, const char* name)
{
    ema_text_t why = ema_text_start(message, ((message != NULL) && (message_size > 0)) ? (size_t)message_size : 0U);
    if (name != NULL) {
        ema_text_add_path(&why, name);
        ema_text_add(&why, ": ");
    }
    return why;
}

static int32_t ema_usage(char* message, int32_t message_size)
{
    ema_text_t why = ema_table_message(message, message_size, NULL);
    ema_text_add(&why, "a recording was asked for with a null pointer or a negative size; correct the call");
    return (int32_t)EMA_CSV_USAGE;
}

/* Passes the reader's answer on. The end of the file is the end of a good one. */
static int32_t ema_finish(ema_csv_t* csv, ema_csv_status_t status, char* message, int32_t message_size)
{
    ema_csv_close(csv);
    if (status == EMA_CSV_END) {
        return (int32_t)EMA_CSV_OK;
    }
    ema_text_t why = ema_table_message(message, message_size, NULL);
    ema_text_add_foreign(&why, csv->message, strlen(csv->message), sizeof csv->message);
    return (int32_t)status;
}

int32_t ema_csv_count(const char* path, int64_t* rows, char* message, int32_t message_size)
{
    if ((path == NULL) || (rows == NULL)) {
        return ema_usage(message, message_size);
    }
    ema_csv_t csv;
    ema_csv_status_t status = ema_csv_open(&csv, path);
    while (status == EMA_CSV_OK) {
        status = ema_csv_skip(&csv);
    }
    *rows = csv.skipped;
    return ema_finish(&csv, status, message, message_size);
}

int32_t ema_csv_load(const char* path, double* out, int64_t capacity_rows, int64_t* rows, int32_t* columns_mask,
                     double* period_s, char* message, int32_t message_size)
{
    if ((path == NULL) || (out == NULL) || (capacity_rows < 0) || (rows == NULL) || (columns_mask == NULL)
        || (period_s == NULL)) {
        return ema_usage(message, message_size);
    }
    ema_csv_t csv;
    double row[EMA_COLUMN_COUNT];
    int64_t count = 0;
    ema_csv_status_t status = ema_csv_open(&csv, path);
    while (status == EMA_CSV_OK) {
        status = ema_csv_next(&csv, row);
        if ((status == EMA_CSV_OK) && (count == capacity_rows)) {
            ema_text_t why = ema_table_message(csv.message, (int32_t)sizeof csv.message, path);
            ema_csv_rows_where(&why, csv.line, NULL);
            ema_text_add(&why, "more samples than the ");
            ema_text_add_whole(&why, capacity_rows);
            ema_text_add(&why, " there is room for; give the reader a larger table or shorten the recording");
            status = EMA_CSV_CAPACITY;
        } else if (status == EMA_CSV_OK) {
            (void)memcpy(out + (count * EMA_COLUMN_COUNT), row, sizeof row);
            ++count;
        } else {
            continue;
        }
    }
    *rows = count;
    *columns_mask = csv.mask;
    *period_s = ema_csv_rows_period_s(&csv.rows);
    return ema_finish(&csv, status, message, message_size);
}

/* Name of the first used column of a row that is not finite, NULL when all are. */
static const char* ema_not_finite(const double* row, int32_t columns_mask)
{
    for (int i = 0; i < EMA_COLUMN_COUNT; ++i) {
        if (((columns_mask & (1 << i)) != 0) && !isfinite(row[i])) {
            return ema_column_name((ema_column_t)i);
        }
    }
    return NULL;
}

int32_t ema_csv_table_check(const char* name, const double* table, int64_t rows, int32_t columns_mask, double* period_s,
                            char* message, int32_t message_size)
{
    if ((name == NULL) || (table == NULL) || (rows < 0) || (period_s == NULL)) {
        return ema_usage(message, message_size);
    }
    ema_text_t why = ema_table_message(message, message_size, name);
    for (int i = 0; i < EMA_COLUMNS_REQUIRED; ++i) {
        if ((columns_mask & (1 << i)) == 0) {
            ema_text_add(&why, ema_column_name((ema_column_t)i));
            ema_text_add(&why, ": the recording has no such column; give it this name");
            return (int32_t)EMA_CSV_HEADER;
        }
    }
    ema_csv_rows_t seen;
    ema_csv_rows_start(&seen);
    ema_csv_status_t status = EMA_CSV_OK;
    for (int64_t k = 0; (k < rows) && (status == EMA_CSV_OK); ++k) {
        const double* const row = table + (k * EMA_COLUMN_COUNT);
        const char* const bad = ema_not_finite(row, columns_mask);
        if (bad != NULL) {
            ema_csv_rows_where(&why, k + 1, bad);
            ema_text_add(&why, "not a finite number; fill in the measured value or record again");
            status = EMA_CSV_NUMBER;
        } else {
            status = ema_csv_rows_add(&seen, k + 1, row, &why);
        }
    }
    if (status == EMA_CSV_OK) {
        status = ema_csv_rows_end(&seen, &why);
    }
    *period_s = ema_csv_rows_period_s(&seen);
    return (int32_t)status;
}

int32_t ema_csv_table_fit(const char* name, const double* table, int64_t rows, double travel_mm, double record_period_s,
                          char* message, int32_t message_size)
{
    if ((name == NULL) || (table == NULL) || (rows < 0)) {
        return ema_usage(message, message_size);
    }
    ema_csv_rows_t seen;
    ema_csv_rows_start(&seen);
    ema_text_t why = ema_table_message(message, message_size, name);
    ema_csv_status_t status = EMA_CSV_OK;
    for (int64_t k = 0; (k < rows) && (status == EMA_CSV_OK); ++k) {
        status = ema_csv_rows_add(&seen, k + 1, table + (k * EMA_COLUMN_COUNT), &why);
    }
    if (status == EMA_CSV_OK) {
        status = ema_csv_rows_fit(&seen, travel_mm, record_period_s, &why);
    }
    return (int32_t)status;
}
