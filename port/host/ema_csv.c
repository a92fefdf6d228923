#include "ema_csv.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "ema_csv_number.h"

/* Bytes of a field, and of a header, that a message shows. */
#define FIELD_SHOWN 24U
#define HEADER_SHOWN 80U

/* A last number without a line end may change by this many times the largest change before it. */
#define CUT_FACTOR 2.0

typedef struct {
    char* begin;
    char* end;
} ema_span_t;

typedef enum {
    EMA_FIELD_MORE = 0,
    EMA_FIELD_LAST = 1,
    EMA_FIELD_OPEN_QUOTE = 2,
    EMA_FIELD_AFTER_QUOTE = 3
} ema_field_t;

/* What is wrong with the first bad number of a row. */
typedef struct {
    ema_number_t kind;
    int32_t column; /* of the file */
    ema_span_t text;
} ema_bad_number_t;

static ema_text_t ema_message(ema_csv_t* csv)
{
    ema_text_t why = ema_text_start(csv->message, sizeof csv->message);
    ema_text_add_path(&why, csv->name);
    ema_text_add(&why, ": ");
    return why;
}

/* An error of the line that was read last; `column` may be NULL. */
static ema_csv_status_t ema_fail_here(ema_csv_t* csv, ema_csv_status_t status, const char* column, const char* text)
{
    ema_text_t why = ema_message(csv);
    ema_csv_rows_where(&why, csv->line, column);
    ema_text_add(&why, text);
    csv->status = status;
    return status;
}

static ema_csv_status_t ema_fail_file(ema_csv_t* csv, ema_csv_status_t status, const char* text)
{
    ema_text_t why = ema_message(csv);
    ema_text_add(&why, text);
    csv->status = status;
    return status;
}

static void ema_add_quoted(ema_text_t* why, ema_span_t text, size_t limit)
{
    ema_text_add(why, "\"");
    ema_text_add_foreign(why, text.begin, (size_t)(text.end - text.begin), limit);
    ema_text_add(why, "\"");
}

static bool ema_blank(char c)
{
    return (c == ' ') || (c == '\t');
}

static ema_span_t ema_trim(ema_span_t text)
{
    while ((text.begin < text.end) && ema_blank(*text.begin)) {
        ++text.begin;
    }
    while ((text.begin < text.end) && ema_blank(text.end[-1])) {
        --text.end;
    }
    return text;
}

static bool ema_starts(const char* text, size_t length, const char* with, size_t with_length)
{
    return (length >= with_length) && (memcmp(text, with, with_length) == 0);
}

/* Brings more bytes behind those that are left. */
static ema_csv_status_t ema_fill(ema_csv_t* csv)
{
    const size_t left = csv->end - csv->begin;
    if (left == EMA_CSV_BUFFER) {
        ++csv->line;
        return ema_fail_here(
            csv, EMA_CSV_ENCODING, NULL,
            "the line is longer than 65535 bytes; save the file as CSV text with LF or CRLF line ends");
    }
    (void)memmove(csv->buffer, csv->buffer + csv->begin, left);
    csv->begin = 0U;
    csv->end = left;
    const int64_t got = csv->source(csv->context, csv->buffer + left, EMA_CSV_BUFFER - left);
    if (got < 0) {
        return ema_fail_file(csv, EMA_CSV_READ,
                             (csv->line == 0) ? "cannot be read; name a CSV file, not a folder or a device"
                                              : "reading stopped on the way; check the disk and copy the file again");
    }
    csv->end += (size_t)got;
    csv->source_ended = got == 0;
    return EMA_CSV_OK;
}

/* The next line without its end, wherever it lies in the buffer. END after the last one. */
static ema_csv_status_t ema_read_line(ema_csv_t* csv, ema_span_t* line)
{
    char* end = NULL;
    size_t searched = 0U;
    while (end == NULL) {
        const size_t left = csv->end - csv->begin;
        end = (left > searched) ? memchr(csv->buffer + csv->begin + searched, '\n', left - searched) : NULL;
        if (end != NULL) {
            continue;
        }
        if (csv->source_ended) {
            break;
        }
        searched = left;
        const ema_csv_status_t status = ema_fill(csv);
        if (status != EMA_CSV_OK) {
            return status;
        }
    }
    csv->line_ended = end != NULL;
    if (!csv->line_ended && (csv->begin == csv->end)) {
        return EMA_CSV_END;
    }
    line->begin = csv->buffer + csv->begin;
    line->end = csv->line_ended ? end : (csv->buffer + csv->end);
    csv->begin = (size_t)(line->end - csv->buffer) + (csv->line_ended ? 1U : 0U);
    if (csv->line_ended && (line->end > line->begin) && (line->end[-1] == '\r')) {
        --line->end;
    }
    ++csv->line;
    return EMA_CSV_OK;
}

/* The next line that is neither blank nor a comment. */
static ema_csv_status_t ema_read_content(ema_csv_t* csv, ema_span_t* line)
{
    for (;;) {
        const ema_csv_status_t status = ema_read_line(csv, line);
        if (status != EMA_CSV_OK) {
            return status;
        }
        const char* at = line->begin;
        while ((at < line->end) && ema_blank(*at)) {
            ++at;
        }
        if ((at < line->end) && (*at != '#')) {
            return EMA_CSV_OK;
        }
        /* With the line ends of another age the whole file would be one comment. */
        if ((at < line->end) && (memchr(at, '\r', (size_t)(line->end - at)) != NULL)) {
            return ema_fail_here(csv, EMA_CSV_ENCODING, NULL,
                                 "a carriage return inside the line; save the file with LF or CRLF line ends");
        }
    }
}

/* A field in double quotes: the quotes are taken off in place. */
static ema_field_t ema_quoted_field(char** at, char* end, ema_span_t* field)
{
    char* from = *at + 1;
    char* to = *at;
    field->begin = to;
    bool open = true;
    while (open && (from < end)) {
        if ((from[0] == '"') && ((from + 1) < end) && (from[1] == '"')) {
            *to = '"';
            ++to;
            from += 2;
        } else if (from[0] == '"') {
            open = false;
            ++from;
        } else {
            *to = *from;
            ++to;
            ++from;
        }
    }
    field->end = to;
    if (open) {
        return EMA_FIELD_OPEN_QUOTE;
    }
    while ((from < end) && ema_blank(*from)) {
        ++from;
    }
    if ((from < end) && (*from != ',')) {
        return EMA_FIELD_AFTER_QUOTE;
    }
    *at = from + 1;
    return (from < end) ? EMA_FIELD_MORE : EMA_FIELD_LAST;
}

/* Takes one field off the front of a line. */
static ema_field_t ema_next_field(char** at, char* end, ema_span_t* field)
{
    char* start = *at;
    while ((start < end) && ema_blank(*start)) {
        ++start;
    }
    if ((start < end) && (*start == '"')) {
        *at = start;
        return ema_quoted_field(at, end, field);
    }
    char* const comma = (start < end) ? memchr(start, ',', (size_t)(end - start)) : NULL;
    field->begin = start;
    field->end = (comma != NULL) ? comma : end;
    *at = field->end + 1;
    return (comma != NULL) ? EMA_FIELD_MORE : EMA_FIELD_LAST;
}

static ema_csv_status_t ema_fail_quote(ema_csv_t* csv, ema_field_t field)
{
    return ema_fail_here(csv, EMA_CSV_FIELDS, NULL,
                         (field == EMA_FIELD_OPEN_QUOTE)
                             ? "a double quote is opened and not closed on this line; close or remove it"
                             : "text stands between a closing double quote and the next comma; remove it");
}

/* The header is checked for what would make every later message misleading. */
static ema_csv_status_t ema_check_header_text(ema_csv_t* csv, ema_span_t line)
{
    const size_t length = (size_t)(line.end - line.begin);
    if (memchr(line.begin, '\0', length) != NULL) {
        return ema_fail_here(csv, EMA_CSV_ENCODING, NULL,
                             "this is no UTF-8 text (it holds zero bytes); save the recording as CSV in UTF-8");
    }
    if (memchr(line.begin, '\r', length) != NULL) {
        return ema_fail_here(csv, EMA_CSV_ENCODING, NULL,
                             "a carriage return inside the line; save the file with LF or CRLF line ends");
    }
    if ((memchr(line.begin, ',', length) == NULL)
        && ((memchr(line.begin, ';', length) != NULL) || (memchr(line.begin, '\t', length) != NULL))) {
        return ema_fail_here(csv, EMA_CSV_HEADER, NULL,
                             "no commas between the columns; write commas between fields and a point in numbers");
    }
    return EMA_CSV_OK;
}

static int8_t ema_column_named(ema_span_t name)
{
    const size_t length = (size_t)(name.end - name.begin);
    for (int i = 0; i < EMA_COLUMN_COUNT; ++i) {
        const char* const known = ema_column_name((ema_column_t)i);
        if ((length == strlen(known)) && (memcmp(name.begin, known, length) == 0)) {
            return (int8_t)i;
        }
    }
    return -1;
}

static ema_csv_status_t ema_missing_column(ema_csv_t* csv, ema_span_t header)
{
    static const char* const what[EMA_COLUMNS_REQUIRED] = {"the time in seconds", "the position command in millimetres",
                                                           "the rod position in millimetres"};
    int missing = 0;
    while ((csv->mask & (1 << missing)) != 0) {
        ++missing;
    }
    ema_text_t why = ema_message(csv);
    ema_csv_rows_where(&why, csv->line, ema_column_name((ema_column_t)missing));
    ema_text_add(&why, "the header has no such column: ");
    ema_add_quoted(&why, header, HEADER_SHOWN);
    ema_text_add(&why, "; give ");
    ema_text_add(&why, what[missing]);
    ema_text_add(&why, " this name");
    csv->status = EMA_CSV_HEADER;
    return csv->status;
}

static ema_csv_status_t ema_take_column(ema_csv_t* csv, ema_span_t name)
{
    if (csv->file_columns == EMA_CSV_FILE_COLUMNS) {
        return ema_fail_here(csv, EMA_CSV_HEADER, NULL, "the header has more than 256 columns; export fewer");
    }
    const int8_t column = ema_column_named(name);
    if (column >= 0) {
        if ((csv->mask & (1 << column)) != 0) {
            return ema_fail_here(csv, EMA_CSV_HEADER, ema_column_name((ema_column_t)column),
                                 "the column stands there twice; rename or remove one of them");
        }
        csv->mask |= 1 << column;
    }
    csv->used_as[csv->file_columns] = column;
    ++csv->file_columns;
    return EMA_CSV_OK;
}

static ema_csv_status_t ema_read_header(ema_csv_t* csv)
{
    ema_span_t line;
    ema_csv_status_t status = ema_read_content(csv, &line);
    if (status == EMA_CSV_END) {
        return ema_fail_file(csv, EMA_CSV_EMPTY,
                             (csv->line == 0) ? "the file is empty; record or export it again"
                                              : "the file holds no header and no rows; record or export it again");
    }
    if (status == EMA_CSV_OK) {
        status = ema_check_header_text(csv, line);
    }
    if (status != EMA_CSV_OK) {
        return status;
    }
    /* Taking quotes off rewrites the line, so the words for a message are kept. */
    char shown[HEADER_SHOWN + 1U];
    const size_t length = (size_t)(line.end - line.begin);
    const size_t kept = (length < sizeof shown) ? length : sizeof shown;
    (void)memcpy(shown, line.begin, kept);
    ema_field_t state = EMA_FIELD_MORE;
    bool numbers = true;
    char* at = line.begin;
    while ((status == EMA_CSV_OK) && (state == EMA_FIELD_MORE)) {
        ema_span_t name;
        double value = 0.0;
        state = ema_next_field(&at, line.end, &name);
        if ((state == EMA_FIELD_OPEN_QUOTE) || (state == EMA_FIELD_AFTER_QUOTE)) {
            status = ema_fail_quote(csv, state);
        } else {
            name = ema_trim(name);
            numbers = numbers && (ema_csv_number(name.begin, name.end, &value) == EMA_NUMBER_OK);
            status = ema_take_column(csv, name);
        }
    }
    if (status != EMA_CSV_OK) {
        return status;
    }
    if (numbers) {
        return ema_fail_here(
            csv, EMA_CSV_HEADER, NULL,
            "numbers where the header must be; add a row such as time_s,command_mm,position_mm above them");
    }
    const int32_t required = (1 << EMA_COLUMNS_REQUIRED) - 1;
    return ((csv->mask & required) == required) ? EMA_CSV_OK
                                                : ema_missing_column(csv, (ema_span_t){shown, shown + kept});
}

/* Name of a column of the file for a message: its own when it is used, else NULL. */
static const char* ema_used_name(const ema_csv_t* csv, int32_t file_column)
{
    const int8_t column = csv->used_as[file_column];
    return (column < 0) ? NULL : ema_column_name((ema_column_t)column);
}

static ema_csv_status_t ema_fail_number(ema_csv_t* csv, const ema_bad_number_t* bad)
{
    ema_text_t why = ema_message(csv);
    ema_csv_rows_where(&why, csv->line, ema_used_name(csv, bad->column));
    if (bad->kind == EMA_NUMBER_EMPTY) {
        ema_text_add(&why, "the field is empty; fill in the measured value or record again");
    } else {
        ema_add_quoted(&why, bad->text, FIELD_SHOWN);
        if (bad->kind == EMA_NUMBER_NOT_FINITE) {
            ema_text_add(&why, " is not a finite number; fill in the measured value or record again");
        } else if (bad->kind == EMA_NUMBER_HUGE) {
            ema_text_add(&why, " is larger than any number can be; correct it");
        } else {
            ema_text_add(&why, " is not a number; write digits with a decimal point");
        }
    }
    csv->status = EMA_CSV_NUMBER;
    return csv->status;
}

static ema_csv_status_t ema_fail_count(ema_csv_t* csv, int32_t count)
{
    const bool few = count < csv->file_columns;
    const bool cut = few && !csv->line_ended;
    ema_text_t why = ema_message(csv);
    ema_csv_rows_where(&why, csv->line, few ? ema_used_name(csv, count) : NULL);
    ema_text_add_whole(&why, count);
    ema_text_add(&why, (count == 1) ? " field where the header has " : " fields where the header has ");
    ema_text_add_whole(&why, csv->file_columns);
    if (cut) {
        ema_text_add(&why, " and no line end: the file is cut off here; copy or record it again");
    } else {
        ema_text_add(&why, few ? "; write every field of the row"
                               : "; remove what is too much (numbers have a decimal point, not a comma)");
    }
    csv->status = cut ? EMA_CSV_CUT : EMA_CSV_FIELDS;
    return csv->status;
}

/* Reads the fields of a line into `row`. */
static ema_csv_status_t ema_read_fields(ema_csv_t* csv, ema_span_t line, double row[EMA_COLUMN_COUNT])
{
    ema_bad_number_t bad = {.kind = EMA_NUMBER_OK};
    ema_field_t state = EMA_FIELD_MORE;
    int32_t count = 0;
    char* at = line.begin;
    while (state == EMA_FIELD_MORE) {
        ema_span_t field;
        state = ema_next_field(&at, line.end, &field);
        if ((state == EMA_FIELD_OPEN_QUOTE) || (state == EMA_FIELD_AFTER_QUOTE)) {
            return ema_fail_quote(csv, state);
        }
        if ((count < csv->file_columns) && (csv->used_as[count] >= 0)) {
            const ema_number_t kind = ema_csv_number(field.begin, field.end, &row[csv->used_as[count]]);
            if ((kind != EMA_NUMBER_OK) && (bad.kind == EMA_NUMBER_OK)) {
                bad = (ema_bad_number_t){.kind = kind, .column = count, .text = ema_trim(field)};
            }
        }
        ++count;
    }
    if (count != csv->file_columns) {
        return ema_fail_count(csv, count);
    }
    if (bad.kind == EMA_NUMBER_OK) {
        return EMA_CSV_OK;
    }
    if (!csv->line_ended && (bad.column == (count - 1))) {
        return ema_fail_here(csv, EMA_CSV_CUT, ema_used_name(csv, bad.column),
                             "the file is cut off inside this number; copy or record it again");
    }
    return ema_fail_number(csv, &bad);
}

/* A file without a last line end may have lost digits of its last number. That shows only when they matter: the number
 * then jumps. */
static ema_csv_status_t ema_check_last_number(ema_csv_t* csv, const double row[EMA_COLUMN_COUNT])
{
    const int8_t column = csv->used_as[csv->file_columns - 1];
    if ((column < 0) || (column == (int8_t)EMA_COLUMN_TIME) || (csv->rows.count == 0)) {
        return EMA_CSV_OK;
    }
    const double step = fabs(row[column] - csv->last[column]);
    if (!csv->line_ended && (step > (CUT_FACTOR * csv->largest_step))) {
        return ema_fail_here(csv, EMA_CSV_CUT, ema_column_name((ema_column_t)column),
                             "the last number has no line end behind it and does not fit those before it: it is cut "
                             "off; copy or record the file again");
    }
    csv->largest_step = (step > csv->largest_step) ? step : csv->largest_step;
    return EMA_CSV_OK;
}

ema_csv_status_t ema_csv_next(ema_csv_t* csv, double row[EMA_COLUMN_COUNT])
{
    if ((csv == NULL) || (row == NULL)) {
        return EMA_CSV_USAGE;
    }
    if (csv->status != EMA_CSV_OK) {
        return csv->status;
    }
    ema_span_t line;
    ema_csv_status_t status = ema_read_content(csv, &line);
    if (status == EMA_CSV_END) {
        ema_text_t why = ema_message(csv);
        status = ema_csv_rows_end(&csv->rows, &why);
        if (status == EMA_CSV_OK) {
            csv->message[0] = '\0';
            status = EMA_CSV_END;
        }
        csv->status = status;
        return status;
    }
    double value[EMA_COLUMN_COUNT];
    if (status == EMA_CSV_OK) {
        for (int i = 0; i < EMA_COLUMN_COUNT; ++i) {
            value[i] = (double)NAN;
        }
        status = ema_read_fields(csv, line, value);
    }
    if (status == EMA_CSV_OK) {
        status = ema_check_last_number(csv, value);
    }
    if (status == EMA_CSV_OK) {
        char reason[EMA_CSV_MESSAGE];
        ema_text_t why = ema_text_start(reason, sizeof reason);
        status = ema_csv_rows_add(&csv->rows, csv->line, value, &why);
        if (status != EMA_CSV_OK) {
            return ema_fail_file(csv, status, reason);
        }
    }
    if (status == EMA_CSV_OK) {
        (void)memcpy(csv->last, value, sizeof value);
        (void)memcpy(row, value, sizeof value);
    }
    return status;
}

ema_csv_status_t ema_csv_skip(ema_csv_t* csv)
{
    if (csv == NULL) {
        return EMA_CSV_USAGE;
    }
    ema_span_t line;
    if (csv->status == EMA_CSV_OK) {
        csv->status = ema_read_content(csv, &line);
        csv->skipped += (csv->status == EMA_CSV_OK) ? 1 : 0;
    }
    return csv->status;
}

ema_csv_status_t ema_csv_fit(ema_csv_t* csv, double travel_mm, double record_period_s)
{
    if (csv == NULL) {
        return EMA_CSV_USAGE;
    }
    if (csv->status != EMA_CSV_END) {
        return csv->status;
    }
    ema_text_t why = ema_message(csv);
    const ema_csv_status_t status = ema_csv_rows_fit(&csv->rows, travel_mm, record_period_s, &why);
    if (status == EMA_CSV_OK) {
        csv->message[0] = '\0';
    }
    return status;
}

static int64_t ema_file_source(void* context, char* buffer, size_t size)
{
    FILE* const file = context;
    const size_t got = fread(buffer, 1U, size, file);
    return ((got == 0U) && (ferror(file) != 0)) ? -1 : (int64_t)got;
}

/* Everything but name and source. */
static void ema_reset(ema_csv_t* csv, const char* name, ema_csv_source_t source, void* context)
{
    csv->name = name;
    csv->source = source;
    csv->context = context;
    csv->file = NULL;
    csv->skipped = 0;
    csv->largest_step = 0.0;
    csv->line = 0;
    csv->begin = 0U;
    csv->end = 0U;
    csv->file_columns = 0;
    csv->mask = 0;
    csv->source_ended = false;
    csv->line_ended = true;
    csv->status = EMA_CSV_OK;
    csv->message[0] = '\0';
    ema_csv_rows_start(&csv->rows);
}

static ema_csv_status_t ema_check_start(ema_csv_t* csv)
{
    ema_csv_status_t status = EMA_CSV_OK;
    /* A pipe may give its first bytes one by one. */
    while ((status == EMA_CSV_OK) && !csv->source_ended && (csv->end < 3U)) {
        status = ema_fill(csv);
    }
    if (status != EMA_CSV_OK) {
        return status;
    }
    if (ema_starts(csv->buffer, csv->end, "\xEF\xBB\xBF", 3U)) {
        csv->begin = 3U;
    } else if (ema_starts(csv->buffer, csv->end, "\xFF\xFE", 2U) || ema_starts(csv->buffer, csv->end, "\xFE\xFF", 2U)) {
        status = ema_fail_file(csv, EMA_CSV_ENCODING, "the text is UTF-16; save the recording as CSV in UTF-8");
    } else {
        status = EMA_CSV_OK;
    }
    return status;
}

ema_csv_status_t ema_csv_start(ema_csv_t* csv, const char* name, ema_csv_source_t source, void* context)
{
    if ((csv == NULL) || (name == NULL) || (source == NULL)) {
        return EMA_CSV_USAGE;
    }
    ema_reset(csv, name, source, context);
    ema_csv_status_t status = ema_check_start(csv);
    if (status == EMA_CSV_OK) {
        status = ema_read_header(csv);
    }
    return status;
}

ema_csv_status_t ema_csv_open(ema_csv_t* csv, const char* path)
{
    if ((csv == NULL) || (path == NULL)) {
        return EMA_CSV_USAGE;
    }
    errno = 0;
    FILE* const file = fopen(path, "rb");
    if (file == NULL) {
        const int reason = errno;
        ema_reset(csv, path, ema_file_source, NULL);
        if (reason == ENOENT) {
            return ema_fail_file(csv, EMA_CSV_OPEN, "there is no such file; check the path");
        }
        return ema_fail_file(csv, EMA_CSV_OPEN, "the file cannot be opened; check its permissions");
    }
    /* The reader has its own buffer; a second one would only copy. Without it the reader is slower and no worse. */
    (void)setvbuf(file, NULL, _IONBF, 0U);
    const ema_csv_status_t status = ema_csv_start(csv, path, ema_file_source, file);
    csv->file = file;
    return status;
}

void ema_csv_close(ema_csv_t* csv)
{
    if ((csv != NULL) && (csv->file != NULL)) {
        (void)fclose((FILE*)csv->file);
        csv->file = NULL;
    }
}
