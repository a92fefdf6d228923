/* Whole files through the flat calls, and ten million rows in the memory of one reader. */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "ema_close.h"
#include "ema_csv.h"

#define ROWS 150
/* The reader is the same in both builds, so one of them reads the long recording. */
#define LONG_ROWS (EMA_REAL64 ? 100000 : 10000000)

static char path[] = "ema_csv_test_XXXXXX";
static double table[ROWS][EMA_COLUMN_COUNT];
static char message[400];

/* A good file of ROWS rows, `bad` written at row 100 (line 103). */
static void write_file(const char* bad)
{
    (void)strcpy(path, "ema_csv_test_XXXXXX");
    const int handle = mkstemp(path);
    TEST_ASSERT_TRUE(handle >= 0);
    FILE* const file = fdopen(handle, "w");
    TEST_ASSERT_NOT_NULL(file);
    (void)fputs("# made by a test\ntime_s,command_mm,position_mm,current_A\n", file);
    for (int row = 0; row < ROWS; ++row) {
        if ((row == 100) && (bad != NULL)) {
            (void)fputs(bad, file);
        } else {
            (void)fprintf(file, "%.3f,%d,%d.5,-1e-3\n\n", 0.001 * row, row, row);
        }
    }
    TEST_ASSERT_EQUAL_INT(0, fclose(file));
}

void setUp(void)
{
    write_file(NULL);
    message[0] = '\0';
}

void tearDown(void)
{
    (void)remove(path);
}

static ema_csv_status_t load(int64_t capacity, int64_t* rows, int32_t* mask, double* period_s)
{
    return (ema_csv_status_t)ema_csv_load(path, &table[0][0], capacity, rows, mask, period_s, message,
                                          (int32_t)sizeof message);
}

static void test_count_and_load(void)
{
    int64_t rows = 0;
    int32_t mask = 0;
    double period_s = 0.0;
    TEST_ASSERT_EQUAL_INT(EMA_CSV_OK, ema_csv_count(path, &rows, message, (int32_t)sizeof message));
    TEST_ASSERT_EQUAL_INT64(ROWS, rows);
    rows = 0;
    TEST_ASSERT_EQUAL_INT(EMA_CSV_OK, load(ROWS, &rows, &mask, &period_s));
    TEST_ASSERT_EQUAL_STRING("", message);
    TEST_ASSERT_EQUAL_INT64(ROWS, rows);
    TEST_ASSERT_EQUAL_INT(7 | (1 << EMA_COLUMN_CURRENT), mask);
    EMA_ASSERT_CLOSE(0.001, period_s, 1e-15, 0.0);
    for (int row = 0; row < ROWS; ++row) {
        EMA_ASSERT_CLOSE(row, table[row][EMA_COLUMN_COMMAND], 0.0, 0.0);
        EMA_ASSERT_CLOSE(row + 0.5, table[row][EMA_COLUMN_POSITION], 0.0, 0.0);
        EMA_ASSERT_CLOSE(-0.001, table[row][EMA_COLUMN_CURRENT], 0.0, 0.0);
        TEST_ASSERT_TRUE(isnan(table[row][EMA_COLUMN_SPEED]));
    }
}

static void test_a_table_that_is_too_small(void)
{
    int64_t rows = 0;
    int32_t mask = 0;
    double period_s = 0.0;
    TEST_ASSERT_EQUAL_INT(EMA_CSV_CAPACITY, load(ROWS - 1, &rows, &mask, &period_s));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(message, ": row 301: more samples than the 149 there is room for; give the "
                                                 "reader a larger table or shorten the recording"),
                                 message);
    TEST_ASSERT_EQUAL_INT64(ROWS - 1, rows);
}

static void test_an_error_in_the_middle(void)
{
    int64_t rows = 0;
    int32_t mask = 0;
    double period_s = 0.0;
    (void)remove(path);
    write_file("0.100,100,oops,0\n");
    TEST_ASSERT_EQUAL_INT(EMA_CSV_NUMBER, load(ROWS, &rows, &mask, &period_s));
    TEST_ASSERT_NOT_NULL_MESSAGE(
        strstr(message, ": row 203, position_mm: \"oops\" is not a number; write digits with a decimal point"),
        message);
    TEST_ASSERT_EQUAL_INT(0, strncmp(message, path, strlen(path)));
    TEST_ASSERT_EQUAL_INT64(100, rows);
}

static void test_files_that_cannot_be_opened(void)
{
    int64_t rows = 0;
    TEST_ASSERT_EQUAL_INT(EMA_CSV_OPEN, ema_csv_count("no/such/file.csv", &rows, message, (int32_t)sizeof message));
    TEST_ASSERT_EQUAL_STRING("no/such/file.csv: there is no such file; check the path", message);
    TEST_ASSERT_EQUAL_INT64(0, rows);
    TEST_ASSERT_EQUAL_INT(EMA_CSV_OPEN, ema_csv_count("", &rows, message, 10));
    TEST_ASSERT_EQUAL_INT(EMA_CSV_READ, ema_csv_count(".", &rows, message, (int32_t)sizeof message));
    TEST_ASSERT_EQUAL_STRING(".: cannot be read; name a CSV file, not a folder or a device", message);
}

static void test_wrong_calls(void)
{
    int64_t rows = 0;
    int32_t mask = 0;
    double period_s = 0.0;
    TEST_ASSERT_EQUAL_INT(EMA_CSV_USAGE, ema_csv_count(NULL, &rows, message, (int32_t)sizeof message));
    TEST_ASSERT_EQUAL_INT(EMA_CSV_USAGE, ema_csv_count(path, NULL, NULL, 0));
    TEST_ASSERT_EQUAL_INT(EMA_CSV_USAGE, load(-1, &rows, &mask, &period_s));
    TEST_ASSERT_EQUAL_INT(EMA_CSV_USAGE, load(ROWS, NULL, &mask, &period_s));
    TEST_ASSERT_EQUAL_INT(EMA_CSV_USAGE,
                          ema_csv_load(path, NULL, ROWS, &rows, &mask, &period_s, message, (int32_t)sizeof message));
}

/* Rows made while they are read, so that ten million of them need no disk. */
typedef struct {
    int64_t row; /* -1 is the header */
    char line[64];
    size_t left;
    size_t length;
} maker_t;

static size_t put_digits(char* at, int64_t value, int count)
{
    for (int i = count - 1; i >= 0; --i) {
        at[i] = (char)('0' + (value % 10));
        value /= 10;
    }
    return (size_t)count;
}

static void make_line(maker_t* maker)
{
    size_t n = 0U;
    if (maker->row < 0) {
        n = strlen(strcpy(maker->line, "time_s,command_mm,position_mm\n"));
    } else {
        /* 12345.678,1.123456789,1.987654321 */
        n += put_digits(maker->line, maker->row / 1000, 5);
        maker->line[n++] = '.';
        n += put_digits(maker->line + n, maker->row % 1000, 3);
        for (int column = 0; column < 2; ++column) {
            maker->line[n++] = ',';
            maker->line[n++] = '1';
            maker->line[n++] = '.';
            n += put_digits(maker->line + n, (maker->row * (7919 + column)) % 1000000000, 9);
        }
        maker->line[n++] = '\n';
    }
    maker->length = n;
    maker->left = n;
    ++maker->row;
}

static int64_t maker_source(void* context, char* buffer, size_t size)
{
    maker_t* const maker = context;
    size_t made = 0U;
    while (made < size) {
        if ((maker->left == 0U) && (maker->row == LONG_ROWS)) {
            break;
        }
        if (maker->left == 0U) {
            make_line(maker);
        }
        const size_t take = (maker->left < (size - made)) ? maker->left : (size - made);
        (void)memcpy(buffer + made, maker->line + (maker->length - maker->left), take);
        maker->left -= take;
        made += take;
    }
    return (int64_t)made;
}

static void test_ten_million_rows_in_constant_memory(void)
{
    static ema_csv_t reader;
    maker_t maker = {.row = -1};
    double row[EMA_COLUMN_COUNT];
    int64_t sum = 0;
    ema_csv_status_t status = ema_csv_start(&reader, "long.csv", maker_source, &maker);
    while (status == EMA_CSV_OK) {
        status = ema_csv_next(&reader, row);
        if (status == EMA_CSV_OK) {
            sum += (int64_t)floor((row[EMA_COLUMN_POSITION] * 1.0e9) + 0.5) - 1000000000;
        }
    }
    int64_t expected = 0;
    for (int64_t k = 0; k < LONG_ROWS; ++k) {
        expected += (k * 7920) % 1000000000;
    }
    TEST_ASSERT_EQUAL_INT(EMA_CSV_END, status);
    TEST_ASSERT_EQUAL_INT64(LONG_ROWS, reader.rows.count);
    TEST_ASSERT_EQUAL_INT64(LONG_ROWS + 1, reader.line);
    TEST_ASSERT_EQUAL_INT64(expected, sum);
    EMA_ASSERT_CLOSE(0.001, ema_csv_rows_period_s(&reader.rows), 1e-12, 0.0);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_count_and_load);
    RUN_TEST(test_a_table_that_is_too_small);
    RUN_TEST(test_an_error_in_the_middle);
    RUN_TEST(test_files_that_cannot_be_opened);
    RUN_TEST(test_wrong_calls);
    RUN_TEST(test_ten_million_rows_in_constant_memory);
    return UNITY_END();
}
