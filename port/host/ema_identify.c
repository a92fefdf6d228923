/* ema_identify: feeds a recorded CSV to the onboard module as the actuator's electronics would feed their samples, and
 * prints the result. */
#define _POSIX_C_SOURCE 200809L

#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "ema/ema.h"
#include "ema_config.h"
#include "ema_csv.h"
#include "ema_options.h"
#include "ema_report.h"

/* Rows that fit: the record has a fixed size, as on a target. */
#ifndef EMA_IDENTIFY_ROWS
#define EMA_IDENTIFY_ROWS 120000
#endif

/* Command and rod position. */
#define VALUES_PER_ROW 2

/* 16-bit integers span a little more than the travel: a position may pass its end by play and noise. */
#define FULL_SCALE EMA_R(1.05)

#define EXIT_BAD_INPUT 1
#define EXIT_BAD_USAGE 2

#define MESSAGE_SIZE EMA_CSV_MESSAGE
#define TRAVEL_DIGITS 4

/* All memory of the program: what firmware would place itself. */
typedef struct {
    ema_options_cli_t options;
    ema_actuator_t actuator;
    ema_session_config_t config;
    ema_session_t session;
    ema_csv_t csv;
    ema_report_t report;
    ema_real buffer[EMA_IDENTIFY_ROWS * VALUES_PER_ROW];
    char message[MESSAGE_SIZE];
} ema_program_t;

static double ema_now_s(void)
{
    struct timespec now = {0};
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + (1.0e-9 * (double)now.tv_nsec);
}

/* "name: text" as the program's message. */
static bool ema_refuse(ema_program_t* program, const char* name, const char* text, const char* advice)
{
    ema_text_t why = ema_text_start(program->message, sizeof program->message);
    ema_text_add_path(&why, name);
    ema_text_add(&why, ": ");
    ema_text_add(&why, text);
    ema_text_add(&why, advice);
    return false;
}

static const char* ema_actuator_name(const ema_program_t* program)
{
    return (program->options.config != NULL) ? program->options.config : "reference actuator";
}

/* Prepares an empty session for the healthy actuator. */
static bool ema_prepare(ema_program_t* program)
{
    const ema_options_cli_t* const options = &program->options;
    if (options->config != NULL) {
        if (!ema_config_read(&program->actuator, options->config, program->message, sizeof program->message)) {
            return false;
        }
    } else {
        (void)ema_actuator_defaults(&program->actuator);
    }
    const ema_real full_scale_mm = (options->full_scale_mm > 0.0) ? (ema_real)options->full_scale_mm
                                                                  : (FULL_SCALE * program->actuator.params.travel_mm);
    ema_record_config_t record = {.buffer = program->buffer, .command_full_scale_mm = full_scale_mm};
    record.full_scale[EMA_CHANNEL_POSITION] = full_scale_mm;
    record.format = options->int16 ? EMA_RECORD_INT16 : EMA_RECORD_REAL;
    record.buffer_bytes = options->int16 ? EMA_RECORD_INT16_BYTES(EMA_IDENTIFY_ROWS, VALUES_PER_ROW)
                                         : EMA_RECORD_REAL_BYTES(EMA_IDENTIFY_ROWS, VALUES_PER_ROW);
    (void)ema_session_config_default(&program->config, &program->actuator, &record);
    (void)ema_session_config_day(&program->config);
    if (options->seed_given) {
        program->config.annealer.seed = options->seed;
    }
    ema_model_t model;
    ema_status_t status = ema_model_init(&model, &program->actuator, EMA_R(0.0));
    if (status != EMA_OK) {
        /* Single values are in range by now; only the sum of the delays can still be outside. */
        return ema_refuse(
            program, ema_actuator_name(program), ema_status_text(status),
            (status == EMA_ERR_RANGE)
                ? "; keep encoder.delay_s and effects.feedback_delay.delay_s together within 12 model steps"
                : "; correct the actuator");
    }
    status = ema_session_init(&program->session, &program->config);
    if (status != EMA_OK) {
        return ema_refuse(program, ema_actuator_name(program), ema_status_text(status),
                          "; let the bounds of [search] hold the healthy screw.csj_Nm and screw.blk_mm, neither of "
                          "them zero, and correct its other settings");
    }
    return true;
}

static bool ema_refuse_sample(ema_program_t* program, ema_status_t status)
{
    ema_text_t why = ema_text_start(program->message, sizeof program->message);
    ema_text_add_path(&why, program->options.record);
    ema_text_add(&why, ": ");
    ema_csv_rows_where(&why, program->csv.line, NULL);
    if (status == EMA_ERR_FULL) {
        ema_text_add(&why, "the recording goes on, and this program has room for ");
        ema_text_add_whole(&why, EMA_IDENTIFY_ROWS);
        ema_text_add(&why, " samples; shorten it, or build with a larger EMA_IDENTIFY_ROWS");
    } else if ((status == EMA_ERR_SCALE) && (program->options.full_scale_mm > 0.0)) {
        ema_text_add(&why, "command_mm or position_mm lies outside --full-scale ");
        ema_text_add_real(&why, program->options.full_scale_mm, TRAVEL_DIGITS);
        ema_text_add(&why, "; correct the unit of the column, or give the scale that the firmware states");
    } else if (status == EMA_ERR_SCALE) {
        ema_text_add(&why, "command_mm or position_mm lies outside the actuator's travel of plus and minus ");
        ema_text_add_real(&why, (double)program->actuator.params.travel_mm, TRAVEL_DIGITS);
        ema_text_add(&why, " mm; correct the unit of the column, or the actuator's travel_mm");
    } else {
        ema_text_add(&why, ema_status_text(status));
        ema_text_add(&why, "; correct the sample");
    }
    return false;
}

/* Feeds the recording row by row. */
static bool ema_feed(ema_program_t* program)
{
    const ema_actuator_t* const actuator = &program->actuator;
    ema_csv_t* const csv = &program->csv;
    double row[EMA_COLUMN_COUNT];
    ema_csv_status_t status = ema_csv_open(csv, program->options.record);
    if (status == EMA_CSV_OK) {
        status = ema_csv_next(csv, row);
    }
    while (status == EMA_CSV_OK) {
        ema_sample_t sample = {.command_mm = (ema_real)row[EMA_COLUMN_COMMAND]};
        sample.channel[EMA_CHANNEL_POSITION] = (ema_real)row[EMA_COLUMN_POSITION];
        const ema_status_t taken = ema_session_feed(&program->session, &sample);
        if (taken != EMA_OK) {
            return ema_refuse_sample(program, taken);
        }
        status = ema_csv_next(csv, row);
    }
    if (status == EMA_CSV_END) {
        const double period_s = (double)actuator->params.step_s * (double)actuator->options.record_every_steps;
        status = ema_csv_fit(csv, (double)actuator->params.travel_mm, period_s);
    }
    if (status != EMA_CSV_OK) {
        ema_text_t why = ema_text_start(program->message, sizeof program->message);
        ema_text_add(&why, csv->message);
        return false;
    }
    program->report.rows = csv->rows.count;
    program->report.period_s = ema_csv_rows_period_s(&csv->rows);
    return true;
}

/* Runs the session in slices to its end. */
static bool ema_search(ema_program_t* program)
{
    const double start_s = ema_now_s();
    ema_status_t status = EMA_OK;
    while ((status == EMA_OK) && (ema_session_phase(&program->session) != EMA_PHASE_DONE)) {
        status = ema_session_run(&program->session, program->options.slice_steps);
    }
    if (status == EMA_OK) {
        status = ema_session_result(&program->session, &program->report.result);
    }
    if (status != EMA_OK) {
        return ema_refuse(program, program->options.record, ema_status_text(status),
                          "; check that recording and actuator belong together");
    }
    program->report.search_s = ema_now_s() - start_s;
    return true;
}

/* Writes the JSON file. It comes into being here, so that nothing that appeared in the meantime is overwritten either.
 */
static bool ema_write_json(ema_program_t* program)
{
    const char* const path = program->options.json;
    FILE* const file = fopen(path, program->options.force ? "w" : "wx");
    if (file == NULL) {
        return ema_refuse(program, path, "the file cannot be written", "; check its folder and permissions");
    }
    ema_report_json(&program->report, file);
    const bool written = ferror(file) == 0;
    if ((fclose(file) != 0) || !written) {
        return ema_refuse(program, path, "the file could not be written to its end",
                          "; check that there is room on the disk");
    }
    return true;
}

static bool ema_run(ema_program_t* program, double start_s)
{
    bool good = ema_prepare(program) && ema_feed(program);
    ema_csv_close(&program->csv);
    good = good && ema_search(program);
    if (good) {
        ema_report_t* const report = &program->report;
        report->record = program->options.record;
        report->config = &program->config;
        report->int16 = program->options.int16;
        report->wall_s = ema_now_s() - start_s;
        ema_report_text(report, stdout);
        good = (program->options.json == NULL) || ema_write_json(program);
    }
    if (good && (fflush(stdout) != 0)) {
        good = ema_refuse(program, "standard output", "the result could not be written", "; check where it is sent");
    }
    return good;
}

/* Whether two paths lead to one file that exists. */
static bool ema_same_file(const char* first, const char* second)
{
    struct stat a;
    struct stat b;
    return (stat(first, &a) == 0) && (stat(second, &b) == 0) && (a.st_dev == b.st_dev) && (a.st_ino == b.st_ino);
}

/* Whether the result would overwrite the recording or the actuator. */
static bool ema_reads_json(const ema_options_cli_t* options)
{
    return (options->json != NULL)
           && (ema_same_file(options->json, options->record)
               || ((options->config != NULL) && ema_same_file(options->json, options->config)));
}

int main(int argc, char* argv[])
{
    static ema_program_t program;
    const double start_s = ema_now_s();
    if (!ema_options_read(&program.options, argc, argv, program.message, sizeof program.message)) {
        (void)fprintf(stderr, "%s\n", program.message);
        return EXIT_BAD_USAGE;
    }
    if (program.options.help) {
        (void)fputs(ema_usage_text, stdout);
        return EXIT_SUCCESS;
    }
    if (ema_reads_json(&program.options)) {
        (void)ema_refuse(&program, program.options.json, "--json names a file that is read",
                         "; give the result another name");
        (void)fprintf(stderr, "%s\n", program.message);
        return EXIT_BAD_USAGE;
    }
    if ((program.options.json != NULL) && !program.options.force && (access(program.options.json, F_OK) == 0)) {
        (void)ema_refuse(&program, program.options.json, "the file exists and is not overwritten",
                         "; name another one or give --force");
        (void)fprintf(stderr, "%s\n", program.message);
        return EXIT_BAD_USAGE;
    }
    if (!ema_run(&program, start_s)) {
        (void)fprintf(stderr, "%s\n", program.message);
        return EXIT_BAD_INPUT;
    }
    return EXIT_SUCCESS;
}
