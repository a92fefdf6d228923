/* The same bits on every machine and from every compiler: fingerprints of a run with effects and of an identification.
 *
 * The fingerprints change with any change of the arithmetic, and then only on purpose: the failing test prints the new
 * ones. They must be equal in every build of the same precision, whatever the compiler and its optimisation.
 */
#include "ema_fingerprint.h"

#if EMA_REAL64
#define RUN_FINGERPRINT UINT64_C(0xD39ED1042121DE59)
#define SEARCH_FINGERPRINT UINT64_C(0x014AC409032FFBA5)
#define STAGES_FINGERPRINT UINT64_C(0x11C42645CECD38F3)
#else
#define RUN_FINGERPRINT UINT64_C(0x7687E81C61135028)
#define SEARCH_FINGERPRINT UINT64_C(0x4A413252CC0610D1)
#define STAGES_FINGERPRINT UINT64_C(0x86A1F32E0985AA72)
#endif

static ema_real buffer[2U * FINGERPRINT_ROWS];

void setUp(void)
{
}
void tearDown(void)
{
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
    const ema_command_t command = fingerprint_chirp();
    uint64_t hash = FINGERPRINT_START;
    TEST_ASSERT_EQUAL(EMA_OK, ema_model_init(&model, &actuator, EMA_R(0.0)));
    for (uint32_t row = 0; row < FINGERPRINT_ROWS; ++row) {
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
    ema_actuator_t healthy;
    TEST_ASSERT_EQUAL(EMA_OK, ema_actuator_defaults(&healthy));
    const ema_record_config_t record = {.buffer = buffer, .buffer_bytes = sizeof buffer, .format = EMA_RECORD_REAL};
    TEST_ASSERT_EQUAL_HEX64(SEARCH_FINGERPRINT, fingerprint_of_answer(&healthy, &record, EMA_SEARCH_ANNEALER));
    TEST_ASSERT_EQUAL_HEX64(STAGES_FINGERPRINT, fingerprint_of_answer(&healthy, &record, EMA_SEARCH_TWO_STAGES));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_run_with_effects_has_the_same_bits_everywhere);
    RUN_TEST(test_an_identification_has_the_same_bits_everywhere);
    return UNITY_END();
}
