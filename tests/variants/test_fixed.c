/* A build that fixes control law, drive, encoder and record: what it holds has the bits of the build that has them all,
 * the rest is refused. The same file is a test of both. */
#include "ema/ema_session.h"
#include "unity.h"

/* What a build that has everything says; in every other one it is the same. */
#define ANSWER_FINGERPRINT UINT64_C(0x0C183840E167CB05)
#define EFFECT_FINGERPRINT UINT64_C(0x866CFB750CCC1DDD)

#define ROWS 4000U
#define FULL_SCALE_MM EMA_R(4.0)

/* What of the rest a build answers. */
#if EMA_TEST_FIXED
#define REST EMA_ERR_ABSENT
#else
#define REST EMA_OK
#endif

static ema_actuator_t actuator;
static ema_model_t model;
static ema_session_t session;
static ema_session_config_t config;
static int16_t buffer[2U * ROWS];
static ema_record_config_t record;

void setUp(void)
{
    const ema_record_config_t fresh = {.buffer = buffer,
                                       .buffer_bytes = sizeof buffer,
                                       .format = EMA_RECORD_INT16,
                                       .command_full_scale_mm = FULL_SCALE_MM,
                                       .full_scale = {FULL_SCALE_MM, FULL_SCALE_MM, FULL_SCALE_MM, FULL_SCALE_MM}};
    record = fresh;
    TEST_ASSERT_EQUAL(EMA_OK, ema_actuator_defaults(&actuator));
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

static ema_command_t chirp(void)
{
    ema_command_t command;
    const ema_command_config_t asked = {.kind = EMA_COMMAND_CHIRP,
                                        .amplitude_mm = EMA_R(2.0),
                                        .start_hz = EMA_R(0.1),
                                        .end_hz = EMA_R(4.0),
                                        .duration_s = EMA_R(4.0)};
    TEST_ASSERT_EQUAL(EMA_OK, ema_command_init(&command, &asked, EMA_R(0.001)));
    return command;
}

/* An identification of a worn actuator: estimates, their errors, and the way of the search. */
static uint64_t answer_of(const ema_actuator_t* healthy)
{
    ema_actuator_t worn = *healthy;
    worn.params.csj_Nm = EMA_R(0.3);
    worn.params.blk_mm = EMA_R(0.04125);
    const ema_command_t command = chirp();
    ema_result_t result;
    TEST_ASSERT_EQUAL(EMA_OK, ema_session_config_default(&config, healthy, &record));
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
    TEST_ASSERT_EQUAL(EMA_VERDICT_FAULT, result.verdict);
    uint64_t hash = UINT64_C(14695981039346656037);
    hash = fingerprint(hash, &result.random.state, sizeof result.random.state);
    hash = fingerprint(hash, &result.evaluations, sizeof result.evaluations);
    for (uint32_t i = 0; i < result.identified_count; ++i) {
        hash = fingerprint(hash, &result.identified[i].estimate, sizeof result.identified[i].estimate);
        hash = fingerprint(hash, &result.identified[i].std, sizeof result.identified[i].std);
    }
    return fingerprint(hash, &result.objective_after, sizeof result.objective_after);
}

static void test_an_answer_has_the_bits_of_every_build(void)
{
    TEST_ASSERT_EQUAL_HEX64(ANSWER_FINGERPRINT, answer_of(&actuator));
}

/* The loop sees the rod here, which no choice forbids. */
static void test_an_answer_with_an_effect_has_them_too(void)
{
#if EMA_TEST_SOME
    actuator.options.side = 1;
    actuator.effects.stribeck_friction.rise = EMA_R(0.3);
    TEST_ASSERT_EQUAL_HEX64(EFFECT_FINGERPRINT, answer_of(&actuator));
#else
    actuator.effects.stribeck_friction.rise = EMA_R(0.3);
    size_t offender = 0U;
    TEST_ASSERT_EQUAL(EMA_ERR_ABSENT, ema_actuator_check(&actuator, &offender));
    TEST_ASSERT_EQUAL_size_t(EMA_EFFECT_VALUE_ID(stribeck_friction, rise), offender);
#endif
}

static void test_an_effect_that_is_left_out_is_refused(void)
{
    size_t offender = 0U;
    actuator.effects.cogging_torque.amplitude_Nm = EMA_R(0.01);
    TEST_ASSERT_EQUAL(REST, ema_actuator_check(&actuator, &offender));
    TEST_ASSERT_EQUAL_size_t((REST == EMA_OK) ? 0U : (size_t)EMA_EFFECT_VALUE_ID(cogging_torque, amplitude_Nm),
                             offender);
}

/* Of a session and of a model; the rest of the actuator is the reference. */
static void assert_taken(ema_status_t expected, int line)
{
    size_t offender = 0U;
    UNITY_TEST_ASSERT_EQUAL_INT(expected, ema_actuator_check(&actuator, &offender), line, "check");
    UNITY_TEST_ASSERT_EQUAL_INT((expected == EMA_OK) ? 0U : EMA_VALUE_COUNT, offender, line, "offender");
    UNITY_TEST_ASSERT_EQUAL_INT(expected, ema_model_init(&model, &actuator, EMA_R(0.0)), line, "model");
    UNITY_TEST_ASSERT_EQUAL_INT(EMA_OK, ema_session_config_default(&config, &actuator, &record), line, "config");
    UNITY_TEST_ASSERT_EQUAL_INT(expected, ema_session_init(&session, &config), line, "session");
}

static void test_another_control_law_is_refused(void)
{
    actuator.params.kd_s_per_m = EMA_R(1.0);
    assert_taken(REST, __LINE__);
    setUp();
    actuator.options.structure = 1;
    assert_taken(REST, __LINE__);
}

static void test_another_drive_is_refused(void)
{
    actuator.options.mode = 1;
    assert_taken(REST, __LINE__);
    setUp();
    actuator.params.output_delay_s = EMA_R(0.0005);
    assert_taken(REST, __LINE__);
}

static void test_another_encoder_is_refused(void)
{
    actuator.params.delay_s = EMA_R(0.002);
    assert_taken(REST, __LINE__);
    setUp();
    actuator.params.resolution_mm = EMA_R(0.001);
    assert_taken(REST, __LINE__);
}

/* It asks for a late feedback when the model is made. */
static void test_an_effect_that_asks_for_what_is_left_out_is_refused(void)
{
    actuator.effects.feedback_delay.delay_s = EMA_R(0.002);
    TEST_ASSERT_EQUAL(REST, ema_model_init(&model, &actuator, EMA_R(0.0)));
}

static void test_another_record_is_refused(void)
{
    static ema_real reals[400];
    static ema_command_t command;
    command = chirp();
    ema_record_t made;
    TEST_ASSERT_EQUAL(EMA_OK, ema_record_init(&made, &record));
    record.command = &command;
    TEST_ASSERT_EQUAL(REST, ema_record_init(&made, &record));
    setUp();
    record.format = EMA_RECORD_REAL;
    record.buffer = reals;
    record.buffer_bytes = sizeof reals;
    TEST_ASSERT_EQUAL(REST, ema_record_init(&made, &record));
    record.format = (ema_record_format_t)2;
    TEST_ASSERT_EQUAL(EMA_ERR_RANGE, ema_record_init(&made, &record));
}

/* The desk has looked at the ranges; what would be read past an end is refused everywhere. */
static void test_ranges_are_the_desks(void)
{
    actuator.params.adequacy_ratio = EMA_R(2000.0);
    TEST_ASSERT_EQUAL((EMA_TEST_FIXED != 0) ? EMA_OK : EMA_ERR_RANGE, ema_actuator_check(&actuator, NULL));
    setUp();
    TEST_ASSERT_EQUAL(EMA_OK, ema_session_config_default(&config, &actuator, &record));
    config.identified[0].upper = EMA_R(101.0);
    TEST_ASSERT_EQUAL((EMA_TEST_FIXED != 0) ? EMA_OK : EMA_ERR_RANGE, ema_session_init(&session, &config));
    config.identified[0].id = (ema_value_id_t)EMA_VALUE_COUNT;
    TEST_ASSERT_EQUAL(EMA_ERR_RANGE, ema_session_init(&session, &config));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_an_answer_has_the_bits_of_every_build);
    RUN_TEST(test_an_answer_with_an_effect_has_them_too);
    RUN_TEST(test_an_effect_that_is_left_out_is_refused);
    RUN_TEST(test_another_control_law_is_refused);
    RUN_TEST(test_another_drive_is_refused);
    RUN_TEST(test_another_encoder_is_refused);
    RUN_TEST(test_an_effect_that_asks_for_what_is_left_out_is_refused);
    RUN_TEST(test_another_record_is_refused);
    RUN_TEST(test_ranges_are_the_desks);
    return UNITY_END();
}
