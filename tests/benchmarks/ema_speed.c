/* How long the model and an identification take on this machine. Prints a table; every ratio is measured within one
 * run.
 *
 * Usage: ema_speed [REPEATS]. The reference chirp: 2 mm, 0.1 to 4 Hz, 10 s, control at 1 kHz. The paper's figure is 27
 * to 30 ms per model run (75 s for 2535 runs).
 */
#define _POSIX_C_SOURCE 199309L

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "ema/ema.h"

#define ROWS 10000U
#define PAPER_MS 28.5

static ema_real buffer[2U * ROWS];

static double seconds(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + (1.0e-9 * (double)now.tv_nsec);
}

static ema_status_t make_record(ema_record_t* record, const ema_actuator_t* actuator)
{
    ema_command_t command;
    ema_model_t model;
    const ema_command_config_t chirp = {.kind = EMA_COMMAND_CHIRP,
                                        .amplitude_mm = EMA_R(2.0),
                                        .start_hz = EMA_R(0.1),
                                        .end_hz = EMA_R(4.0),
                                        .duration_s = EMA_R(10.0)};
    const ema_record_config_t config = {.buffer = buffer, .buffer_bytes = sizeof buffer, .format = EMA_RECORD_REAL};
    ema_status_t status = ema_command_init(&command, &chirp, actuator->params.step_s);
    if (status == EMA_OK) {
        status = ema_model_init(&model, actuator, EMA_R(0.0));
    }
    if (status == EMA_OK) {
        status = ema_record_init(record, &config);
    }
    for (uint32_t row = 0; (status == EMA_OK) && (row < ROWS); ++row) {
        ema_output_t output;
        ema_sample_t sample = {0};
        sample.command_mm = ema_command_at(&command, row);
        status = ema_model_step(&model, sample.command_mm, &output);
        sample.channel[EMA_CHANNEL_POSITION] = output.position_mm;
        if (status == EMA_OK) {
            status = ema_record_append(record, &sample);
        }
    }
    return status;
}

/* The fastest of `repeats` evaluations, in ms: what the processor needs when nothing else disturbs it. */
static double evaluation_ms(const ema_actuator_t* actuator, const ema_record_t* record, int repeats)
{
    const ema_real weight[EMA_CHANNEL_COUNT] = {EMA_R(1.0)};
    static ema_objective_t run;
    double best = 1.0e9;
    for (int k = 0; k < repeats; ++k) {
        const double start = seconds();
        if (ema_objective_start(&run, actuator, record, weight, EMA_R(0.0), EMA_COST_MAX) != EMA_OK) {
            return -1.0;
        }
        (void)ema_objective_run(&run, ROWS);
        const double ms = 1.0e3 * (seconds() - start);
        best = (ms < best) ? ms : best;
    }
    return best;
}

static double identify_ms(const ema_actuator_t* healthy, ema_record_config_t record, uint32_t rows, bool abandon,
                          ema_result_t* result)
{
    static ema_session_t session;
    static ema_real copy[2U * ROWS];
    ema_session_config_t config;
    record.buffer = copy;
    (void)ema_session_config_default(&config, healthy, &record);
    config.abandon = abandon;
    const double start = seconds();
    (void)ema_session_init(&session, &config);
    for (uint32_t row = 0; row < rows; ++row) {
        ema_sample_t sample = {0};
        sample.command_mm = buffer[2U * row];
        sample.channel[EMA_CHANNEL_POSITION] = buffer[(2U * row) + 1U];
        (void)ema_session_feed(&session, &sample);
    }
    while (ema_session_phase(&session) != EMA_PHASE_DONE) {
        if (ema_session_run(&session, 1000U) != EMA_OK) {
            return -1.0;
        }
    }
    (void)ema_session_result(&session, result);
    return 1.0e3 * (seconds() - start);
}

int main(int argc, char** argv)
{
    const int repeats = (argc > 1) ? atoi(argv[1]) : 50;
    ema_actuator_t healthy;
    ema_record_t record;
    (void)ema_actuator_defaults(&healthy);
    if ((repeats < 1) || (make_record(&record, &healthy) != EMA_OK)) {
        (void)fprintf(stderr, "ema_speed: give a number of repeats of at least 1\n");
        return 1;
    }
    const double plain = evaluation_ms(&healthy, &record, repeats);
    (void)printf("float%u, %u steps of 1 ms, fastest of %d\n", (unsigned)(8U * sizeof(ema_real)), ROWS, repeats);
    (void)printf("%-34s %10.1f ns per step %10.3f ms per model run %8.0f x the paper's\n", "model, no effects",
                 plain * 1.0e6 / ROWS, plain, PAPER_MS / plain);

    /* the same actuator with every shape parameter set and every size at zero */
    ema_actuator_t zero = healthy;
    zero.effects.stribeck_friction.speed_rad_s = EMA_R(3.0);
    zero.effects.cogging_torque.periods = EMA_R(24.0);
    const double absent = evaluation_ms(&zero, &record, repeats);
    (void)printf("%-34s %10.1f ns per step %10.3f ms per model run %8.3f x no effects\n", "all effects at zero",
                 absent * 1.0e6 / ROWS, absent, absent / plain);

    static const struct {
        const char* name;
        ema_value_id_t id;
    } sizes[] = {
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters)                            \
    {#name, (ema_value_id_t)(EMA_PARAM_COUNT + (offsetof(ema_effects_t, name) / sizeof(ema_real)))},
#include "ema/ema_effects.def"
    };
    for (size_t k = 0; k < (sizeof sizes / sizeof sizes[0]); ++k) {
        ema_actuator_t with = healthy;
        (void)ema_actuator_set(&with, sizes[k].id, EMA_R(0.01) * ema_actuator_range(sizes[k].id)->upper);
        const double ms = evaluation_ms(&with, &record, (repeats / 5) + 1);
        (void)printf("  with %-29s %9.1f ns per step %10.3f ms per model run %8.2f x no effects\n", sizes[k].name,
                     ms * 1.0e6 / ROWS, ms, ms / plain);
    }

    ema_actuator_t worn = healthy;
    worn.params.csj_Nm = EMA_R(0.3);
    worn.params.blk_mm = EMA_R(0.04125);
    (void)make_record(&record, &worn);
    const ema_record_config_t config = {.buffer_bytes = sizeof buffer, .format = EMA_RECORD_REAL};
    ema_result_t result;
    const double with_abandon = identify_ms(&healthy, config, ROWS, true, &result);
    const uint32_t evaluations = result.evaluations;
    const double without = identify_ms(&healthy, config, ROWS, false, &result);
    (void)printf("case A identified: %.1f ms, %u model runs, CSJ %.6f Nm, BLK %.6f mm; giving runs up early saves %.0f "
                 "%%; the paper's 75 s are %.0f x longer\n",
                 with_abandon, evaluations, (double)result.identified[0].estimate,
                 (double)result.identified[1].estimate, 100.0 * (1.0 - (with_abandon / without)),
                 75000.0 / with_abandon);
    return 0;
}
