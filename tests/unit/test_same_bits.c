/* The same bits on every machine and from every compiler: fingerprints of a run with effects and of an identification.
 *
 * The fingerprints change with any change of the arithmetic, and then only on purpose: the failing test prints the new
 * ones. They must be equal in every build of the same precision, whatever the compiler and its optimisation.
 */
#include "ema/ema_session.h"
#include "unity.h"

#if EMA_REAL64
#define RUN_FINGERPRINT UINT64_C(0xD39ED1042121DE59)
#define SEARCH_FINGERPRINT UINT64_C(0x014AC409032FFBA5)
#else
#define RUN_FINGERPRINT UINT64_C(0x7687E81C61135028)
#define SEARCH_FINGERPRINT UINT64_C(0x4A413252CC0610D1)
#endif

#define ROWS 4000U

static ema_real buffer[2U * ROWS];
static ema_session_t session;

void setUp(void)
{
}
void tearDown(void)
{
}

/* FNV-1a over bytes. */
static uint64_t fingerprint(uint64_t hash, const void* bytes, size_t count)
{
    const unsigned char* const data = bytes;
    for (size_t k = 0; k < count; ++k) {
        hash = (hash ^ data[k]) * UINT64_C(1099511628211);
    }
    return hash;
}

static uint64_t fingerprint_of(uint64_t hash, ema_real value)
{
    return fingerprint(hash, &value, sizeof value);
}

static ema_command_t chirp(void)
{
    ema_command_t command;
    const ema_command_config_t config = {.kind = EMA_COMMAND_CHIRP,
                                         .amplitude_mm = EMA_R(2.0),
                                         .start_hz = EMA_R(0.1),
                                         .end_hz = EMA_R(4.0),
                                         .duration_s = EMA_R(4.0)};
    TEST_ASSERT_EQUAL(EMA_OK, ema_command_init(&command, &config, EMA_R(0.001)));
    return command;
}

static void test_a_run_with_effects_has_the_same_bits_everywhere(void)
{
    static ema_model_t model;
    ema_actuator_t actuator;
    TEST_ASSERT_EQUAL(EMA_OK, ema_actuator_defaults(&actuator));
    actuator.effects.stribeck_friction.rise = EMA_R(0.3);
    actuator.effects.stribeck_friction.shape = EMA_R(1.3);
    actuator.effects.cogging_torque.amplitude_Nm = EMA_R(0.02);
    actuator.effects.inverter_dead_time.drop_V = EMA_R(0.2);
    actuator.effects.transmission_compliance.period_s = EMA_R(0.02);
    const ema_command_t command = chirp();
    uint64_t hash = UINT64_C(14695981039346656037);
    TEST_ASSERT_EQUAL(EMA_OK, ema_model_init(&model, &actuator, EMA_R(0.0)));
    for (uint32_t row = 0; row < ROWS; ++row) {
        ema_output_t output;
        TEST_ASSERT_EQUAL(EMA_OK, ema_model_step(&model, ema_command_at(&command, row), &output));
        hash = fingerprint_of(hash, output.position_mm);
        hash = fingerprint_of(hash, output.current_A);
        hash = fingerprint_of(hash, output.voltage_V);
    }
    TEST_ASSERT_EQUAL_HEX64(RUN_FINGERPRINT, hash);
}

static void test_an_identification_has_the_same_bits_everywhere(void)
{
    static ema_model_t model;
    ema_actuator_t healthy;
    TEST_ASSERT_EQUAL(EMA_OK, ema_actuator_defaults(&healthy));
    ema_actuator_t worn = healthy;
    worn.params.csj_Nm = EMA_R(0.3);
    worn.params.blk_mm = EMA_R(0.04125);
    const ema_command_t command = chirp();
    const ema_record_config_t record = {.buffer = buffer, .buffer_bytes = sizeof buffer, .format = EMA_RECORD_REAL};
    ema_session_config_t config;
    ema_result_t result;
    TEST_ASSERT_EQUAL(EMA_OK, ema_session_config_default(&config, &healthy, &record));
    TEST_ASSERT_EQUAL(EMA_OK, ema_session_init(&session, &config));
    TEST_ASSERT_EQUAL(EMA_OK, ema_model_init(&model, &worn, EMA_R(0.0)));
    for (uint32_t row = 0; row < ROWS; ++row) {
        ema_output_t output;
        ema_sample_t sample = {.command_mm = ema_command_at(&command, row)};
        TEST_ASSERT_EQUAL(EMA_OK, ema_model_step(&model, sample.command_mm, &output));
        sample.channel[EMA_CHANNEL_POSITION] = output.position_mm;
        TEST_ASSERT_EQUAL(EMA_OK, ema_session_feed(&session, &sample));
    }
    while (ema_session_phase(&session) != EMA_PHASE_DONE) {
        TEST_ASSERT_EQUAL(EMA_OK, ema_session_run(&session, 5000U));
    }
    TEST_ASSERT_EQUAL(EMA_OK, ema_session_result(&session, &result));
    uint64_t hash = UINT64_C(14695981039346656037);
    hash = fingerprint(hash, &result.random.state, sizeof result.random.state);
    hash = fingerprint(hash, &result.evaluations, sizeof result.evaluations);
    for (uint32_t i = 0; i < result.identified_count; ++i) {
        hash = fingerprint_of(hash, result.identified[i].estimate);
        hash = fingerprint_of(hash, result.identified[i].std);
    }
    hash = fingerprint_of(hash, result.objective_after);
    TEST_ASSERT_EQUAL_HEX64(SEARCH_FINGERPRINT, hash);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_run_with_effects_has_the_same_bits_everywhere);
    RUN_TEST(test_an_identification_has_the_same_bits_everywhere);
    return UNITY_END();
}
