/* Recordings as CSV, row by row, in constant memory: a wrong answer is never given, an error is one line that names
 * file, row and column.
 *
 * UTF-8 with or without byte order mark, LF or CRLF, comma between fields, `#` comment lines and blank lines anywhere,
 * one header row, columns by name in any order, further columns ignored, fields optionally in double quotes. Rows are
 * numbered as lines of the file, from 1, the way an editor shows them. The reader keeps no global state and touches
 * nothing but its own structure; a program in any locale reads the same numbers.
 *
 *     if (ema_csv_open(&csv, path) == EMA_CSV_OK) {
 *         while ((status = ema_csv_next(&csv, row)) == EMA_CSV_OK) { use(row); }
 *     }
 *     ema_csv_close(&csv);          status is EMA_CSV_END, or csv.message says what is wrong
 *
 * Rows handed out before an error are part of a bad recording: nothing may be concluded from them.
 */
#ifndef EMA_CSV_H
#define EMA_CSV_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ema_csv_columns.h"
#include "ema_csv_rows.h"

/* The longest line that is read. */
#define EMA_CSV_BUFFER 65536

/* Most columns of a file, used ones and others. */
#define EMA_CSV_FILE_COLUMNS 256

#define EMA_CSV_MESSAGE 640

/* Bytes put into `buffer`, at most `size`; 0 at the end, -1 when reading failed. */
typedef int64_t (*ema_csv_source_t)(void* context, char* buffer, size_t size);

typedef struct {
    const char* name; /* for messages; must outlive the reader */
    ema_csv_source_t source;
    void* context;
    void* file; /* to be closed, or NULL */
    ema_csv_rows_t rows;
    double last[EMA_COLUMN_COUNT];
    int64_t skipped;     /* rows passed over by ema_csv_skip */
    double largest_step; /* largest change between two rows in the used column that ends the line */
    int64_t line;        /* number of the last line read */
    size_t begin;        /* of what is not yet used in the buffer */
    size_t end;
    int32_t file_columns;
    int32_t mask; /* bit i: column i of ema_column_t is there */
    bool source_ended;
    bool line_ended; /* the last line read had a line end */
    ema_csv_status_t status;
    int8_t used_as[EMA_CSV_FILE_COLUMNS]; /* ema_column_t, or -1 */
    char message[EMA_CSV_MESSAGE];
    char buffer[EMA_CSV_BUFFER];
} ema_csv_t;

/* Starts on a file, or on any source of bytes, and reads as far as the header. Errors: EMA_CSV_OPEN, READ, ENCODING,
 * EMPTY, HEADER. */
ema_csv_status_t ema_csv_open(ema_csv_t* csv, const char* path);
ema_csv_status_t ema_csv_start(ema_csv_t* csv, const char* name, ema_csv_source_t source, void* context);

/* The next row; columns that are not there are NaN. EMA_CSV_END after the last one. Errors: READ, ENCODING, EMPTY,
 * FIELDS, CUT, NUMBER, TIME, SHORT; once there was one, it is answered again. */
ema_csv_status_t ema_csv_next(ema_csv_t* csv, double row[EMA_COLUMN_COUNT]);

/* Passes over the next row without looking at its fields; EMA_CSV_END after the last one. Not to be mixed with
 * ema_csv_next. Errors: READ, ENCODING. */
ema_csv_status_t ema_csv_skip(ema_csv_t* csv);

/* Whether the rows read, all of them, can be of an actuator: see ema_csv_rows_fit. */
ema_csv_status_t ema_csv_fit(ema_csv_t* csv, double travel_mm, double record_period_s);

/* Closes the file, if one was opened. */
void ema_csv_close(ema_csv_t* csv);

/* Flat calls for other languages. All answer an ema_csv_status_t as int, 0 for success; on an error `message` is one
 * line, cut to fit `message_size`. */

/* Number of rows of samples in a good file, without looking at the numbers: the size that ema_csv_load needs. */
int32_t ema_csv_count(const char* path, int64_t* rows, char* message, int32_t message_size);

/* Fills `out`, row-major with EMA_COLUMN_COUNT columns in the order of ema_column_t; columns that are not there are NaN
 * and their bit in `columns_mask` is 0. `period_s` is the mean time between rows. */
int32_t ema_csv_load(const char* path, double* out, int64_t capacity_rows, int64_t* rows, int32_t* columns_mask,
                     double* period_s, char* message, int32_t message_size);

/* The checks of ema_csv_load on a table that came from elsewhere; rows are numbered from 1. */
int32_t ema_csv_table_check(const char* name, const double* table, int64_t rows, int32_t columns_mask, double* period_s,
                            char* message, int32_t message_size);

/* ema_csv_rows_fit on a table that passed ema_csv_load or ema_csv_table_check. */
int32_t ema_csv_table_fit(const char* name, const double* table, int64_t rows, double travel_mm, double record_period_s,
                          char* message, int32_t message_size);

#endif
