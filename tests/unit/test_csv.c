/* The CSV reader: everything the format allows gives the same rows, everything else gives one exact line. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "ema_close.h"
#include "ema_csv.h"

#define ROWS 120
#define TEXT_SIZE 300000U

void setUp(void)
{
}

void tearDown(void)
{
}

/* A recording in memory, handed out in pieces of a chosen size. */
typedef struct {
    const char* bytes;
    size_t length;
    size_t at;
    size_t piece;
    size_t fails_at;
} memory_t;

static int64_t memory_source(void* context, char* buffer, size_t size)
{
    memory_t* const memory = context;
    size_t take = memory->length - memory->at;
    take = (take < size) ? take : size;
    take = (take < memory->piece) ? take : memory->piece;
    if (memory->at >= memory->fails_at) {
        return -1;
    }
    (void)memcpy(buffer, memory->bytes + memory->at, take);
    memory->at += take;
    return (int64_t)take;
}

static ema_csv_t reader;
static char text[TEXT_SIZE];
static size_t text_length;
static double rows[ROWS][EMA_COLUMN_COUNT];

static void add(const char* piece)
{
    const size_t length = strlen(piece);
    TEST_ASSERT_TRUE(text_length + length < TEXT_SIZE);
    (void)memcpy(text + text_length, piece, length + 1U);
    text_length += length;
}

static double command_at(int row)
{
    return 2.0 * sin(0.05 * row);
}

static double position_at(int row)
{
    return 1.9 * sin(0.05 * row - 0.1);
}

static void add_row(int row)
{
    char line[120];
    (void)snprintf(line, sizeof line, "%.3f,%.17g,%.17g\n", 0.001 * row, command_at(row), position_at(row));
    add(line);
}

/* Header and rows, row `replaced` (from 0) written as given; NULL leaves it out. The header is line 1, so row k is line
 * k + 2. */
static void build(const char* header, int count, int replaced, const char* as)
{
    text_length = 0U;
    add(header);
    for (int row = 0; row < count; ++row) {
        if (row != replaced) {
            add_row(row);
        } else if (as != NULL) {
            add(as);
        } else {
            continue;
        }
    }
}

static ema_csv_status_t read_memory(memory_t* memory)
{
    ema_csv_status_t status = ema_csv_start(&reader, "rec.csv", memory_source, memory);
    int64_t count = 0;
    double row[EMA_COLUMN_COUNT];
    while (status == EMA_CSV_OK) {
        status = ema_csv_next(&reader, row);
        if ((status == EMA_CSV_OK) && (count < ROWS)) {
            (void)memcpy(rows[count], row, sizeof row);
        }
        count += (status == EMA_CSV_OK) ? 1 : 0;
    }
    return status;
}

static ema_csv_status_t read_text(void)
{
    memory_t memory = {.bytes = text, .length = text_length, .piece = TEXT_SIZE, .fails_at = TEXT_SIZE};
    return read_memory(&memory);
}

static void assert_answer(ema_csv_status_t status, const char* message)
{
    const ema_csv_status_t answer = read_text();
    TEST_ASSERT_EQUAL_STRING(message, reader.message);
    TEST_ASSERT_EQUAL_INT(status, answer);
    /* the answer stays */
    double row[EMA_COLUMN_COUNT];
    TEST_ASSERT_EQUAL_INT(status, ema_csv_next(&reader, row));
    TEST_ASSERT_EQUAL_STRING(message, reader.message);
}

static void assert_good(void)
{
    assert_answer(EMA_CSV_END, "");
    TEST_ASSERT_EQUAL_INT64(ROWS, reader.rows.count);
    for (int row = 0; row < ROWS; ++row) {
        EMA_ASSERT_CLOSE(0.001 * row, rows[row][EMA_COLUMN_TIME], 1e-15, 0.0);
        EMA_ASSERT_CLOSE(command_at(row), rows[row][EMA_COLUMN_COMMAND], 0.0, 0.0);
        EMA_ASSERT_CLOSE(position_at(row), rows[row][EMA_COLUMN_POSITION], 0.0, 0.0);
    }
    EMA_ASSERT_CLOSE(0.001, ema_csv_rows_period_s(&reader.rows), 1e-15, 0.0);
}

#define HEADER "time_s,command_mm,position_mm\n"

static void test_plain_file(void)
{
    build(HEADER, ROWS, -1, NULL);
    assert_good();
    TEST_ASSERT_EQUAL_INT(7, reader.mask);
    TEST_ASSERT_TRUE(isnan(rows[5][EMA_COLUMN_CURRENT]));
    TEST_ASSERT_TRUE(isnan(rows[5][EMA_COLUMN_SPEED]));
}

static void test_pieces_of_any_size_give_the_same(void)
{
    static const size_t pieces[] = {1U, 2U, 3U, 7U, 64U, 1000U};
    build("\xEF\xBB\xBF" HEADER, ROWS, -1, NULL);
    for (size_t i = 0; i < (sizeof pieces / sizeof pieces[0]); ++i) {
        memory_t memory = {.bytes = text, .length = text_length, .piece = pieces[i], .fails_at = TEXT_SIZE};
        TEST_ASSERT_EQUAL_INT(EMA_CSV_END, read_memory(&memory));
        TEST_ASSERT_EQUAL_INT64(ROWS, reader.rows.count);
        EMA_ASSERT_CLOSE(position_at(77), rows[77][EMA_COLUMN_POSITION], 0.0, 0.0);
    }
}

static void test_byte_order_mark_comments_blanks_and_no_last_line_end(void)
{
    build("\xEF\xBB\xBF# made by hand, with a comma\n\n  \n" HEADER "# between\n", ROWS, -1, NULL);
    add("\n# behind");
    assert_good();
    build(HEADER, ROWS, -1, NULL);
    --text_length;
    assert_good();
}

static void test_crlf_quotes_order_and_further_columns(void)
{
    text_length = 0U;
    add("\"note, free\",position_mm, \"command_mm\" ,voltage_V,time_s,\r\n");
    for (int row = 0; row < ROWS; ++row) {
        char line[160];
        (void)snprintf(line, sizeof line, "\"say \"\"go\"\", x\",%.17g, \"%.17g\" ,%d,%.3f,\r\n", position_at(row),
                       command_at(row), -row, 0.001 * row);
        add(line);
    }
    assert_good();
    TEST_ASSERT_EQUAL_INT(7 | (1 << EMA_COLUMN_VOLTAGE), reader.mask);
    EMA_ASSERT_CLOSE(-33.0, rows[33][EMA_COLUMN_VOLTAGE], 0.0, 0.0);
}

static void test_all_columns(void)
{
    text_length = 0U;
    add("speed_mm_s,voltage_V,current_A,motor_position_mm,position_mm,command_mm,time_s\n");
    for (int row = 0; row < ROWS; ++row) {
        char line[160];
        (void)snprintf(line, sizeof line, "%d,2,3,4,%.17g,%.17g,%.3f\n", row, position_at(row), command_at(row),
                       0.001 * row);
        add(line);
    }
    assert_good();
    TEST_ASSERT_EQUAL_INT(127, reader.mask);
    EMA_ASSERT_CLOSE(9.0, rows[9][EMA_COLUMN_SPEED], 0.0, 0.0);
    EMA_ASSERT_CLOSE(2.0, rows[9][EMA_COLUMN_VOLTAGE], 0.0, 0.0);
    EMA_ASSERT_CLOSE(3.0, rows[9][EMA_COLUMN_CURRENT], 0.0, 0.0);
    EMA_ASSERT_CLOSE(4.0, rows[9][EMA_COLUMN_MOTOR_POSITION], 0.0, 0.0);
}

typedef struct {
    const char* row; /* written in place of row 40, line 42 */
    ema_csv_status_t status;
    const char* message;
} bad_row_t;

static const bad_row_t bad_rows[] = {
    {"0.040,abc,1\n", EMA_CSV_NUMBER,
     "rec.csv: row 42, command_mm: \"abc\" is not a number; write digits with a decimal point"},
    {"0.040,1,nan\n", EMA_CSV_NUMBER,
     "rec.csv: row 42, position_mm: \"nan\" is not a finite number; fill in the measured value or record again"},
    {"0.040,-Inf,1\n", EMA_CSV_NUMBER,
     "rec.csv: row 42, command_mm: \"-Inf\" is not a finite number; fill in the measured value or record again"},
    {"0.040,1e999,1\n", EMA_CSV_NUMBER,
     "rec.csv: row 42, command_mm: \"1e999\" is larger than any number can be; correct it"},
    {"0.040,,1\n", EMA_CSV_NUMBER,
     "rec.csv: row 42, command_mm: the field is empty; fill in the measured value or record again"},
    {"0.040,1,\n", EMA_CSV_NUMBER,
     "rec.csv: row 42, position_mm: the field is empty; fill in the measured value or record again"},
    {"0.040,1 \x01 2,1\n", EMA_CSV_NUMBER,
     "rec.csv: row 42, command_mm: \"1 ? 2\" is not a number; write digits with a decimal point"},
    {"0.040,\xC3\xA9\xFF,1\n", EMA_CSV_NUMBER,
     "rec.csv: row 42, command_mm: \"\xC3\xA9?\" is not a number; write digits with a decimal point"},
    {"0.040,abcdefghijklmnopqrstuvwxyz,1\n", EMA_CSV_NUMBER,
     "rec.csv: row 42, command_mm: \"abcdefghijklmnopqrstuvwx...\" is not a number; write digits with a decimal point"},
    {"0.040,1\n", EMA_CSV_FIELDS,
     "rec.csv: row 42, position_mm: 2 fields where the header has 3; write every field of the row"},
    {"0.040\n", EMA_CSV_FIELDS,
     "rec.csv: row 42, command_mm: 1 field where the header has 3; write every field of the row"},
    {"0.040,1,5,1,5\n", EMA_CSV_FIELDS,
     "rec.csv: row 42: 5 fields where the header has 3; remove what is too much (numbers have a decimal point, not a "
     "comma)"},
    {"0.040,\"1,1\n", EMA_CSV_FIELDS,
     "rec.csv: row 42: a double quote is opened and not closed on this line; close or remove it"},
    {"0.040,\"1\"5,1\n", EMA_CSV_FIELDS,
     "rec.csv: row 42: text stands between a closing double quote and the next comma; remove it"},
    {"0.039,1,1\n", EMA_CSV_TIME,
     "rec.csv: row 42, time_s: 0.039 s does not come after 0.039 s; sort the rows by time and remove doubles, or write "
     "time_s with more digits if it was rounded"},
    {"0.0405,1,1\n", EMA_CSV_TIME,
     "rec.csv: row 42, time_s: a step of 0.0015 s where the first rows have 0.001 s; record at a constant rate, or "
     "write time_s with more digits if it was rounded"},
    {NULL, EMA_CSV_TIME,
     "rec.csv: row 42, time_s: a step of 0.002 s where the first rows have 0.001 s, rows missing before it: 1; record "
     "again without gaps"},
};

static void test_bad_rows(void)
{
    for (size_t i = 0; i < (sizeof bad_rows / sizeof bad_rows[0]); ++i) {
        build(HEADER, ROWS, 40, bad_rows[i].row);
        assert_answer(bad_rows[i].status, bad_rows[i].message);
    }
}

/* Behind the first hundred rows each step is looked at at once. */
static void test_uneven_step_late(void)
{
    build(HEADER, ROWS, 110, NULL);
    assert_answer(EMA_CSV_TIME, "rec.csv: row 112, time_s: a step of 0.002 s where the first rows have 0.001 s, rows "
                                "missing before it: 1; record again without gaps");
    build(HEADER, ROWS, 110, "0.11002,1,1\n");
    assert_answer(EMA_CSV_TIME, "rec.csv: row 112, time_s: a step of 0.00102 s where the first rows have 0.001 s; "
                                "record at a constant rate, or write time_s with more digits if it was rounded");
    build(HEADER, ROWS, 110, "0.110005,1,1\n");
    TEST_ASSERT_EQUAL_INT(EMA_CSV_END, read_text());
}

typedef struct {
    const char* header;
    ema_csv_status_t status;
    const char* message;
} bad_header_t;

static const bad_header_t bad_headers[] = {
    {"", EMA_CSV_HEADER,
     "rec.csv: row 1: numbers where the header must be; add a row such as time_s,command_mm,position_mm above them"},
    {"time_s,command_mm,position_m\n", EMA_CSV_HEADER,
     "rec.csv: row 1, position_mm: the header has no such column: \"time_s,command_mm,position_m\"; give the rod "
     "position in millimetres this name"},
    {"# first\ntime_ms,command_mm,position_mm\n", EMA_CSV_HEADER,
     "rec.csv: row 2, time_s: the header has no such column: \"time_ms,command_mm,position_mm\"; give the time in "
     "seconds this name"},
    {"time_s,position_mm\n", EMA_CSV_HEADER,
     "rec.csv: row 1, command_mm: the header has no such column: \"time_s,position_mm\"; give the position command in "
     "millimetres this name"},
    {"time_s,command_mm,position_mm,command_mm\n", EMA_CSV_HEADER,
     "rec.csv: row 1, command_mm: the column stands there twice; rename or remove one of them"},
    {"time_s;command_mm;position_mm\n", EMA_CSV_HEADER,
     "rec.csv: row 1: no commas between the columns; write commas between fields and a point in numbers"},
    {"time_s\tcommand_mm\tposition_mm\n", EMA_CSV_HEADER,
     "rec.csv: row 1: no commas between the columns; write commas between fields and a point in numbers"},
    {"time_s,command_mm,\"position_mm\n", EMA_CSV_FIELDS,
     "rec.csv: row 1: a double quote is opened and not closed on this line; close or remove it"},
    {"time_s,command_mm,position_mm\r0,0,0\r\n", EMA_CSV_ENCODING,
     "rec.csv: row 1: a carriage return inside the line; save the file with LF or CRLF line ends"},
    {"# old\rtime_s,command_mm,position_mm\r0,0,0\r\n", EMA_CSV_ENCODING,
     "rec.csv: row 1: a carriage return inside the line; save the file with LF or CRLF line ends"},
    {"\xFF\xFEt", EMA_CSV_ENCODING, "rec.csv: the text is UTF-16; save the recording as CSV in UTF-8"},
    {"\xFE\xFFt", EMA_CSV_ENCODING, "rec.csv: the text is UTF-16; save the recording as CSV in UTF-8"},
};

static void test_bad_headers(void)
{
    for (size_t i = 0; i < (sizeof bad_headers / sizeof bad_headers[0]); ++i) {
        build(bad_headers[i].header, ROWS, -1, NULL);
        assert_answer(bad_headers[i].status, bad_headers[i].message);
    }
}

static void test_zero_bytes(void)
{
    build(HEADER, ROWS, -1, NULL);
    text[1] = '\0';
    assert_answer(EMA_CSV_ENCODING,
                  "rec.csv: row 1: this is no UTF-8 text (it holds zero bytes); save the recording as CSV in UTF-8");
}

static void test_empty_and_short_files(void)
{
    static const char empty[] = "rec.csv: the file is empty; record or export it again";
    static const char nothing[] = "rec.csv: the file holds no header and no rows; record or export it again";
    text_length = 0U;
    assert_answer(EMA_CSV_EMPTY, empty);
    add("\xEF\xBB\xBF");
    assert_answer(EMA_CSV_EMPTY, empty);
    text_length = 0U;
    add("# only this\n\n");
    assert_answer(EMA_CSV_EMPTY, nothing);
    text_length = 0U;
    add(HEADER);
    assert_answer(EMA_CSV_EMPTY, "rec.csv: there are no rows of samples; record or export it again");
    build(HEADER, 99, -1, NULL);
    assert_answer(EMA_CSV_SHORT,
                  "rec.csv: row 100: the recording ends after 99 samples and needs at least 100; record for longer");
    build(HEADER, 100, -1, NULL);
    assert_answer(EMA_CSV_END, "");
}

/* Wherever a file is cut, it is either refused or what is left of its last number is as good as the whole. */
static void test_cut_anywhere(void)
{
    build(HEADER, ROWS, -1, NULL);
    const size_t whole = text_length;
    size_t accepted = 0U;
    for (size_t length = whole; length > (whole - 400U); --length) {
        text_length = length;
        const ema_csv_status_t status = read_text();
        if (status == EMA_CSV_END) {
            ++accepted;
            const int last = (int)reader.rows.count - 1;
            EMA_ASSERT_CLOSE(position_at(last), rows[last][EMA_COLUMN_POSITION], 0.3, 0.0);
        } else {
            TEST_ASSERT_EQUAL_INT(EMA_CSV_CUT, status);
        }
    }
    TEST_ASSERT_TRUE(accepted > 0U);
    TEST_ASSERT_TRUE(accepted < 300U);
}

static void test_cut_messages(void)
{
    build(HEADER, ROWS - 1, -1, NULL);
    const size_t before = text_length;
    add("0.119,1.1");
    assert_answer(EMA_CSV_CUT, "rec.csv: row 121, position_mm: 2 fields where the header has 3 and no line end: the "
                               "file is cut off here; copy or record it again");
    text_length = before;
    add("0.119,1,-");
    assert_answer(EMA_CSV_CUT,
                  "rec.csv: row 121, position_mm: the file is cut off inside this number; copy or record it again");
    text_length = before;
    add("0.119,1,17");
    assert_answer(EMA_CSV_CUT, "rec.csv: row 121, position_mm: the last number has no line end behind it and does not "
                               "fit those before it: it is cut off;"
                               " copy or record the file again");
}

static void test_long_lines(void)
{
    build(HEADER "#", 0, -1, NULL);
    for (int i = 0; i < 1000; ++i) {
        add("0123456789012345678901234567890123456789012345678901234567890123456789");
    }
    add("\n");
    assert_answer(
        EMA_CSV_ENCODING,
        "rec.csv: row 2: the line is longer than 65535 bytes; save the file as CSV text with LF or CRLF line ends");
    text_length = 0U;
    for (int i = 0; i < 257; ++i) {
        add("a,");
    }
    add(HEADER);
    assert_answer(EMA_CSV_HEADER, "rec.csv: row 1: the header has more than 256 columns; export fewer");
}

static void test_reading_that_fails(void)
{
    build(HEADER, ROWS, -1, NULL);
    memory_t memory = {.bytes = text, .length = text_length, .piece = 100U, .fails_at = 0U};
    TEST_ASSERT_EQUAL_INT(EMA_CSV_READ, read_memory(&memory));
    TEST_ASSERT_EQUAL_STRING("rec.csv: cannot be read; name a CSV file, not a folder or a device", reader.message);
    memory = (memory_t){.bytes = text, .length = text_length, .piece = 100U, .fails_at = 1000U};
    TEST_ASSERT_EQUAL_INT(EMA_CSV_READ, read_memory(&memory));
    TEST_ASSERT_EQUAL_STRING("rec.csv: reading stopped on the way; check the disk and copy the file again",
                             reader.message);
}

static void test_wrong_calls(void)
{
    memory_t memory = {.bytes = text, .length = 0U, .piece = 1U, .fails_at = 1U};
    double row[EMA_COLUMN_COUNT];
    TEST_ASSERT_EQUAL_INT(EMA_CSV_USAGE, ema_csv_start(NULL, "rec.csv", memory_source, &memory));
    TEST_ASSERT_EQUAL_INT(EMA_CSV_USAGE, ema_csv_start(&reader, NULL, memory_source, &memory));
    TEST_ASSERT_EQUAL_INT(EMA_CSV_USAGE, ema_csv_start(&reader, "rec.csv", NULL, &memory));
    TEST_ASSERT_EQUAL_INT(EMA_CSV_USAGE, ema_csv_open(NULL, "rec.csv"));
    TEST_ASSERT_EQUAL_INT(EMA_CSV_USAGE, ema_csv_open(&reader, NULL));
    TEST_ASSERT_EQUAL_INT(EMA_CSV_USAGE, ema_csv_next(NULL, row));
    TEST_ASSERT_EQUAL_INT(EMA_CSV_USAGE, ema_csv_next(&reader, NULL));
    TEST_ASSERT_EQUAL_INT(EMA_CSV_USAGE, ema_csv_skip(NULL));
    TEST_ASSERT_EQUAL_INT(EMA_CSV_USAGE, ema_csv_fit(NULL, 25.0, 0.001));
    ema_csv_close(NULL);
}

/* A name of any length and content stays one line, and the reason behind it is not lost. */
static void test_strange_names(void)
{
    char name[600];
    (void)memset(name, 'x', sizeof name);
    name[sizeof name - 1U] = '\0';
    name[sizeof name - 5U] = '\n';
    text_length = 0U;
    memory_t memory = {.bytes = text, .length = 0U, .piece = 1U, .fails_at = 1U};
    TEST_ASSERT_EQUAL_INT(EMA_CSV_EMPTY, ema_csv_start(&reader, name, memory_source, &memory));
    TEST_ASSERT_NULL(strchr(reader.message, '\n'));
    TEST_ASSERT_NOT_NULL(strstr(reader.message, "x?xxx: the file is empty; record or export it again"));
    TEST_ASSERT_EQUAL_INT(0, strncmp(reader.message, "...xxx", 6U));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_plain_file);
    RUN_TEST(test_pieces_of_any_size_give_the_same);
    RUN_TEST(test_byte_order_mark_comments_blanks_and_no_last_line_end);
    RUN_TEST(test_crlf_quotes_order_and_further_columns);
    RUN_TEST(test_all_columns);
    RUN_TEST(test_bad_rows);
    RUN_TEST(test_uneven_step_late);
    RUN_TEST(test_bad_headers);
    RUN_TEST(test_zero_bytes);
    RUN_TEST(test_empty_and_short_files);
    RUN_TEST(test_cut_anywhere);
    RUN_TEST(test_cut_messages);
    RUN_TEST(test_long_lines);
    RUN_TEST(test_reading_that_fails);
    RUN_TEST(test_wrong_calls);
    RUN_TEST(test_strange_names);
    return UNITY_END();
}
