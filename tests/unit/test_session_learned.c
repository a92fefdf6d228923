/* Learned tables in the session: read from the configuration, the same in any slices, and a verdict that says when one
 * was used outside its range. */
#include <math.h>

#include "ema/ema.h"
#include "ema_rig.h"

#define ROWS 2000U

static ema_real memory[2U * ROWS];
static ema_actuator_t healthy;
static ema_session_config_t config;
static ema_session_t session;

/* Dry friction that repeats with the place on the screw, learned over +-`reach_mm`. */
static void learn(ema_actuator_t* actuator, double reach_mm)
{
    ema_real* const node = &actuator->effects.learned_friction.node_00;
    actuator->effects.learned_friction.gain = EMA_R(1.0);
    actuator->effects.learned_friction.axis = EMA_R(1.0);
    actuator->effects.learned_friction.first = (ema_real)-reach_mm;
    actuator->effects.learned_friction.last = (ema_real)reach_mm;
    for (uint32_t k = 0; k < 16U; ++k) {
        node[k] = (ema_real)(0.03 * (1.0 + sin(0.9 * (double)k)));
    }
}

void setUp(void)
{
    healthy = ema_rig_actuator();
    learn(&healthy, 2.5);
    const ema_record_config_t record = ema_rig_real_record(memory, sizeof memory, false);
    EMA_ASSERT_STATUS(EMA_OK, ema_session_config_default(&config, &healthy, &record));
}

void tearDown(void)
{
}

static void feed(const ema_actuator_t* truth)
{
    const ema_command_t command = ema_rig_chirp(EMA_R(3.0), EMA_R(2.0), EMA_R(1.0e-3));
    ema_model_t model = ema_rig_model(truth, EMA_R(0.0));
    EMA_ASSERT_STATUS(EMA_OK, ema_session_init(&session, &config));
    for (uint32_t row = 0; row < ROWS; ++row) {
        ema_sample_t sample = {.command_mm = ema_command_at(&command, row)};
        sample.channel[EMA_CHANNEL_POSITION] = ema_rig_step(&model, sample.command_mm).position_mm;
        EMA_ASSERT_STATUS(EMA_OK, ema_session_feed(&session, &sample));
    }
}

static void test_a_fault_is_found_behind_a_learned_table(void)
{
    ema_actuator_t worn = healthy;
    worn.params.csj_Nm = EMA_R(0.2);
    worn.params.blk_mm = EMA_R(0.045);
    feed(&worn);
    const ema_result_t result = ema_rig_result(&session, UINT32_MAX);
    EMA_ASSERT_CLOSE(0.2, result.identified[0].estimate, 0.0, 1.0e-3);
    EMA_ASSERT_CLOSE(0.045, result.identified[1].estimate, 0.0, 1.0e-2);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_FAULT, result.verdict);
    TEST_ASSERT_EQUAL_HEX32(0U, result.reasons);
    TEST_ASSERT_TRUE(result.outside_ratio == EMA_R(0.0));
    /* without the table the same record is explained otherwise, or not at all */
    healthy.effects.learned_friction.gain = EMA_R(0.0);
    feed(&worn);
    const ema_result_t without = ema_rig_result(&session, UINT32_MAX);
    TEST_ASSERT_TRUE(fabs((double)without.identified[0].estimate - 0.2) > 0.01);
}

static void test_the_verdict_says_that_a_table_was_left(void)
{
    learn(&healthy, 1.2);
    feed(&healthy);
    const ema_result_t result = ema_rig_result(&session, UINT32_MAX);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, result.verdict);
    TEST_ASSERT_EQUAL_HEX32(EMA_REASON_LEARNED_RANGE, result.reasons);
    TEST_ASSERT_TRUE(result.adequate);
    TEST_ASSERT_TRUE(result.outside_ratio == session.sensitivity.state[0].outside_ratio);
    TEST_ASSERT_TRUE(result.outside_ratio > EMA_R(0.1));
}

static void test_less_than_half_a_distance_between_nodes_is_not_outside(void)
{
    learn(&healthy, 1.2);
    feed(&healthy);
    double farthest_mm = 0.0;
    for (uint32_t row = 0; row < ROWS; ++row) {
        ema_sample_t sample;
        EMA_ASSERT_STATUS(EMA_OK, ema_record_read(&session.record, row, 1U, &sample));
        farthest_mm = fmax(farthest_mm, fabs((double)sample.channel[EMA_CHANNEL_POSITION]));
    }
    learn(&healthy, farthest_mm * 0.98);
    feed(&healthy);
    const ema_result_t result = ema_rig_result(&session, UINT32_MAX);
    TEST_ASSERT_TRUE(result.outside_ratio > EMA_R(0.0));
    TEST_ASSERT_EQUAL_HEX32(0U, result.reasons);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_HEALTHY, result.verdict);
}

static void test_slices_and_copies_change_nothing(void)
{
    static ema_session_t copy;
    ema_actuator_t worn = healthy;
    worn.params.csj_Nm = EMA_R(0.18);
    feed(&worn);
    const ema_result_t whole = ema_rig_result(&session, UINT32_MAX);
    feed(&worn);
    EMA_ASSERT_STATUS(EMA_OK, ema_session_run(&session, 12345U));
    copy = session;
    (void)memset(&session, 0xA5, sizeof session);
    session = copy;
    const ema_result_t sliced = ema_rig_result(&session, 777U);
    EMA_ASSERT_SAME_BITS(&whole, &sliced, sizeof whole);
}

static void test_values_of_tables_are_not_identified(void)
{
    const ema_identified_t gain = {EMA_EFFECT_VALUE_ID(learned_friction, gain), EMA_R(0.5), EMA_R(2.0), EMA_R(10.0)};
    config.identified[1] = gain;
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_session_init(&session, &config));
    setUp();
    feed(&healthy);
    static ema_sensitivity_t sensitivity;
    const ema_value_id_t id = EMA_EFFECT_VALUE_ID(learned_friction, node_03);
    const ema_real delta = EMA_R(1.0e-3);
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_sensitivity_start(&sensitivity, &healthy, &session.record, config.weight, &id,
                                                           &delta, 1U, EMA_R(0.0)));
}

static void test_a_table_that_cannot_be_read_starts_no_session(void)
{
    healthy.effects.learned_friction.last = healthy.effects.learned_friction.first;
    EMA_ASSERT_STATUS(EMA_ERR_BOUNDS, ema_session_init(&session, &config));
}

#if !EMA_REAL64
static void test_the_session_keeps_its_memory(void)
{
    /* with ten seconds of command and rod position as int16 at 1 kHz: 48 KiB */
    TEST_ASSERT_TRUE((sizeof(ema_session_t) + sizeof(ema_session_config_t) + EMA_RECORD_INT16_BYTES(10000U, 2U))
                     <= 49152U);
    TEST_ASSERT_TRUE(sizeof(ema_session_t) <= 9216U);
}
#endif

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_fault_is_found_behind_a_learned_table);
    RUN_TEST(test_the_verdict_says_that_a_table_was_left);
    RUN_TEST(test_less_than_half_a_distance_between_nodes_is_not_outside);
    RUN_TEST(test_slices_and_copies_change_nothing);
    RUN_TEST(test_values_of_tables_are_not_identified);
    RUN_TEST(test_a_table_that_cannot_be_read_starts_no_session);
#if !EMA_REAL64
    RUN_TEST(test_the_session_keeps_its_memory);
#endif
    return UNITY_END();
}
