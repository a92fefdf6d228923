#include "ema_csv_rows.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* A step may differ from the first rows' median by this share. */
#define STEP_TOLERANCE 0.01

/* The mean period may differ from the actuator's by this share: crystals do by a tenth of it. */
#define PERIOD_TOLERANCE 1.0e-3

/* No ground test of an actuator moves less, and no metres fit into a thousandth of the stroke. */
#define TRAVEL_MIN_MM 0.02
#define STROKE_SHARE_MIN 1.0e-3

/* A measured position may pass the end of travel by this share of it: play, noise, an elastic stop. */
#define TRAVEL_MARGIN 0.02

/* Position and command that belong together but differ by more than this factor are in two units. */
#define UNIT_FACTOR 100.0
#define UNIT_CORRELATION 0.7

/* Digits in messages: instants whole, the rest as far as it says something. */
#define TIME_DIGITS 15
#define STEP_DIGITS 6
#define TRAVEL_DIGITS 4

static const char* const ema_names[EMA_COLUMN_COUNT] = {"time_s",    "command_mm", "position_mm", "motor_position_mm",
                                                        "current_A", "voltage_V",  "speed_mm_s"};

const char* ema_column_name(ema_column_t column)
{
    return ema_names[column];
}

void ema_csv_rows_start(ema_csv_rows_t* rows)
{
    (void)memset(rows, 0, sizeof *rows);
}

void ema_csv_rows_where(ema_text_t* why, int64_t row, const char* column)
{
    ema_text_add(why, "row ");
    ema_text_add_whole(why, row);
    if (column != NULL) {
        ema_text_add(why, ", ");
        ema_text_add(why, column);
    }
    ema_text_add(why, ": ");
}

static int ema_compare_steps(const void* left, const void* right)
{
    const double a = *(const double*)left;
    const double b = *(const double*)right;
    return (a > b) - (a < b);
}

static double ema_early_median_s(const ema_csv_rows_t* rows)
{
    double step_s[EMA_CSV_ROWS_MIN - 1];
    for (int i = 0; i < (EMA_CSV_ROWS_MIN - 1); ++i) {
        step_s[i] = rows->early_time_s[i + 1] - rows->early_time_s[i];
    }
    qsort(step_s, EMA_CSV_ROWS_MIN - 1, sizeof step_s[0], ema_compare_steps);
    return step_s[(EMA_CSV_ROWS_MIN - 1) / 2];
}

static ema_csv_status_t ema_check_step(const ema_csv_rows_t* rows, int64_t row, double step_s, ema_text_t* why)
{
    const double median_s = rows->median_step_s;
    if (fabs(step_s - median_s) <= (STEP_TOLERANCE * median_s)) {
        return EMA_CSV_OK;
    }
    ema_csv_rows_where(why, row, ema_names[EMA_COLUMN_TIME]);
    ema_text_add(why, "a step of ");
    ema_text_add_real(why, step_s, STEP_DIGITS);
    ema_text_add(why, " s where the first rows have ");
    ema_text_add_real(why, median_s, STEP_DIGITS);
    const double missing = floor((step_s / median_s) + 0.5) - 1.0;
    if ((missing >= 1.0) && (missing < 1.0e9)
        && (fabs(step_s - ((missing + 1.0) * median_s)) <= (STEP_TOLERANCE * median_s))) {
        ema_text_add(why, " s, rows missing before it: ");
        ema_text_add_whole(why, (int64_t)missing);
        ema_text_add(why, "; record again without gaps");
    } else {
        ema_text_add(why, " s; record at a constant rate, or write time_s with more digits if it was rounded");
    }
    return EMA_CSV_TIME;
}

static void ema_follow_travel(ema_csv_rows_t* rows, const double value[EMA_COLUMN_COUNT])
{
    double from_first_mm[2];
    for (int i = 0; i < 2; ++i) {
        const double mm = value[EMA_COLUMN_COMMAND + i];
        if (rows->count == 0) {
            rows->first_mm[i] = mm;
            rows->lowest_mm[i] = mm;
            rows->highest_mm[i] = mm;
        }
        rows->lowest_mm[i] = (mm < rows->lowest_mm[i]) ? mm : rows->lowest_mm[i];
        rows->highest_mm[i] = (mm > rows->highest_mm[i]) ? mm : rows->highest_mm[i];
        from_first_mm[i] = mm - rows->first_mm[i];
        rows->sum_mm[i] += from_first_mm[i];
        rows->square_mm2[i] += from_first_mm[i] * from_first_mm[i];
    }
    rows->product_mm2 += from_first_mm[0] * from_first_mm[1];
}

ema_csv_status_t ema_csv_rows_add(ema_csv_rows_t* rows, int64_t row, const double value[EMA_COLUMN_COUNT],
                                  ema_text_t* why)
{
    const double time_s = value[EMA_COLUMN_TIME];
    const double step_s = time_s - rows->last_time_s;
    ema_csv_status_t status = EMA_CSV_OK;
    if ((rows->count > 0) && !(step_s > 0.0)) {
        ema_csv_rows_where(why, row, ema_names[EMA_COLUMN_TIME]);
        ema_text_add_real(why, time_s, TIME_DIGITS);
        ema_text_add(why, " s does not come after ");
        ema_text_add_real(why, rows->last_time_s, TIME_DIGITS);
        ema_text_add(
            why, " s; sort the rows by time and remove doubles, or write time_s with more digits if it was rounded");
        return EMA_CSV_TIME;
    }
    ema_follow_travel(rows, value);
    if (rows->count < EMA_CSV_ROWS_MIN) {
        rows->early_time_s[rows->count] = time_s;
        rows->early_row[rows->count] = row;
    } else {
        status = ema_check_step(rows, row, step_s, why);
    }
    if (rows->count == 0) {
        rows->first_time_s = time_s;
    }
    rows->last_time_s = time_s;
    rows->last_row = row;
    ++rows->count;
    if (rows->count == EMA_CSV_ROWS_MIN) {
        rows->median_step_s = ema_early_median_s(rows);
        for (int i = 1; (i < EMA_CSV_ROWS_MIN) && (status == EMA_CSV_OK); ++i) {
            status = ema_check_step(rows, rows->early_row[i], rows->early_time_s[i] - rows->early_time_s[i - 1], why);
        }
    }
    return status;
}

ema_csv_status_t ema_csv_rows_end(const ema_csv_rows_t* rows, ema_text_t* why)
{
    ema_csv_status_t status = EMA_CSV_OK;
    if (rows->count == 0) {
        ema_text_add(why, "there are no rows of samples; record or export it again");
        status = EMA_CSV_EMPTY;
    } else if (rows->count < EMA_CSV_ROWS_MIN) {
        ema_csv_rows_where(why, rows->last_row, NULL);
        ema_text_add(why, "the recording ends after ");
        ema_text_add_whole(why, rows->count);
        ema_text_add(why, " samples and needs at least ");
        ema_text_add_whole(why, EMA_CSV_ROWS_MIN);
        ema_text_add(why, "; record for longer");
        status = EMA_CSV_SHORT;
    }
    return status;
}

double ema_csv_rows_period_s(const ema_csv_rows_t* rows)
{
    return (rows->count > 1) ? ((rows->last_time_s - rows->first_time_s) / (double)(rows->count - 1)) : 0.0;
}

/* Correlation of command and position, 0 when one of them rests. */
static double ema_correlation(const ema_csv_rows_t* rows)
{
    const double n = (double)rows->count;
    const double command = rows->square_mm2[0] - (rows->sum_mm[0] * rows->sum_mm[0] / n);
    const double position = rows->square_mm2[1] - (rows->sum_mm[1] * rows->sum_mm[1] / n);
    const double both = rows->product_mm2 - (rows->sum_mm[0] * rows->sum_mm[1] / n);
    return ((command > 0.0) && (position > 0.0)) ? (both / sqrt(command * position)) : 0.0;
}

static ema_csv_status_t ema_unit_error(ema_text_t* why, ema_column_t column, double travel_mm, const char* against,
                                       double reference_mm, const char* advice)
{
    ema_text_add(why, ema_names[column]);
    ema_text_add(why, ": travels ");
    ema_text_add_real(why, travel_mm, TRAVEL_DIGITS);
    ema_text_add(why, against);
    ema_text_add_real(why, reference_mm, TRAVEL_DIGITS);
    ema_text_add(why, advice);
    return EMA_CSV_UNIT;
}

static const char* const ema_metres = " mm: looks like metres; multiply the column by 1000";
static const char* const ema_micrometres = " mm: looks like micrometres; divide the column by 1000";

static ema_csv_status_t ema_units_fit(const ema_csv_rows_t* rows, double travel_mm, ema_text_t* why)
{
    const double stroke_mm = 2.0 * travel_mm;
    const double least_mm = fmax(TRAVEL_MIN_MM, STROKE_SHARE_MIN * stroke_mm);
    const double command_mm = rows->highest_mm[0] - rows->lowest_mm[0];
    const double position_mm = rows->highest_mm[1] - rows->lowest_mm[1];
    const bool together = ema_correlation(rows) > UNIT_CORRELATION;
    if (!(command_mm > 0.0)) {
        ema_text_add(why, ema_names[EMA_COLUMN_COMMAND]);
        ema_text_add(why, ": the command never changes; record a command that moves the rod");
        return EMA_CSV_UNIT;
    }
    if (command_mm < least_mm) {
        return ema_unit_error(why, EMA_COLUMN_COMMAND, command_mm, " mm where at least ", least_mm,
                              " mm are expected of this actuator: looks like metres; multiply the column by 1000");
    }
    if (command_mm > stroke_mm) {
        return ema_unit_error(why, EMA_COLUMN_COMMAND, command_mm, " mm and the actuator's stroke is ", stroke_mm,
                              ((command_mm / 1000.0) <= stroke_mm)
                                  ? ema_micrometres
                                  : " mm; correct the unit of the column, or the actuator's travel_mm");
    }
    if (together && (position_mm * UNIT_FACTOR < command_mm)) {
        return ema_unit_error(why, EMA_COLUMN_POSITION, position_mm, " mm along with a command over ", command_mm,
                              ema_metres);
    }
    if (position_mm > (stroke_mm * (1.0 + TRAVEL_MARGIN))) {
        return ema_unit_error(why, EMA_COLUMN_POSITION, position_mm, " mm and the actuator's stroke is ", stroke_mm,
                              ((position_mm / 1000.0) <= stroke_mm)
                                  ? ema_micrometres
                                  : " mm; correct the unit of the column, or the actuator's travel_mm");
    }
    if (together && (position_mm > (UNIT_FACTOR * command_mm))) {
        return ema_unit_error(why, EMA_COLUMN_POSITION, position_mm, " mm along with a command over ", command_mm,
                              ema_micrometres);
    }
    const double reach_mm = fmax(rows->highest_mm[1], -rows->lowest_mm[1]);
    if (reach_mm > (travel_mm * (1.0 + TRAVEL_MARGIN))) {
        ema_text_add(why, ema_names[EMA_COLUMN_POSITION]);
        ema_text_add(why, ": reaches ");
        ema_text_add_real(why, reach_mm, TRAVEL_DIGITS);
        ema_text_add(why, " mm from the middle and the actuator's travel ends at ");
        ema_text_add_real(why, travel_mm, TRAVEL_DIGITS);
        ema_text_add(why, " mm; take the sensor's offset off command and position, or correct travel_mm");
        return EMA_CSV_UNIT;
    }
    return EMA_CSV_OK;
}

ema_csv_status_t ema_csv_rows_fit(const ema_csv_rows_t* rows, double travel_mm, double record_period_s, ema_text_t* why)
{
    const double period_s = ema_csv_rows_period_s(rows);
    if (fabs(period_s - record_period_s) > (PERIOD_TOLERANCE * record_period_s)) {
        const bool milliseconds =
            fabs(period_s - (1000.0 * record_period_s)) <= (STEP_TOLERANCE * 1000.0 * record_period_s);
        ema_text_add(why, ema_names[EMA_COLUMN_TIME]);
        ema_text_add(why, ": a row every ");
        ema_text_add_real(why, period_s, STEP_DIGITS);
        ema_text_add(why, " s, and the actuator records one every ");
        ema_text_add_real(why, record_period_s, STEP_DIGITS);
        ema_text_add(why,
                     milliseconds
                         ? " s: looks like milliseconds; divide the column by 1000"
                         : " s; set the actuator's step_s and record_every_steps to this recording, or resample it");
        return EMA_CSV_PERIOD;
    }
    return ema_units_fit(rows, travel_mm, why);
}
