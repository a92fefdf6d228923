/* A build that fixes control law, drive, encoder and record: what it holds has the bits of the build that has them all,
 * the rest is refused. The same file is a test of both. */
#include "ema_fingerprint.h"

/* What a build that has everything says; in every other one it is the same. */
#define ANSWER_FINGERPRINT UINT64_C(0x0C183840E167CB05)
#define EFFECT_FINGERPRINT UINT64_C(0x866CFB750CCC1DDD)

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
static int16_t buffer[2U * FINGERPRINT_ROWS];
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

static void test_an_answer_has_the_bits_of_every_build(void)
{
    TEST_ASSERT_EQUAL_HEX64(ANSWER_FINGERPRINT, fingerprint_of_answer(&actuator, &record, EMA_SEARCH_ANNEALER));
}

/* The loop sees the rod here, which no choice forbids. */
static void test_an_answer_with_an_effect_has_them_too(void)
{
#if EMA_TEST_SOME
    actuator.options.side = 1;
    actuator.effects.stribeck_friction.rise = EMA_R(0.3);
    TEST_ASSERT_EQUAL_HEX64(EFFECT_FINGERPRINT, fingerprint_of_answer(&actuator, &record, EMA_SEARCH_ANNEALER));
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
    command = fingerprint_chirp();
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
