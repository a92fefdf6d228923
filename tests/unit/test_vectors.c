/* The whole model against the stored records of the reference. What each record shows, and why its tolerances are what
 * they are: tests/vectors/manifest.json.
 */
#include <math.h>
#include <stdio.h>

#include "ema/ema.h"
#include "ema_rig.h"
#include "ema_vectors.inc"

void setUp(void)
{
}

void tearDown(void)
{
}

static ema_real number(ema_vec_bits_t bits)
{
    ema_real value;
    (void)memcpy(&value, &bits, sizeof value);
    return value;
}

/* A record of the whole model. */
typedef struct {
    const char* name;
    ema_actuator_t actuator;
    ema_command_config_t command;
    ema_real start_mm;
    uint32_t steps;
    uint32_t every_rows;
    uint32_t rows;
    const ema_vec_bits_t (*bits)[EMA_VEC_CHANNELS];
    ema_real largest[EMA_VEC_CHANNELS];
    ema_real rms[EMA_VEC_CHANNELS];
} record_t;

static const char* const channel_names[EMA_VEC_CHANNELS] = {"position_mm", "motor_position_mm", "current_A",
                                                            "voltage_V", "speed_mm_s"};

/* Fails with the channel's worst row when an error is beyond its tolerance. */
static void assert_channel(const record_t* record, uint32_t channel, double largest, double square, uint32_t worst_row,
                           double expected)
{
    const double rms = sqrt(square / record->rows);
    if (!(largest <= (double)record->largest[channel]) || !(rms <= (double)record->rms[channel])) {
        char text[240];
        (void)snprintf(
            text, sizeof text,
            "%s.%s: largest error %.3g (allowed %.3g) at row %u where %.9g is expected, rms %.3g (allowed %.3g)",
            record->name, channel_names[channel], largest, (double)record->largest[channel], (unsigned)worst_row,
            expected, rms, (double)record->rms[channel]);
        TEST_FAIL_MESSAGE(text);
    }
}

static void assert_record(const record_t* record)
{
    ema_command_t command;
    ema_model_t model = ema_rig_model(&record->actuator, record->start_mm);
    double largest[EMA_VEC_CHANNELS] = {0.0};
    double square[EMA_VEC_CHANNELS] = {0.0};
    double moved[EMA_VEC_CHANNELS] = {0.0};
    double expected_at[EMA_VEC_CHANNELS] = {0.0};
    uint32_t worst[EMA_VEC_CHANNELS] = {0U};
    uint32_t compared = 0U;
    EMA_ASSERT_STATUS(EMA_OK, ema_command_init(&command, &record->command, record->actuator.params.step_s));
    const uint32_t stride = (uint32_t)record->actuator.options.record_every_steps * record->every_rows;
    for (uint32_t step = 0; step < record->steps; ++step) {
        const ema_output_t row = ema_rig_step(&model, ema_command_at(&command, step));
        if (((step % stride) == 0U) && (compared < record->rows)) {
            const ema_real values[EMA_VEC_CHANNELS] = {row.position_mm, row.motor_position_mm, row.current_A,
                                                       row.voltage_V, row.speed_mm_s};
            for (uint32_t channel = 0; channel < EMA_VEC_CHANNELS; ++channel) {
                const double expected = (double)number(record->bits[compared][channel]);
                const double error = fabs((double)values[channel] - expected);
                TEST_ASSERT_TRUE(isfinite(error));
                square[channel] += error * error;
                moved[channel] = fmax(moved[channel], fabs(expected));
                if (error > largest[channel]) {
                    largest[channel] = error;
                    worst[channel] = compared;
                    expected_at[channel] = expected;
                }
            }
            ++compared;
        }
    }
    TEST_ASSERT_EQUAL_UINT32(record->rows, compared);
    TEST_ASSERT_EQUAL_UINT32(0U, model.state.unlocated_event_steps);
    /* a record of zeros would prove nothing */
    TEST_ASSERT_TRUE(moved[2] > 0.1);
    for (uint32_t channel = 0; channel < EMA_VEC_CHANNELS; ++channel) {
        assert_channel(record, channel, largest[channel], square[channel], worst[channel], expected_at[channel]);
    }
}

#define SET_VALUE(section, field, value) record.actuator.params.field = EMA_R(value);
#define SET_OPTION(section, field, value) record.actuator.options.field = (value);
#define SET_EFFECT(name, field, value) record.actuator.effects.name.field = EMA_R(value);

#define RECORD_TEST(case_name, CASE)                                                                                   \
    static void test_record_##case_name(void)                                                                          \
    {                                                                                                                  \
        record_t record = {.name = #case_name,                                                                         \
                           .command = EMA_VEC_##CASE##_COMMAND,                                                        \
                           .start_mm = EMA_VEC_##CASE##_START_MM,                                                      \
                           .steps = EMA_VEC_##CASE##_STEPS,                                                            \
                           .every_rows = EMA_VEC_##CASE##_EVERY_ROWS,                                                  \
                           .rows = EMA_VEC_##CASE##_ROWS,                                                              \
                           .bits = ema_vec_##case_name##_bits,                                                         \
                           .largest = EMA_VEC_##CASE##_LARGEST,                                                        \
                           .rms = EMA_VEC_##CASE##_RMS};                                                               \
        record.actuator = ema_rig_actuator();                                                                          \
        EMA_VEC_##CASE##_OVERRIDES(SET_VALUE) EMA_VEC_##CASE##_OPTIONS(SET_OPTION)                                     \
            EMA_VEC_##CASE##_EFFECTS(SET_EFFECT) assert_record(&record);                                               \
    }
EMA_VEC_CASES(RECORD_TEST)

int main(void)
{
    UNITY_BEGIN();
#define RUN_RECORD(case_name, CASE) RUN_TEST(test_record_##case_name);
    EMA_VEC_CASES(RUN_RECORD)
    return UNITY_END();
}
