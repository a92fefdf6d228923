/* The dearest step and the dearest slice, looked for on the emulated target: every effect, free and with as much dry
 * friction as a search may try, over commands that no ground test has; and whole sessions on records that no machine
 * makes. Run it with -icount shift=6, as ema_count.
 *
 * Prints a line for each: name, command, and the most that a slice, a step and the preparation of a run have taken; at
 * the end the most of all slices, the most work that one was counted for, which is the same in every build, and the
 * bytes of stack that the sessions used. `ema_worst slices` leaves out single steps, and the effects that had no long
 * slices where all of them were looked at. `ema_worst combinations 3000` looks for the longest slice over so many
 * configurations of pairs, of triples and of all effects, drives, control laws and sensors alone.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ema/ema.h"
#include "ema_counter.h"
#include "ema_recorded.h"

/* Of the time that an instruction takes, and that a tick is. */
#define INSTRUCTION_NS 64U
#define TICK_NS (1000000000U / EMA_COUNTER_HZ)
#define ROWS 2000U
#define SLICE 200U
/* Model runs of a session: enough for every kind of slice. */
#define RUNS 40U
#define RUNS_OF_MANY 12U

static ema_real buffer[2U * ROWS];
static ema_record_t record;
static ema_objective_t objective;

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

typedef struct {
    uint32_t ticks;
    uint32_t spent; /* of the same */
} worst_t;

/* Of everything that was looked at. */
static uint32_t most_ticks;
static uint32_t most_work; /* of a slice of model steps */
static uint32_t most_stack;
static uint32_t combined_ticks; /* of the combinations that are looked at */
static bool combining;          /* what many effects make may leave the finite numbers */

static bool slices_alone;

/* Effects with the longest slices of model steps, and with the most work in one: docs/BUDGETS.md. */
static bool long_slices(const char* effect)
{
    static const char* const names[] = {"current_limit",   "learned_reading", "elastic_backlash",
                                        "learned_voltage", "presliding",      "stribeck_friction"};
    bool found = false;
    for (size_t k = 0; k < (sizeof names / sizeof names[0]); ++k) {
        found = found || (strcmp(effect, names[k]) == 0);
    }
    return found;
}

static void keep_most(uint32_t* most, uint32_t value)
{
    *most = (value > *most) ? value : *most;
}

/* Stack below the function that says so, painted before its calls and looked at afterwards. */
#define PAINTED_WORDS 2048U
#define PAINT 0xA5C3F00DU
#if defined(__arm__)
#define STACK_POINTER(place) __asm__ volatile("mov %0, sp" : "=r"(place))
#elif defined(__riscv)
#define STACK_POINTER(place) __asm__ volatile("mv %0, sp" : "=r"(place))
#elif defined(__powerpc__)
#define STACK_POINTER(place) __asm__ volatile("mr %0, 1" : "=r"(place))
#elif defined(__x86_64__)
#define STACK_POINTER(place) __asm__ volatile("mov %%rsp, %0" : "=r"(place))
#else
#define STACK_POINTER(place) ((place) = 0U)
#endif

#define PAINT_STACK(lowest)                                                                                            \
    do {                                                                                                               \
        uintptr_t place = 0U;                                                                                          \
        STACK_POINTER(place);                                                                                          \
        (lowest) = (volatile uint32_t*)((place != 0U) ? (place - (PAINTED_WORDS * sizeof(uint32_t))) : 0U);            \
        for (uint32_t word = 0; ((lowest) != NULL) && (word < PAINTED_WORDS); ++word) {                                \
            (lowest)[word] = PAINT;                                                                                    \
        }                                                                                                              \
    } while (false)

static void take_stack(const volatile uint32_t* lowest)
{
    uint32_t same = 0U;
    while ((lowest != NULL) && (same < PAINTED_WORDS) && (lowest[same] == PAINT)) {
        ++same;
    }
    keep_most(&most_stack, (lowest != NULL) ? ((PAINTED_WORDS - same) * (uint32_t)sizeof(uint32_t)) : 0U);
}

static unsigned long long instructions(uint64_t ticks)
{
    return (unsigned long long)(((ticks * TICK_NS) + (INSTRUCTION_NS - 1U)) / INSTRUCTION_NS);
}

/* Between -1 and 1, the same on every run. */
static ema_real draw(uint32_t* drawn)
{
    *drawn = (*drawn * 1664525U) + 1013904223U;
    return ((ema_real)(*drawn >> 8U) / EMA_R(8388608.0)) - EMA_R(1.0);
}

typedef ema_real (*command_fn)(uint32_t row, ema_real travel_mm, uint32_t* drawn);

static ema_real chirp(uint32_t row, ema_real travel_mm, uint32_t* drawn)
{
    (void)travel_mm;
    (void)drawn;
    ema_sample_t sample = {0};
    /* its quick end */
    (void)ema_recorded_row('a', EMA_RECORDED_ROWS - ROWS + row, &sample);
    return sample.command_mm;
}

static ema_real jumps(uint32_t row, ema_real travel_mm, uint32_t* drawn)
{
    (void)drawn;
    return ((row & 1U) != 0U) ? travel_mm : -travel_mm;
}

static ema_real noise(uint32_t row, ema_real travel_mm, uint32_t* drawn)
{
    (void)row;
    (void)drawn;
    return draw(drawn) * travel_mm;
}

static ema_real square(uint32_t row, ema_real travel_mm, uint32_t* drawn)
{
    (void)travel_mm;
    (void)drawn;
    return (((row / 150U) & 1U) != 0U) ? EMA_R(3.0) : EMA_R(-3.0);
}

static ema_real dither(uint32_t row, ema_real travel_mm, uint32_t* drawn)
{
    (void)row;
    (void)drawn;
    (void)travel_mm;
    return draw(drawn) * EMA_R(0.05);
}

static ema_real ends(uint32_t row, ema_real travel_mm, uint32_t* drawn)
{
    (void)drawn;
    return (((row / 700U) & 1U) != 0U) ? travel_mm : -travel_mm;
}

static const struct {
    const char* name;
    command_fn at;
} commands[] = {{"chirp", chirp},   {"jumps", jumps},   {"noise", noise},
                {"square", square}, {"dither", dither}, {"ends", ends}};

#define COMMANDS (sizeof commands / sizeof commands[0])

static void fail(const char* what, ema_status_t status)
{
    (void)printf("failed %s: %s\n", what, ema_status_text(status));
    exit(1);
}

/* One model run against the record, in slices; returns what starting it took. */
static uint32_t run(const char* name, const ema_actuator_t* actuator, uint32_t slice, worst_t* worst)
{
    static const ema_real weight[EMA_CHANNEL_COUNT] = {[EMA_CHANNEL_POSITION] = EMA_R(1.0)};
    uint32_t from = ema_counter_now();
    const ema_status_t status = ema_objective_start(&objective, actuator, &record, weight, EMA_R(0.0), EMA_COST_MAX);
    const uint32_t start = ema_counter_now() - from;
    if (status != EMA_OK) {
        fail(name, status);
    }
    ema_objective_state_t state = EMA_OBJECTIVE_RUNNING;
    while (state == EMA_OBJECTIVE_RUNNING) {
        from = ema_counter_now();
        state = ema_objective_run(&objective, slice);
        const uint32_t ticks = ema_counter_now() - from;
        keep_most(&most_ticks, (slice == SLICE) ? ticks : 0U);
        keep_most(&most_work, (slice == SLICE) ? objective.model.work.spent : 0U);
        if (ticks > worst->ticks) {
            worst->ticks = ticks;
            worst->spent = objective.model.work.spent;
        }
    }
    if ((state != EMA_OBJECTIVE_DONE) && !combining) {
        fail(name, EMA_ERR_DIVERGED);
    }
    return start;
}

/* A record of the command alone. */
static void record_command(size_t which, ema_real travel_mm)
{
    const ema_record_config_t config = {.buffer = buffer, .buffer_bytes = sizeof buffer, .format = EMA_RECORD_REAL};
    uint32_t drawn = 1U;
    ema_status_t status = ema_record_init(&record, &config);
    for (uint32_t row = 0; (status == EMA_OK) && (row < ROWS); ++row) {
        ema_sample_t sample = {0};
        sample.command_mm = commands[which].at(row, travel_mm, &drawn);
        status = ema_record_append(&record, &sample);
    }
    if (status != EMA_OK) {
        fail(commands[which].name, status);
    }
}

static void look(const char* name, const ema_actuator_t* actuator, const char* friction)
{
    for (size_t k = 0; k < COMMANDS; ++k) {
        record_command(k, actuator->params.travel_mm);
        worst_t slice = {0};
        worst_t step = {0};
        const uint32_t start = run(name, actuator, SLICE, &slice);
        if (!slices_alone) {
            (void)run(name, actuator, 1U, &step);
        }
        (void)printf("%s %s %s slice %llu of %" PRIu32 " step %llu of %" PRIu32 " start %llu\n", name, commands[k].name,
                     friction, instructions(slice.ticks), slice.spent, instructions(step.ticks), step.spent,
                     instructions(start));
    }
}

static void look_free_and_seized(const char* name, ema_actuator_t* actuator)
{
    look(name, actuator, "free");
    (void)ema_actuator_set(actuator, EMA_VALUE_ID(csj_Nm), actuator->params.csj_upper_Nm);
    look(name, actuator, "seized");
}

/* What a session is fed in the place of the sensors' signals, the first four of them with slices alone: what no
 * machine makes, and the kinds of docs/FAULTS.md that are not refused. */
#define EMA_FED_LIST(ROW)                                                                                              \
    ROW(wrong_sign, (void)drawn, position_mm = -position_mm)                                                           \
    ROW(noise, command_mm = draw(drawn) * travel_mm, position_mm = draw(drawn) * travel_mm)                            \
    ROW(nothing, (void)drawn, position_mm = EMA_R(0.0))                                                                \
    ROW(swapped, command_mm = position_mm, position_mm = recorded->command_mm)                                         \
    ROW(as_recorded, (void)drawn, (void)position_mm)                                                                   \
    ROW(resolution, (void)drawn, position_mm = (ema_real)(int32_t)(position_mm * EMA_R(10.0)) / EMA_R(10.0))           \
    ROW(stuck, (void)drawn, position_mm = position_of((row < 500U) ? row : 500U))                                      \
    ROW(old_values, (void)drawn, position_mm = position_of(row - (row % 20U)))                                         \
    ROW(dropout, (void)drawn, position_mm = ((row / 500U) == 1U) ? EMA_R(0.0) : position_mm)                           \
    ROW(lost_rows, (void)drawn, position_mm = position_of((row < 500U) ? row : (row + 100U)))                          \
    ROW(spikes, (void)drawn, position_mm += ((row % 40U) == 20U) ? EMA_R(5.0) : EMA_R(0.0))                            \
    ROW(saturation, (void)drawn, position_mm = within(position_mm, EMA_R(1.0)))                                        \
    ROW(jitter, (void)drawn, position_mm = position_of(row + ((draw(drawn) > EMA_R(0.0)) ? 2U : 0U)))                  \
    ROW(clock, (void)drawn, position_mm = position_of((row * 101U) / 100U))                                            \
    ROW(late, (void)drawn, position_mm = position_of((row < 50U) ? 0U : (row - 50U)))                                  \
    ROW(early, (void)drawn, position_mm = position_of(row + 5U))                                                       \
    ROW(command_sign, command_mm = -command_mm, (void)drawn)                                                           \
    ROW(scale, (void)drawn, position_mm *= EMA_R(0.98))                                                                \
    ROW(offset, (void)drawn, position_mm += EMA_R(1.0))                                                                \
    ROW(drift, (void)drawn, position_mm += (ema_real)row * EMA_R(5.0e-5))                                              \
    ROW(current, (void)drawn, position_mm = recorded->channel[EMA_CHANNEL_CURRENT])                                    \
    ROW(other_command, command_mm *= EMA_R(1.1), (void)drawn)

#define EMA_FED_SLICES_ALONE 4U

/* The rod of the recorded case. */
static ema_real position_of(uint32_t row)
{
    ema_sample_t sample = {0};
    (void)ema_recorded_row('b', row, &sample);
    return sample.channel[EMA_CHANNEL_POSITION];
}

static ema_real within(ema_real value, ema_real limit)
{
    return (value > limit) ? limit : (value < -limit) ? -limit : value;
}

typedef void (*fed_fn)(uint32_t row, ema_real travel_mm, uint32_t* drawn, const ema_sample_t* recorded,
                       ema_sample_t* fed);

#define EMA_FED_FUNCTION(name, first, second)                                                                          \
    static void fed_##name(uint32_t row, ema_real travel_mm, uint32_t* drawn, const ema_sample_t* recorded,            \
                           ema_sample_t* fed)                                                                          \
    {                                                                                                                  \
        ema_real command_mm = recorded->command_mm;                                                                    \
        ema_real position_mm = recorded->channel[EMA_CHANNEL_POSITION];                                                \
        (void)row;                                                                                                     \
        (void)drawn;                                                                                                   \
        (void)travel_mm;                                                                                               \
        first;                                                                                                         \
        second;                                                                                                        \
        fed->command_mm = command_mm;                                                                                  \
        fed->channel[EMA_CHANNEL_POSITION] = position_mm;                                                              \
    }
EMA_FED_LIST(EMA_FED_FUNCTION)

static const struct {
    const char* name;
    fed_fn at;
} feds[] = {
#define EMA_FED_ROW(name, first, second) {#name, fed_##name},
    EMA_FED_LIST(EMA_FED_ROW)};

#define EMA_FED_KINDS (sizeof feds / sizeof feds[0])

/* The longest slice of a session on such a record, grease and winding of the day searched too. Without a name it is one
 * of many, and shorter. */
static void look_session(const char* name, const ema_actuator_t* actuator, size_t fed)
{
    static ema_session_t session;
    static ema_session_config_t config;
    const ema_record_config_t recorded = {.buffer = buffer, .buffer_bytes = sizeof buffer, .format = EMA_RECORD_REAL};
    uint32_t drawn = 1U;
    ema_status_t status = ema_session_config_default(&config, actuator, &recorded);
    if (status == EMA_OK) {
        status = ema_session_config_day(&config);
    }
    if (status == EMA_OK) {
        config.annealer.evaluation_budget = (name != NULL) ? RUNS : RUNS_OF_MANY;
        status = ema_session_init(&session, &config);
    }
    for (uint32_t row = 0; (status == EMA_OK) && (row < ROWS); ++row) {
        ema_sample_t original = {0};
        (void)ema_recorded_row('b', row, &original);
        ema_sample_t sample = original;
        feds[fed].at(row, actuator->params.travel_mm, &drawn, &original, &sample);
        status = ema_session_feed(&session, &sample);
    }
    uint32_t worst = 0U;
    volatile uint32_t* lowest = NULL;
    PAINT_STACK(lowest);
    while ((status == EMA_OK) && (ema_session_phase(&session) != EMA_PHASE_DONE)) {
        const uint32_t from = ema_counter_now();
        status = ema_session_run(&session, SLICE);
        const uint32_t ticks = ema_counter_now() - from;
        keep_most(&worst, ticks);
    }
    take_stack(lowest);
    keep_most(&most_ticks, worst);
    keep_most(&combined_ticks, worst);
    if (name != NULL) {
        if (status != EMA_OK) {
            fail(name, status);
        }
        (void)printf("session %s %s slice %llu\n", name, feds[fed].name, instructions(worst));
    }
}

static void look_sessions(const char* name, const ema_actuator_t* actuator)
{
    const size_t kinds = slices_alone ? EMA_FED_SLICES_ALONE : EMA_FED_KINDS;
    for (size_t fed = 0; fed < kinds; ++fed) {
        look_session(name, actuator, fed);
    }
}

/* Adds the effect whose rows begin at `place`; returns the place of the next one. */
static size_t add_effect(ema_actuator_t* actuator, size_t place)
{
    const char* const name = costed[place].effect;
    size_t next = place;
    for (; (next < COSTED) && (strcmp(costed[next].effect, name) == 0); ++next) {
        (void)ema_actuator_set(actuator, costed[next].id, costed[next].value);
    }
    return next;
}

/* Drives, control laws and sensors of a configuration, drawn. */
static void draw_blocks(ema_actuator_t* actuator, uint32_t* drawn)
{
    if (draw(drawn) > EMA_R(0.5)) {
        actuator->options.mode = 1;
        actuator->params.current_scale_A = EMA_R(20.0);
        actuator->params.current_loop_s = (draw(drawn) > EMA_R(0.0)) ? EMA_R(0.0005) : EMA_R(0.0);
    }
    if (draw(drawn) > EMA_R(0.5)) {
        actuator->params.output_delay_s = EMA_R(0.0015);
    }
    if (draw(drawn) > EMA_R(0.5)) {
        actuator->options.structure = 1;
        actuator->options.average_speed = 1;
        actuator->params.kd_s_per_m = EMA_R(50.0);
        actuator->params.speed_limit_m_s = EMA_R(0.1);
    } else if (draw(drawn) > EMA_R(0.5)) {
        actuator->params.kd_s_per_m = EMA_R(10.0);
    } else {
        /* proportional and integral action on position */
    }
    if (draw(drawn) > EMA_R(0.5)) {
        actuator->params.delay_s = EMA_R(0.0025);
        actuator->params.resolution_mm = EMA_R(0.001);
    }
}

/* Effects of a configuration: so many of them drawn, or all. */
#define EMA_COMBINED_ALL UINT32_MAX

/* `number` configurations with `effects` effects each: every second one as a model run over a command, the others as
 * whole sessions on a record that no machine makes. Prints the longest slice of all of them, and of the model steps
 * alone the most work. */
static void look_combinations(const char* name, const ema_actuator_t* healthy, uint32_t effects, uint32_t number)
{
    uint32_t drawn = 2024U + effects;
    uint32_t refused = 0U;
    combined_ticks = 0U;
    combining = true;
    for (uint32_t k = 0; k < number; ++k) {
        ema_actuator_t actuator = *healthy;
        ema_model_t* const model = &objective.model;
        draw_blocks(&actuator, &drawn);
        for (uint32_t place = 0; (effects == EMA_COMBINED_ALL) && (place < COSTED);) {
            place = (uint32_t)add_effect(&actuator, place);
        }
        for (uint32_t effect = 0; (effects != EMA_COMBINED_ALL) && (effect < effects); ++effect) {
            uint32_t place = (uint32_t)((draw(&drawn) + EMA_R(1.0)) * EMA_R(0.5) * (ema_real)COSTED);
            while ((place > 0U) && (strcmp(costed[place - 1U].effect, costed[place].effect) == 0)) {
                --place;
            }
            (void)add_effect(&actuator, place);
        }
        if (draw(&drawn) > EMA_R(0.5)) {
            (void)ema_actuator_set(&actuator, EMA_VALUE_ID(csj_Nm), actuator.params.csj_upper_Nm);
        }
        const uint32_t which = (uint32_t)((draw(&drawn) + EMA_R(1.0)) * EMA_R(1.0e6));
        if (ema_model_init(model, &actuator, EMA_R(0.0)) != EMA_OK) {
            ++refused;
        } else if ((k & 1U) != 0U) {
            look_session(NULL, &actuator, which % EMA_FED_KINDS);
        } else {
            worst_t slice = {0};
            record_command(which % COMMANDS, actuator.params.travel_mm);
            (void)run(name, &actuator, SLICE, &slice);
            keep_most(&combined_ticks, slice.ticks);
        }
    }
    combining = false;
    (void)printf("combinations %s of %" PRIu32 " slice %llu refused %" PRIu32 "\n", name, number,
                 instructions(combined_ticks), refused);
}

int main(int argc, char* argv[])
{
    ema_actuator_t healthy;
    slices_alone = (argc > 1) && (strcmp(argv[1], "slices") == 0);
    const bool alone = (argc > 2) && (strcmp(argv[1], "combinations") == 0);
    const uint32_t combined = alone ? (uint32_t)strtoul(argv[2], NULL, 10) : (slices_alone ? 10U : 40U);
    ema_counter_start();
    (void)ema_actuator_defaults(&healthy);
    healthy.options.day_values = 1;
    look_combinations("pairs", &healthy, 2U, combined);
    look_combinations("triples", &healthy, 3U, combined);
    look_combinations("all", &healthy, EMA_COMBINED_ALL, (combined / 8U) + 1U);
    if (alone) {
        (void)printf("looked everywhere\n");
        return 0;
    }
    /* of these the document states the longest by themselves */
    most_ticks = 0U;
    healthy.options.day_values = 0;
    ema_actuator_t actuator = healthy;
    look_free_and_seized("healthy", &actuator);
    for (size_t k = 0; k < COSTED;) {
        const char* const name = costed[k].effect;
        actuator = healthy;
        for (; (k < COSTED) && (strcmp(costed[k].effect, name) == 0); ++k) {
            (void)ema_actuator_set(&actuator, costed[k].id, costed[k].value);
        }
        if (!slices_alone || long_slices(name)) {
            look_free_and_seized(name, &actuator);
        }
    }
    healthy.options.day_values = 1;
    look_sessions("healthy", &healthy);
    (void)ema_actuator_set(&healthy, EMA_EFFECT_VALUE_ID(presliding, stretch_rad), EMA_R(0.02));
    (void)ema_actuator_set(&healthy, EMA_EFFECT_VALUE_ID(pitch_ripple, ratio), EMA_R(0.03));
    look_sessions("presliding+pitch_ripple", &healthy);
    (void)printf("most slice %llu work %" PRIu32 " stack %" PRIu32 "\n", instructions(most_ticks), most_work,
                 most_stack);
    (void)printf("looked everywhere\n");
    return 0;
}
