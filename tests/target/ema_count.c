/* Counts instructions on the emulated target: run it with -icount shift=6, where one instruction is 64 ns and a tick of
 * the counter 40 ns.
 *
 * Prints `name value` lines: instructions of the calls, the stack that they used, and the sizes of the public
 * structures.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ace_actuator.h"
#include "ace_signatures.h"
#include "ema/ema.h"
#include "ema_counter.h"
#include "ema_recorded.h"

/* 25 ticks are 1000 ns, 1000 / 64 instructions. */
#define TICKS 8U
#define INSTRUCTIONS 5U
#define STEPS EMA_RECORDED_ROWS
#define CHUNK_STEPS 1000U

static ema_recorded_t recorded;
static ema_model_t model;
/* ticks between two readings with nothing in between */
static uint32_t reading;

/* Least, sum and most of a call's ticks. */
typedef struct {
    uint64_t sum;
    uint32_t most;
    uint32_t calls;
} ticks_t;

static void take(ticks_t* ticks, uint32_t from, uint32_t to)
{
    const uint32_t spent = to - from;
    const uint32_t net = (spent > reading) ? (spent - reading) : 0U;
    ticks->sum += net;
    ticks->most = (net > ticks->most) ? net : ticks->most;
    ++ticks->calls;
}

static unsigned long long instructions(uint64_t ticks)
{
    return (unsigned long long)(((ticks * INSTRUCTIONS) + (TICKS - 1U)) / TICKS);
}

static void print_mean(const char* name, const ticks_t* ticks)
{
    (void)printf("%s_mean %.1f\n%s_most %llu\n", name,
                 ((double)ticks->sum * (double)INSTRUCTIONS) / ((double)TICKS * (double)ticks->calls), name,
                 instructions(ticks->most));
}

static void calibrate(void)
{
    uint32_t least = UINT32_MAX;
    for (uint32_t k = 0; k < 100U; ++k) {
        const uint32_t from = ema_counter_now();
        const uint32_t spent = ema_counter_now() - from;
        least = (spent < least) ? spent : least;
    }
    reading = least;
}

static void fail(const char* what, ema_status_t status)
{
    (void)printf("failed %s: %s\n", what, ema_status_text(status));
    exit(1);
}

/* The model alone, as an observer beside the machine would run it: over the chirp of case A. */
static void count_model(const char* name, const ema_actuator_t* actuator)
{
    ticks_t step = {0};
    char label[80];
    ema_sample_t sample;
    ema_status_t status = ema_model_init(&model, actuator, EMA_R(0.0));
    for (uint32_t row = 0; (status == EMA_OK) && ema_recorded_row('a', row, &sample); ++row) {
        const uint32_t from = ema_counter_now();
        status = ema_model_step(&model, sample.command_mm, NULL);
        take(&step, from, ema_counter_now());
    }
    if (status != EMA_OK) {
        fail(name, status);
    }
    (void)snprintf(label, sizeof label, "model_step_%s", name);
    print_mean(label, &step);
}

typedef struct {
    const char* effect;
    ema_value_id_t id;
    ema_real value;
} costed_t;

static const costed_t costed[] = {
#define EMA_COSTED(effect, field, value) {#effect, EMA_EFFECT_VALUE_ID(effect, field), value},
#include "ema_costed.def"
};

#define COSTED (sizeof costed / sizeof costed[0])

static void count_effects(void)
{
    ema_actuator_t healthy;
    (void)ema_actuator_defaults(&healthy);
    count_model("healthy", &healthy);
    for (size_t k = 0; k < COSTED;) {
        const char* const name = costed[k].effect;
        ema_actuator_t actuator = healthy;
        for (; (k < COSTED) && (strcmp(costed[k].effect, name) == 0); ++k) {
            (void)ema_actuator_set(&actuator, costed[k].id, costed[k].value);
        }
        char label[64];
        (void)snprintf(label, sizeof label, "effect_%s", name);
        count_model(label, &actuator);
    }
}

/* A whole identification of case A. The sum is read every few slices, so that reading costs nothing; the most from
 * every slice. */
static void count_identification(uint32_t slice, ema_record_format_t format, const char* name)
{
    ema_result_t result;
    ema_status_t status = ema_recorded_start(&recorded, 'a', 1U, format, EMA_SEARCH_TWO_STAGES);
    uint64_t ticks = 0U;
    uint64_t slices = 0U;
    uint32_t from = ema_counter_now();
    while ((status == EMA_OK) && (ema_session_phase(&recorded.session) != EMA_PHASE_DONE)) {
        for (uint32_t made = 0; (status == EMA_OK) && (made < CHUNK_STEPS); made += slice) {
            status = ema_session_run(&recorded.session, slice);
            ++slices;
        }
        const uint32_t now = ema_counter_now();
        ticks += now - from;
        from = now;
    }
    if (status == EMA_OK) {
        status = ema_session_result(&recorded.session, &result);
    }
    if (status != EMA_OK) {
        fail(name, status);
    }
    (void)printf("identify_%s_%" PRIu32 " %llu\n", name, slice, instructions(ticks));
    (void)printf("identify_%s_%" PRIu32 "_slices %llu\n", name, slice, (unsigned long long)slices);
    (void)printf("identify_%s_%" PRIu32 "_steps %llu\n", name, slice, (unsigned long long)result.model_steps);
}

/* What the longest slice takes, over a whole identification. */
static void count_slices(uint32_t slice)
{
    ticks_t run = {0};
    ema_status_t status = ema_recorded_start(&recorded, 'a', 1U, EMA_RECORD_INT16, EMA_SEARCH_TWO_STAGES);
    while ((status == EMA_OK) && (ema_session_phase(&recorded.session) != EMA_PHASE_DONE)) {
        const uint32_t from = ema_counter_now();
        status = ema_session_run(&recorded.session, slice);
        take(&run, from, ema_counter_now());
    }
    if (status != EMA_OK) {
        fail("slices", status);
    }
    ema_result_t result;
    ticks_t once = {0};
    const uint32_t done = ema_counter_now();
    status = ema_session_result(&recorded.session, &result);
    take(&once, done, ema_counter_now());
    if ((status != EMA_OK) || (result.verdict != EMA_VERDICT_FAULT)) {
        fail("result", status);
    }
    char label[32];
    (void)snprintf(label, sizeof label, "slice_%" PRIu32, slice);
    print_mean(label, &run);
    if (slice > 200U) {
        print_mean("session_result_done", &once);
    }
}

static void count_selftest(void)
{
    static ema_selftest_t memory;
    ticks_t once = {0};
    const uint32_t from = ema_counter_now();
    const ema_selftest_outcome_t outcome = ema_selftest(&memory, EMA_SELFTEST_BUILD);
    take(&once, from, ema_counter_now());
    print_mean((outcome == EMA_SELFTEST_PASSED) ? "selftest" : "selftest_failed", &once);
}

/* The calls outside the search. */
static void count_calls(void)
{
    ticks_t feed = {0};
    ticks_t once = {0};
    ema_sample_t sample;
    ema_result_t result;
    ema_status_t status = ema_recorded_start(&recorded, 'a', 1U, EMA_RECORD_INT16, EMA_SEARCH_TWO_STAGES);
    uint32_t from = ema_counter_now();
    if (status == EMA_OK) {
        status = ema_session_init(&recorded.session, &recorded.config);
    }
    take(&once, from, ema_counter_now());
    print_mean("session_init", &once);
    for (uint32_t row = 0; (status == EMA_OK) && ema_recorded_row('a', row, &sample); ++row) {
        from = ema_counter_now();
        status = ema_session_feed(&recorded.session, &sample);
        take(&feed, from, ema_counter_now());
    }
    print_mean("session_feed", &feed);
    if (status == EMA_OK) {
        status = ema_session_run(&recorded.session, 1U);
    }
    const ticks_t none = {0};
    once = none;
    from = ema_counter_now();
    if (status == EMA_OK) {
        status = ema_session_result(&recorded.session, &result);
    }
    take(&once, from, ema_counter_now());
    print_mean("session_result", &once);
    if (status != EMA_OK) {
        fail("calls", status);
    }
}

/* Full scale of the current in a record. */
#define FULL_SCALE_A EMA_R(30.0)

static ema_guarded_t guarded;
static ema_onboard_t onboard;
static ema_command_t chirp;
static ema_session_config_t guarded_config;

/* Starts a session behind the table and feeds it case A with its current; the command is recorded too, or a function.
 * The buffer of the cases is used. */
static ema_status_t guarded_start(bool function, ticks_t* init, ticks_t* feed)
{
    static const ema_command_config_t command = {.kind = EMA_COMMAND_CHIRP,
                                                 .amplitude_mm = EMA_R(2.0),
                                                 .start_hz = EMA_R(0.1),
                                                 .end_hz = EMA_R(4.0),
                                                 .duration_s = EMA_R(10.0)};
    const ema_real full_scale_mm = EMA_ACTUATOR.params.travel_mm;
    ema_record_config_t record = {.buffer = &recorded.buffer,
                                  .buffer_bytes = sizeof recorded.buffer,
                                  .format = EMA_RECORD_INT16,
                                  .command_full_scale_mm = full_scale_mm};
    record.command = function ? &chirp : NULL;
    record.full_scale[EMA_CHANNEL_POSITION] = full_scale_mm;
    record.keep[EMA_CHANNEL_CURRENT] = true;
    record.full_scale[EMA_CHANNEL_CURRENT] = FULL_SCALE_A;
    ema_sample_t sample;
    ema_status_t status = ema_command_init(&chirp, &command, EMA_ACTUATOR.params.step_s);
    if (status == EMA_OK) {
        status = ema_session_config_default(&guarded_config, &EMA_ACTUATOR, &record);
    }
    if (status == EMA_OK) {
        const uint32_t from = ema_counter_now();
        status = ema_guarded_init(&guarded, &guarded_config, &EMA_SIGNATURES);
        take(init, from, ema_counter_now());
    }
    for (uint32_t row = 0; (status == EMA_OK) && ema_recorded_row('a', row, &sample); ++row) {
        const uint32_t from = ema_counter_now();
        status = ema_guarded_feed(&guarded, &sample);
        take(feed, from, ema_counter_now());
    }
    return status;
}

/* A whole identification of case A behind the table: every slice, and what it came to. */
static void count_guarded(uint32_t slice, bool function, const char* name)
{
    ticks_t init = {0};
    ticks_t feed = {0};
    ticks_t run = {0};
    ticks_t once = {0};
    ema_result_t result;
    ema_finding_t finding;
    ema_status_t status = guarded_start(function, &init, &feed);
    while ((status == EMA_OK) && (ema_guarded_phase(&guarded) != EMA_GUARDED_DONE)) {
        const uint32_t from = ema_counter_now();
        status = ema_guarded_run(&guarded, slice);
        take(&run, from, ema_counter_now());
    }
    if (status == EMA_OK) {
        const uint32_t from = ema_counter_now();
        status = ema_guarded_result(&guarded, &result, &finding);
        take(&once, from, ema_counter_now());
    }
    if (status != EMA_OK) {
        fail(name, status);
    }
    if ((result.verdict != EMA_VERDICT_FAULT) || (finding.kind != EMA_FINDING_ADEQUATE)) {
        /* another course through the code than the one that is to be counted */
        (void)printf("failed %s: verdict %d, finding %d\n", name, (int)result.verdict, (int)finding.kind);
        exit(1);
    }
    char label[48];
    (void)snprintf(label, sizeof label, "%s_slice_%" PRIu32, name, slice);
    print_mean(label, &run);
    if (slice > 1U) {
        (void)snprintf(label, sizeof label, "%s_init", name);
        print_mean(label, &init);
        (void)snprintf(label, sizeof label, "%s_feed", name);
        print_mean(label, &feed);
        (void)snprintf(label, sizeof label, "%s_result", name);
        print_mean(label, &once);
        (void)printf("%s_identify %llu\n%s_runs %" PRIu32 "\n", name, instructions(run.sum), name, result.evaluations);
        (void)printf("%s_steps %llu\n", name, (unsigned long long)result.model_steps);
    }
}

/* One run beside the table, without a session, on the record that is there. */
static void count_onboard(void)
{
    ticks_t start = {0};
    ticks_t run = {0};
    ticks_t once = {0};
    ema_finding_t finding;
    uint32_t from = ema_counter_now();
    ema_status_t status =
        ema_onboard_start(&onboard, &EMA_SIGNATURES, &EMA_ACTUATOR, &guarded.session.record, EMA_R(0.0));
    take(&start, from, ema_counter_now());
    while ((status == EMA_OK) && !ema_onboard_done(&onboard)) {
        from = ema_counter_now();
        (void)ema_onboard_run(&onboard, 200U);
        take(&run, from, ema_counter_now());
    }
    from = ema_counter_now();
    if (status == EMA_OK) {
        status = ema_onboard_result(&onboard, &finding);
    }
    take(&once, from, ema_counter_now());
    if (status != EMA_OK) {
        fail("onboard", status);
    }
    print_mean("onboard_start", &start);
    print_mean("onboard_slice_200", &run);
    print_mean("onboard_result", &once);
    (void)printf("onboard_whole %llu\n", instructions(run.sum));
}

static ema_least_squares_t squares;

/* A whole search by least squares, on the record with the current that the guarded session was fed. */
static void count_squares(uint32_t count)
{
    static ema_least_squares_config_t config;
    static const ema_value_id_t ids[EMA_LEAST_SQUARES_MAX] = {
        EMA_VALUE_ID(csj_Nm),   EMA_VALUE_ID(blk_mm),         EMA_VALUE_ID(viscous_Nm_s_per_rad),
        EMA_VALUE_ID(kp_per_m), EMA_VALUE_ID(resistance_ohm), EMA_VALUE_ID(torque_constant_Nm_per_A),
        EMA_VALUE_ID(supply_V), EMA_VALUE_ID(inertia_kgm2)};
    ticks_t run = {0};
    ticks_t init = {0};
    ticks_t once = {0};
    ema_least_squares_result_t result;
    config.actuator = &EMA_ACTUATOR;
    config.count = count;
    config.run_budget = 2500U;
    config.noise[EMA_CHANNEL_POSITION] = EMA_R(0.005);
    config.noise[EMA_CHANNEL_CURRENT] = EMA_R(0.03);
    for (uint32_t k = 0; k < count; ++k) {
        ema_real value = EMA_R(0.0);
        (void)ema_actuator_get(&EMA_ACTUATOR, ids[k], &value);
        const ema_searched_t searched = {ids[k], ids[k], value / EMA_R(3.0), value * EMA_R(3.0), value};
        config.searched[k] = searched;
    }
    uint32_t from = ema_counter_now();
    ema_status_t status = ema_least_squares_init(&squares, &config, &guarded.session.record);
    take(&init, from, ema_counter_now());
    while ((status == EMA_OK) && !ema_least_squares_done(&squares)) {
        from = ema_counter_now();
        status = ema_least_squares_run(&squares, 200U);
        take(&run, from, ema_counter_now());
    }
    from = ema_counter_now();
    if (status == EMA_OK) {
        status = ema_least_squares_result(&squares, &result);
    }
    take(&once, from, ema_counter_now());
    if (status != EMA_OK) {
        fail("squares", status);
    }
    if (!result.adequate) {
        /* another course through the code than the one that is to be counted */
        (void)printf("failed squares: %" PRIu32 " values do not explain the record\n", count);
        exit(1);
    }
    char label[48];
    (void)snprintf(label, sizeof label, "squares_%" PRIu32 "_slice_200", count);
    print_mean(label, &run);
    (void)snprintf(label, sizeof label, "squares_%" PRIu32 "_init", count);
    print_mean(label, &init);
    (void)snprintf(label, sizeof label, "squares_%" PRIu32 "_result", count);
    print_mean(label, &once);
    (void)printf("squares_%" PRIu32 "_whole %llu\nsquares_%" PRIu32 "_runs %" PRIu32 "\n", count, instructions(run.sum),
                 count, result.runs);
    (void)printf("squares_%" PRIu32 "_steps %llu\n", count, (unsigned long long)result.model_steps);
}

#define PAINTED_WORDS 2048U
#define PAINT 0xA5C3F00DU

/* Bytes of stack that `call` used: what it changed of the painted words below. */
static uint32_t stack_of(void (*call)(void))
{
    uintptr_t sp = 0U;
    __asm__ volatile("mov %0, sp" : "=r"(sp));
    volatile uint32_t* const lowest = (volatile uint32_t*)(sp - (PAINTED_WORDS * sizeof(uint32_t)));
    for (uint32_t k = 0; k < PAINTED_WORDS; ++k) {
        lowest[k] = PAINT;
    }
    call();
    uint32_t same = 0U;
    while ((same < PAINTED_WORDS) && (lowest[same] == PAINT)) {
        ++same;
    }
    return (PAINTED_WORDS - same) * (uint32_t)sizeof(uint32_t);
}

static ema_status_t called;

static void call_init(void)
{
    called = ema_session_init(&recorded.session, &recorded.config);
}

static void call_feed(void)
{
    ema_sample_t sample;
    for (uint32_t row = 0; (called == EMA_OK) && ema_recorded_row('a', row, &sample); ++row) {
        called = ema_session_feed(&recorded.session, &sample);
    }
}

static void call_run(void)
{
    while ((called == EMA_OK) && (ema_session_phase(&recorded.session) != EMA_PHASE_DONE)) {
        called = ema_session_run(&recorded.session, 200U);
    }
}

static void call_result(void)
{
    static ema_result_t result;
    called = ema_session_result(&recorded.session, &result);
}

/* The four calls over a whole identification; the frames of the functions around them are in it. */
static void measure_stack(void)
{
    called = ema_recorded_start(&recorded, 'a', 1U, EMA_RECORD_INT16, EMA_SEARCH_TWO_STAGES);
    if (called == EMA_OK) {
        (void)printf("stack_session_init %u\n", (unsigned)stack_of(call_init));
        (void)printf("stack_session_feed %u\n", (unsigned)stack_of(call_feed));
        (void)printf("stack_session_run %u\n", (unsigned)stack_of(call_run));
        (void)printf("stack_session_result %u\n", (unsigned)stack_of(call_result));
    }
    if (called != EMA_OK) {
        fail("stack", called);
    }
}

/* Slices of the unit's session: in the time of one of them the example firmware's allowance is kept. */
#define UNIT_SLICE_STEPS 8U

static uint32_t unit_slice;
static ticks_t unit_run;

static void call_unit(void)
{
    while ((called == EMA_OK) && (ema_session_phase(&recorded.session) != EMA_PHASE_DONE)) {
        const uint32_t from = ema_counter_now();
        called = ema_session_run(&recorded.session, unit_slice);
        take(&unit_run, from, ema_counter_now());
    }
}

/* The worn unit by its own model: standing effects in every model step, grease and winding of the day searched too. */
static void count_unit(uint32_t slice)
{
    static ema_result_t result;
    const ticks_t none = {0};
    unit_run = none;
    unit_slice = slice;
    called = ema_recorded_start(&recorded, 'u', 1U, EMA_RECORD_INT16, EMA_SEARCH_TWO_STAGES);
    const uint32_t stack = stack_of(call_unit);
    if (called == EMA_OK) {
        called = ema_session_result(&recorded.session, &result);
    }
    if (called != EMA_OK) {
        fail("unit", called);
    }
    if ((result.verdict != EMA_VERDICT_FAULT) || (result.identified_count != EMA_IDENTIFIED_MAX)) {
        /* another course through the code than the one that is to be counted */
        (void)printf("failed unit: verdict %d, %" PRIu32 " values\n", (int)result.verdict, result.identified_count);
        exit(1);
    }
    char label[32];
    (void)snprintf(label, sizeof label, "unit_slice_%" PRIu32, slice);
    print_mean(label, &unit_run);
    (void)printf("unit_identify_%" PRIu32 " %llu\n", slice, instructions(unit_run.sum));
    if (slice != UNIT_SLICE_STEPS) {
        (void)printf("stack_unit_run %u\nunit_runs %" PRIu32 "\n", (unsigned)stack, result.evaluations);
        (void)printf("unit_steps %llu\n", (unsigned long long)result.model_steps);
        const ema_actuator_t own = recorded.actuator;
        count_model("unit", &own);
    }
}

#define PRINT_SIZE(type) (void)printf("size_" #type " %u\n", (unsigned)sizeof(type))

static void print_sizes(void)
{
    PRINT_SIZE(ema_actuator_t);
    PRINT_SIZE(ema_annealer_config_t);
    PRINT_SIZE(ema_annealer_t);
    PRINT_SIZE(ema_command_t);
    PRINT_SIZE(ema_finding_t);
    PRINT_SIZE(ema_forecast_t);
    PRINT_SIZE(ema_guarded_t);
    PRINT_SIZE(ema_least_squares_t);
    PRINT_SIZE(ema_model_t);
    PRINT_SIZE(ema_objective_t);
    PRINT_SIZE(ema_onboard_t);
    PRINT_SIZE(ema_output_t);
    PRINT_SIZE(ema_plant_t);
    PRINT_SIZE(ema_random_t);
    PRINT_SIZE(ema_record_config_t);
    PRINT_SIZE(ema_record_t);
    PRINT_SIZE(ema_result_t);
    PRINT_SIZE(ema_sample_t);
    PRINT_SIZE(ema_sensitivity_t);
    PRINT_SIZE(ema_session_config_t);
    PRINT_SIZE(ema_session_t);
    PRINT_SIZE(ema_state_t);
    PRINT_SIZE(ema_trend_t);
    (void)printf("size_record_10s_int16 %u\n", (unsigned)EMA_RECORD_INT16_BYTES(EMA_RECORDED_ROWS, 2U));
    (void)printf("size_table %u\n", (unsigned)(sizeof EMA_SIGNATURES + sizeof ema_exported_patterns
                                               + sizeof ema_exported_units + sizeof ema_exported_values));
    (void)printf("table_products %u\ntable_bin_rows %u\n", (unsigned)(EMA_SIGNATURES.rows * EMA_SIGNATURES.channels),
                 (unsigned)EMA_SIGNATURES.bin_rows);
}

/* A trend with all its knots, and a forecast law by law. */
static void count_trend(void)
{
    static ema_trend_t trend;
    static ema_forecast_t forecast;
    static uint8_t bytes[EMA_TREND_BYTES];
    const ema_trend_config_t config = {EMA_R(50.0), EMA_R(0.01)};
    ticks_t update = {0};
    ticks_t law = {0};
    ticks_t result = {0};
    ticks_t save = {0};
    ema_outlook_t outlook;
    ema_trend_status_t status = ema_trend_init(&trend, 1U);
    for (uint32_t k = 0; (status == EMA_TREND_OK) && (k < 100U); ++k) {
        const ema_real day = EMA_R(7.0) * (ema_real)k;
        const ema_reading_t one = {day, (EMA_R(0.05) * day) + (EMA_R(0.3) * (ema_real)(k % 5U)), EMA_R(0.5)};
        const uint32_t from = ema_counter_now();
        status = ema_trend_update(&trend, &one);
        take(&update, from, ema_counter_now());
    }
    if (status == EMA_TREND_OK) {
        status = ema_forecast_start(&forecast, &trend, &config);
    }
    while ((status == EMA_TREND_OK) && !ema_forecast_done(&forecast)) {
        const uint32_t from = ema_counter_now();
        status = ema_forecast_run(&forecast, 1U);
        take(&law, from, ema_counter_now());
    }
    if (status == EMA_TREND_OK) {
        const uint32_t from = ema_counter_now();
        status = ema_forecast_result(&forecast, &outlook);
        take(&result, from, ema_counter_now());
    }
    if (status == EMA_TREND_OK) {
        const uint32_t from = ema_counter_now();
        status = ema_trend_save(&trend, bytes);
        take(&save, from, ema_counter_now());
    }
    if (status != EMA_TREND_OK) {
        (void)printf("failed trend: %s\n", ema_trend_text(status));
        exit(1);
    }
    print_mean("trend_update", &update);
    print_mean("trend_law", &law);
    print_mean("trend_result", &result);
    print_mean("trend_save", &save);
    (void)printf("trend_whole %llu\n", instructions(law.sum));
}

int main(void)
{
    ema_counter_start();
    calibrate();
    count_trend();
    print_sizes();
    count_selftest();
    count_calls();
    measure_stack();
    count_effects();
    static const uint32_t slices[] = {1U, 7U, 200U, 1000U};
    for (uint32_t k = 0; k < (sizeof slices / sizeof slices[0]); ++k) {
        count_identification(slices[k], EMA_RECORD_INT16, "int16");
    }
    count_identification(1000U, EMA_RECORD_REAL, "real");
    count_slices(1U);
    count_slices(200U);
    count_slices(1000U);
    count_guarded(200U, true, "guarded_function");
    count_guarded(1U, false, "guarded");
    count_guarded(200U, false, "guarded");
    count_onboard();
    count_squares(2U);
    count_squares(EMA_LEAST_SQUARES_MAX);
    count_unit(UNIT_SLICE_STEPS);
    count_unit(200U);
    (void)puts("counted all");
    return 0;
}
