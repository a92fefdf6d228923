/* Wrong units and wrong periods show in the travel and in the time of a recording; a rod that stands still is no wrong
 * unit. */
#include <math.h>
#include <string.h>

#include "ema_close.h"
#include "ema_csv.h"

#define ROWS 500
#define TRAVEL_MM 25.0
#define PERIOD_S 1.0e-3
#define MASK 7

static double table[ROWS][EMA_COLUMN_COUNT];
static char message[400];

/* A sine of 2 mm that the rod follows with some lag. */
void setUp(void)
{
    for (int row = 0; row < ROWS; ++row) {
        for (int column = 0; column < EMA_COLUMN_COUNT; ++column) {
            table[row][column] = (double)NAN;
        }
        table[row][EMA_COLUMN_TIME] = 17.0 + (PERIOD_S * row);
        table[row][EMA_COLUMN_COMMAND] = 2.0 * sin(0.03 * row);
        table[row][EMA_COLUMN_POSITION] = 1.9 * sin((0.03 * row) - 0.2);
    }
    message[0] = '\0';
}

void tearDown(void)
{
}

static void scale(ema_column_t column, double factor)
{
    for (int row = 0; row < ROWS; ++row) {
        table[row][column] *= factor;
    }
}

static ema_csv_status_t fit(double travel_mm)
{
    return (ema_csv_status_t)ema_csv_table_fit("rec", &table[0][0], ROWS, travel_mm, PERIOD_S, message,
                                               (int32_t)sizeof message);
}

static void assert_fit(ema_csv_status_t status, const char* text)
{
    const ema_csv_status_t answer = fit(TRAVEL_MM);
    TEST_ASSERT_EQUAL_INT(status, answer);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(message, text), message);
}

static void test_a_good_recording_fits(void)
{
    TEST_ASSERT_EQUAL_INT(EMA_CSV_OK, fit(TRAVEL_MM));
    /* as far as the stroke goes */
    scale(EMA_COLUMN_COMMAND, 12.5);
    scale(EMA_COLUMN_POSITION, 12.5);
    TEST_ASSERT_EQUAL_INT(EMA_CSV_OK, fit(TRAVEL_MM));
    TEST_ASSERT_EQUAL_INT(EMA_CSV_UNIT, fit(20.0));
}

static void test_metres(void)
{
    scale(EMA_COLUMN_COMMAND, 1.0e-3);
    scale(EMA_COLUMN_POSITION, 1.0e-3);
    assert_fit(EMA_CSV_UNIT, "rec: command_mm: travels 0.004 mm where at least 0.05 mm");
    assert_fit(EMA_CSV_UNIT, "looks like metres; multiply the column by 1000");
    /* the position alone */
    scale(EMA_COLUMN_COMMAND, 1.0e3);
    assert_fit(EMA_CSV_UNIT, "rec: position_mm: travels 0.0038 mm along");
    assert_fit(EMA_CSV_UNIT, "looks like metres");
}

/* Whatever fits into the stroke, its thousandth part is not taken for millimetres. */
static void test_metres_of_the_whole_stroke(void)
{
    scale(EMA_COLUMN_COMMAND, 12.49e-3);
    scale(EMA_COLUMN_POSITION, 12.49e-3);
    assert_fit(EMA_CSV_UNIT, "rec: command_mm: travels 0.04996 mm");
    assert_fit(EMA_CSV_UNIT, "looks like metres");
}

static void test_micrometres(void)
{
    scale(EMA_COLUMN_POSITION, 1.0e3);
    assert_fit(EMA_CSV_UNIT, "rec: position_mm: travels 3800 mm");
    assert_fit(EMA_CSV_UNIT, "looks like micrometres; divide the column by 1000");
    scale(EMA_COLUMN_COMMAND, 1.0e3);
    assert_fit(EMA_CSV_UNIT, "rec: command_mm: travels 4000 mm");
    assert_fit(EMA_CSV_UNIT, "looks like micrometres");
    /* inside a long stroke the command gives it away */
    setUp();
    scale(EMA_COLUMN_COMMAND, 0.5);
    scale(EMA_COLUMN_POSITION, 0.5e3);
    TEST_ASSERT_EQUAL_INT(EMA_CSV_UNIT, fit(990.0));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(message, " mm along with a command over 2 mm"), message);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(message, "looks like micrometres"), message);
}

static void test_beyond_every_unit(void)
{
    scale(EMA_COLUMN_COMMAND, 1.0e9);
    assert_fit(EMA_CSV_UNIT,
               "mm and the actuator's stroke is 50 mm; correct the unit of the column, or the actuator's travel_mm");
}

/* A jammed rod shows noise, or nothing at all: a fault, not a bad input. */
static void test_a_rod_that_does_not_follow_is_no_input_error(void)
{
    scale(EMA_COLUMN_POSITION, 0.0);
    TEST_ASSERT_EQUAL_INT(EMA_CSV_OK, fit(TRAVEL_MM));
    for (int row = 0; row < ROWS; ++row) {
        table[row][EMA_COLUMN_POSITION] = 5.0e-3 * sin(1.7 * row * row);
    }
    TEST_ASSERT_EQUAL_INT(EMA_CSV_OK, fit(TRAVEL_MM));
}

static void test_a_command_that_rests(void)
{
    scale(EMA_COLUMN_COMMAND, 0.0);
    assert_fit(EMA_CSV_UNIT, "rec: command_mm: the command never changes; record a command that moves the rod");
}

static void test_a_position_with_an_offset(void)
{
    for (int row = 0; row < ROWS; ++row) {
        table[row][EMA_COLUMN_POSITION] -= 30.0;
    }
    assert_fit(EMA_CSV_UNIT, "rec: position_mm: reaches 31.");
    assert_fit(EMA_CSV_UNIT, "mm from the middle and the actuator's travel ends at 25 mm; take the sensor's offset off "
                             "command and position, or correct travel_mm");
}

static void test_periods(void)
{
    double period_s = 0.0;
    TEST_ASSERT_EQUAL_INT(
        EMA_CSV_OK, ema_csv_table_check("rec", &table[0][0], ROWS, MASK, &period_s, message, (int32_t)sizeof message));
    EMA_ASSERT_CLOSE(PERIOD_S, period_s, 1e-12, 0.0);
    TEST_ASSERT_EQUAL_INT(EMA_CSV_PERIOD, ema_csv_table_fit("rec", &table[0][0], ROWS, TRAVEL_MM, 5.0e-4, message,
                                                            (int32_t)sizeof message));
    TEST_ASSERT_EQUAL_STRING(
        "rec: time_s: a row every 0.001 s, and the actuator records one every 0.0005 s; set the actuator's step_s and"
        " record_every_steps to this recording, or resample it",
        message);
    scale(EMA_COLUMN_TIME, 1000.0);
    assert_fit(EMA_CSV_PERIOD, "rec: time_s: a row every 1 s, and the actuator records one every 0.001 s: looks like "
                               "milliseconds; divide the column by 1000");
    scale(EMA_COLUMN_TIME, 1.0005e-3);
    TEST_ASSERT_EQUAL_INT(EMA_CSV_OK, fit(TRAVEL_MM));
    scale(EMA_COLUMN_TIME, 1.002);
    TEST_ASSERT_EQUAL_INT(EMA_CSV_PERIOD, fit(TRAVEL_MM));
}

static void assert_table(ema_csv_status_t status, int64_t rows, int32_t mask, const char* text)
{
    double period_s = 0.0;
    message[0] = '\0';
    TEST_ASSERT_EQUAL_INT(
        status, ema_csv_table_check("rec", &table[0][0], rows, mask, &period_s, message, (int32_t)sizeof message));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(message, text), message);
}

static void test_tables_from_elsewhere(void)
{
    assert_table(EMA_CSV_OK, ROWS, MASK, "");
    assert_table(EMA_CSV_HEADER, ROWS, 5, "rec: command_mm: the recording has no such column; give it this name");
    assert_table(EMA_CSV_NUMBER, ROWS, MASK | (1 << EMA_COLUMN_CURRENT), "rec: row 1, current_A: not a finite number");
    assert_table(EMA_CSV_EMPTY, 0, MASK, "rec: there are no rows of samples");
    assert_table(EMA_CSV_SHORT, 99, MASK, "rec: row 99: the recording ends after 99 samples and needs at least 100");
    table[200][EMA_COLUMN_POSITION] = (double)INFINITY;
    assert_table(EMA_CSV_NUMBER, ROWS, MASK,
                 "rec: row 201, position_mm: not a finite number; fill in the measured value or record again");
    setUp();
    table[300][EMA_COLUMN_TIME] += 0.5e-3;
    assert_table(EMA_CSV_TIME, ROWS, MASK,
                 "rec: row 301, time_s: a step of 0.0015 s where the first rows have 0.001 s");
}

static void test_wrong_calls_and_small_messages(void)
{
    double period_s = 0.0;
    TEST_ASSERT_EQUAL_INT(EMA_CSV_USAGE, ema_csv_table_check(NULL, &table[0][0], ROWS, MASK, &period_s, message,
                                                             (int32_t)sizeof message));
    TEST_ASSERT_EQUAL_INT(EMA_CSV_USAGE,
                          ema_csv_table_check("rec", NULL, ROWS, MASK, &period_s, message, (int32_t)sizeof message));
    TEST_ASSERT_EQUAL_INT(
        EMA_CSV_USAGE, ema_csv_table_check("rec", &table[0][0], -1, MASK, &period_s, message, (int32_t)sizeof message));
    TEST_ASSERT_EQUAL_INT(EMA_CSV_USAGE, ema_csv_table_check("rec", &table[0][0], ROWS, MASK, NULL, NULL, 0));
    TEST_ASSERT_EQUAL_INT(EMA_CSV_USAGE, ema_csv_table_fit("rec", NULL, ROWS, 1.0, 1.0, NULL, 0));
    (void)memset(message, '!', sizeof message);
    TEST_ASSERT_EQUAL_INT(EMA_CSV_HEADER, ema_csv_table_check("rec", &table[0][0], ROWS, 0, &period_s, message, 8));
    TEST_ASSERT_EQUAL_STRING("rec: ", message);
    TEST_ASSERT_EQUAL_CHAR('!', message[8]);
    TEST_ASSERT_EQUAL_INT(EMA_CSV_HEADER, ema_csv_table_check("rec", &table[0][0], ROWS, 0, &period_s, NULL, 8));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_good_recording_fits);
    RUN_TEST(test_metres);
    RUN_TEST(test_metres_of_the_whole_stroke);
    RUN_TEST(test_micrometres);
    RUN_TEST(test_beyond_every_unit);
    RUN_TEST(test_a_rod_that_does_not_follow_is_no_input_error);
    RUN_TEST(test_a_command_that_rests);
    RUN_TEST(test_a_position_with_an_offset);
    RUN_TEST(test_periods);
    RUN_TEST(test_tables_from_elsewhere);
    RUN_TEST(test_wrong_calls_and_small_messages);
    return UNITY_END();
}
