/* What a guarded session asks of its session: a run beside a table before and after the search, and a placed start. */
#include "session/ema_scoring.h"

#include "ema_signature_rig.h"

static ema_real buffer[EMA_TABLE_RECORD_ROWS * 5U];
static ema_signature_rig_t rig;
static ema_actuator_t healthy;
static ema_session_config_t config;
static ema_session_t session;

void setUp(void)
{
    healthy = ema_rig_actuator();
    ema_signature_rig(&rig, &healthy);
    const ema_record_config_t record = ema_rig_real_record(buffer, sizeof buffer, true);
    EMA_ASSERT_STATUS(EMA_OK, ema_session_config_default(&config, &healthy, &record));
    config.search = EMA_SEARCH_ANNEALER;
    EMA_ASSERT_STATUS(EMA_OK, ema_session_init(&session, &config));
}

void tearDown(void)
{
}

static void feed(ema_real csj_Nm, uint32_t rows)
{
    ema_actuator_t truth = healthy;
    truth.params.csj_Nm = csj_Nm;
    const ema_command_t command = ema_rig_chirp(EMA_R(4.0), EMA_R(2.0), healthy.params.step_s);
    ema_model_t model = ema_rig_model(&truth, EMA_R(0.0));
    ema_random_t noise;
    ema_random_init(&noise, UINT64_C(5), UINT64_C(3));
    for (uint32_t row = 0; row < rows; ++row) {
        const ema_sample_t sample = ema_signature_sample(&model, &command, row, &noise);
        EMA_ASSERT_STATUS(EMA_OK, ema_session_feed(&session, &sample));
    }
}

static ema_finding_t scored(void)
{
    ema_finding_t finding;
    EMA_ASSERT_STATUS(EMA_OK, ema_scoring_start(&session, &rig.table));
    TEST_ASSERT_FALSE(ema_scoring_ended(&session, &finding));
    uint32_t made = 0U;
    while (!ema_scoring_ended(&session, &finding)) {
        made += ema_scoring_run(&session, 300U);
    }
    TEST_ASSERT_EQUAL_UINT32(EMA_TABLE_RECORD_ROWS, made);
    return finding;
}

/* Before the search the residual asks for what has changed; at the best point for nothing. */
static void healthy_before_and_best_point_after(void)
{
    feed(EMA_R(0.15), EMA_TABLE_RECORD_ROWS);
    const ema_finding_t before = scored();
    EMA_ASSERT_CLOSE(0.15 - (double)healthy.params.csj_Nm, (double)before.moved[0], 0.002, 0.0);
    while (ema_session_phase(&session) != EMA_PHASE_DONE) {
        EMA_ASSERT_STATUS(EMA_OK, ema_session_run(&session, UINT32_MAX));
    }
    const ema_finding_t after = scored();
    EMA_ASSERT_CLOSE(0.0, (double)after.moved[0], 0.0005, 0.0);
    TEST_ASSERT_TRUE(after.energy < before.energy);
}

static void refused_while_short_or_running(void)
{
    feed(EMA_R(0.15), EMA_ROWS_MIN - 1U);
    EMA_ASSERT_STATUS(EMA_ERR_SHORT, ema_scoring_start(&session, &rig.table));
    EMA_ASSERT_STATUS(EMA_OK, ema_session_init(&session, &config));
    feed(EMA_R(0.15), EMA_TABLE_RECORD_ROWS);
    EMA_ASSERT_STATUS(EMA_OK, ema_session_run(&session, 1U));
    EMA_ASSERT_STATUS(EMA_ERR_ORDER, ema_scoring_start(&session, &rig.table));
    EMA_ASSERT_STATUS(EMA_OK, ema_session_init(&session, &config));
    feed(EMA_R(0.15), EMA_TABLE_RECORD_ROWS);
    rig.table.version += 1U;
    EMA_ASSERT_STATUS(EMA_ERR_TABLE, ema_scoring_start(&session, &rig.table));
}

/* The first candidate is the place; what lies outside the bounds lies on them. */
static void search_begins_where_it_was_placed(void)
{
    const ema_real middle = EMA_R(0.5) * (config.identified[0].lower + config.identified[0].upper);
    const ema_real value[EMA_IDENTIFIED_MAX] = {middle, config.identified[1].upper + EMA_R(1.0)};
    feed(EMA_R(0.15), EMA_TABLE_RECORD_ROWS);
    ema_session_place_start(&session, value);
    const ema_real* const candidate = ema_annealer_candidate(&session.annealer);
    EMA_ASSERT_CLOSE(0.5, (double)candidate[0], 1e-6, 0.0);
    TEST_ASSERT_TRUE(candidate[1] == EMA_R(1.0));
    TEST_ASSERT_TRUE(session.annealer.temperature == config.annealer.initial_temperature);
    /* the healthy machine is run first, whatever the slices; its cost sets the temperature and is not told */
    while (!session.healthy_done) {
        EMA_ASSERT_STATUS(EMA_OK, ema_session_run(&session, 900U));
    }
    TEST_ASSERT_EQUAL_UINT32(0U, session.annealer.info.evaluations);
    TEST_ASSERT_TRUE(session.annealer.temperature < config.annealer.initial_temperature);
    EMA_ASSERT_CLOSE(0.001 * (double)session.healthy_cost, (double)session.annealer.temperature, 0.0, 1e-6);
    EMA_ASSERT_CLOSE(0.5, (double)session.annealer.candidate.x[0], 1e-6, 0.0);
    while (ema_session_phase(&session) != EMA_PHASE_DONE) {
        EMA_ASSERT_STATUS(EMA_OK, ema_session_run(&session, 900U));
    }
    ema_result_t result;
    EMA_ASSERT_STATUS(EMA_OK, ema_session_result(&session, &result));
    EMA_ASSERT_CLOSE(0.15, (double)result.identified[0].estimate, 0.002, 0.0);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(healthy_before_and_best_point_after);
    RUN_TEST(refused_while_short_or_running);
    RUN_TEST(search_begins_where_it_was_placed);
    return UNITY_END();
}
