/* A session behind a table of signatures: without one it is the session, with one it starts nearer, ends at the same
 * place, and objects to what the model lacks. */
#include "ema/ema.h"

#include <math.h>

#include "ema_signature_rig.h"

static ema_real buffer[EMA_TABLE_RECORD_ROWS * 5U];
static ema_signature_rig_t rig;
static ema_actuator_t healthy;
static ema_session_config_t config;
static ema_session_t session;
static ema_guarded_t guarded;

void setUp(void)
{
    healthy = ema_rig_actuator();
    ema_signature_rig(&rig, &healthy);
    const ema_record_config_t record = ema_rig_real_record(buffer, sizeof buffer, true);
    EMA_ASSERT_STATUS(EMA_OK, ema_session_config_default(&config, &healthy, &record));
    config.search = EMA_SEARCH_ANNEALER;
    (void)memset(&guarded, 0xA5, sizeof guarded);
}

void tearDown(void)
{
}

/* Feeds `rows` noisy rows of `truth` to the session, or behind the table. */
static void feed(ema_session_t* plain, const ema_actuator_t* truth, ema_real end_hz, uint32_t rows)
{
    const ema_command_t command = ema_rig_chirp(end_hz, EMA_R(2.0), healthy.params.step_s);
    ema_model_t model = ema_rig_model(truth, EMA_R(0.0));
    ema_random_t noise;
    ema_random_init(&noise, UINT64_C(5), UINT64_C(3));
    for (uint32_t row = 0; row < rows; ++row) {
        const ema_sample_t sample = ema_signature_sample(&model, &command, row, &noise);
        EMA_ASSERT_STATUS(EMA_OK,
                          (plain != NULL) ? ema_session_feed(plain, &sample) : ema_guarded_feed(&guarded, &sample));
    }
}

static ema_result_t plain_result(const ema_actuator_t* truth, ema_real end_hz)
{
    ema_result_t result;
    EMA_ASSERT_STATUS(EMA_OK, ema_session_init(&session, &config));
    feed(&session, truth, end_hz, EMA_TABLE_RECORD_ROWS);
    while (ema_session_phase(&session) != EMA_PHASE_DONE) {
        EMA_ASSERT_STATUS(EMA_OK, ema_session_run(&session, UINT32_MAX));
    }
    (void)memset(&result, 0, sizeof result);
    EMA_ASSERT_STATUS(EMA_OK, ema_session_result(&session, &result));
    return result;
}

static void run(ema_guarded_t* any, uint32_t steps)
{
    while (ema_guarded_phase(any) != EMA_GUARDED_DONE) {
        EMA_ASSERT_STATUS(EMA_OK, ema_guarded_run(any, steps));
    }
}

static ema_result_t guarded_result(const ema_actuator_t* truth, ema_real end_hz, const ema_signatures_t* table,
                                   uint32_t steps, ema_finding_t* finding)
{
    ema_result_t result;
    EMA_ASSERT_STATUS(EMA_OK, ema_guarded_init(&guarded, &config, table));
    feed(NULL, truth, end_hz, EMA_TABLE_RECORD_ROWS);
    run(&guarded, steps);
    (void)memset(&result, 0, sizeof result);
    EMA_ASSERT_STATUS(EMA_OK, ema_guarded_result(&guarded, &result, finding));
    return result;
}

static ema_actuator_t faulty(ema_real csj_Nm, ema_real blk_mm)
{
    ema_actuator_t truth = healthy;
    truth.params.csj_Nm = csj_Nm;
    truth.params.blk_mm = blk_mm;
    return truth;
}

static void without_a_table_it_is_the_session(void)
{
    const ema_actuator_t truth = faulty(EMA_R(0.15), EMA_R(0.05));
    const ema_result_t plain = plain_result(&truth, EMA_R(4.0));
    ema_finding_t finding;
    const ema_result_t behind = guarded_result(&truth, EMA_R(4.0), NULL, 313U, &finding);
    EMA_ASSERT_SAME_BITS(&plain, &behind, sizeof plain);
    TEST_ASSERT_EQUAL_INT(EMA_FINDING_NONE, finding.kind);
}

static void same_answer_in_fewer_runs(void)
{
    const ema_real faults[][2] = {{EMA_R(0.145), EMA_R(0.045)},
                                  {EMA_R(0.2), EMA_R(0.04)},
                                  {EMA_R(0.139), EMA_R(0.0335)},
                                  {EMA_R(0.3), EMA_R(0.033)}};
    for (size_t k = 0; k < (sizeof faults / sizeof faults[0]); ++k) {
        const ema_actuator_t truth = faulty(faults[k][0], faults[k][1]);
        const ema_result_t plain = plain_result(&truth, EMA_R(4.0));
        ema_finding_t finding;
        const ema_result_t behind = guarded_result(&truth, EMA_R(4.0), &rig.table, 1000U, &finding);
        TEST_ASSERT_TRUE((behind.evaluations * 20U) < (plain.evaluations * 19U));
        for (uint32_t i = 0; i < 2U; ++i) {
            EMA_ASSERT_CLOSE((double)plain.identified[i].estimate, (double)behind.identified[i].estimate,
                             0.1 * (double)plain.identified[i].std, 0.0);
        }
        TEST_ASSERT_EQUAL_INT(plain.verdict, behind.verdict);
        TEST_ASSERT_EQUAL_HEX32(plain.reasons, behind.reasons);
        TEST_ASSERT_EQUAL_INT(EMA_FINDING_ADEQUATE, finding.kind);
    }
}

static void slices_do_not_matter(void)
{
    const ema_actuator_t truth = faulty(EMA_R(0.15), EMA_R(0.05));
    ema_finding_t first;
    ema_finding_t other;
    const ema_result_t whole = guarded_result(&truth, EMA_R(4.0), &rig.table, UINT32_MAX, &first);
    const uint32_t slices[] = {1U, 7U, 1999U};
    for (size_t k = 0; k < (sizeof slices / sizeof slices[0]); ++k) {
        const ema_result_t sliced = guarded_result(&truth, EMA_R(4.0), &rig.table, slices[k], &other);
        EMA_ASSERT_SAME_BITS(&whole, &sliced, sizeof whole);
        EMA_ASSERT_SAME_BITS(&first, &other, sizeof first);
    }
}

/* A copy goes on where it was made, in every phase, after its original is gone. */
static void copies_go_on(void)
{
    static ema_guarded_t copy;
    const ema_actuator_t truth = faulty(EMA_R(0.15), EMA_R(0.05));
    ema_finding_t first;
    const ema_result_t whole = guarded_result(&truth, EMA_R(4.0), &rig.table, 500U, &first);
    for (uint32_t phase = (uint32_t)EMA_GUARDED_FEEDING; phase < (uint32_t)EMA_GUARDED_DONE; ++phase) {
        EMA_ASSERT_STATUS(EMA_OK, ema_guarded_init(&guarded, &config, &rig.table));
        feed(NULL, &truth, EMA_R(4.0), EMA_TABLE_RECORD_ROWS);
        while ((uint32_t)ema_guarded_phase(&guarded) < phase) {
            EMA_ASSERT_STATUS(EMA_OK, ema_guarded_run(&guarded, 500U));
        }
        copy = guarded;
        (void)memset(&guarded, 0x5A, sizeof guarded);
        run(&copy, 500U);
        ema_result_t result;
        ema_finding_t finding;
        (void)memset(&result, 0, sizeof result);
        EMA_ASSERT_STATUS(EMA_OK, ema_guarded_result(&copy, &result, &finding));
        EMA_ASSERT_SAME_BITS(&whole, &result, sizeof whole);
        EMA_ASSERT_SAME_BITS(&first, &finding, sizeof first);
    }
}

/* An effect that the rod position hides in CSJ and BLK, so that a session with wide limits calls a fault. */
static void a_missing_effect_takes_the_fault_back(void)
{
    ema_actuator_t truth = faulty(EMA_R(0.16), EMA_R(0.033));
    truth.effects.inertia_change.change = -EMA_R(0.05);
    healthy.params.adequacy_ratio = EMA_R(50.0);
    healthy.params.structure_ratio = EMA_R(50.0);
    rig.table.fingerprint = ema_onboard_fingerprint(&healthy);
    const ema_result_t plain = plain_result(&truth, EMA_R(4.0));
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_FAULT, plain.verdict);
    ema_finding_t finding;
    const ema_result_t behind = guarded_result(&truth, EMA_R(4.0), &rig.table, 1000U, &finding);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, behind.verdict);
    TEST_ASSERT_EQUAL_HEX32(EMA_REASON_EFFECT, behind.reasons);
    TEST_ASSERT_FALSE(behind.adequate);
    TEST_ASSERT_EQUAL_INT(EMA_EFFECT_ID_inertia_change, finding.effect);
    EMA_ASSERT_CLOSE(-0.05, (double)finding.size, 0.01, 0.0);
}

/* Warm grease and a warm winding, on a machine that is worn besides. */
static void the_day_is_searched_behind_the_table_too(void)
{
    healthy.options.day_values = 1;
    healthy.options.evaluation_budget = 800;
    rig.table.fingerprint = ema_onboard_fingerprint(&healthy);
    ema_actuator_t truth = faulty(EMA_R(0.2), EMA_R(0.045));
    truth.params.viscous_Nm_s_per_rad *= EMA_R(0.6);
    truth.params.resistance_ohm *= EMA_R(1.06);
    ema_finding_t finding;
    /* without it the table takes the day for an effect */
    const ema_result_t without = guarded_result(&truth, EMA_R(4.0), &rig.table, 1000U, &finding);
    TEST_ASSERT_NOT_EQUAL(EMA_FINDING_ADEQUATE, finding.kind);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, without.verdict);
    config.annealer.evaluation_budget = 800U;
    EMA_ASSERT_STATUS(EMA_OK, ema_session_config_day(&config));
    const ema_result_t plain = plain_result(&truth, EMA_R(4.0));
    const ema_result_t behind = guarded_result(&truth, EMA_R(4.0), &rig.table, 1000U, &finding);
    TEST_ASSERT_EQUAL_UINT32(4U, behind.identified_count);
    for (uint32_t i = 0; i < 4U; ++i) {
        EMA_ASSERT_CLOSE((double)plain.identified[i].estimate, (double)behind.identified[i].estimate,
                         0.5 * (double)plain.identified[i].std, 0.0);
    }
    TEST_ASSERT_EQUAL_INT(plain.verdict, behind.verdict);
    TEST_ASSERT_EQUAL_HEX32(plain.reasons, behind.reasons);
    TEST_ASSERT_EQUAL_INT(EMA_FINDING_ADEQUATE, finding.kind);
    /* an effect is named all the same, by what grease and winding have left of it: this table is not freed of them */
    truth.effects.inertia_change.change = -EMA_R(0.05);
    const ema_result_t lacking = guarded_result(&truth, EMA_R(4.0), &rig.table, 1000U, &finding);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, lacking.verdict);
    TEST_ASSERT_BITS_HIGH(EMA_REASON_EFFECT, lacking.reasons);
    TEST_ASSERT_EQUAL_INT(EMA_EFFECT_ID_inertia_change, finding.effect);
    TEST_ASSERT_TRUE((finding.size < EMA_R(0.0)) && (finding.size > -EMA_R(0.06)));
}

/* Another command: the search is the session's own, and the verdict is withheld. */
static void another_command(void)
{
    const ema_result_t plain = plain_result(&healthy, EMA_R(3.0));
    ema_finding_t finding;
    const ema_result_t behind = guarded_result(&healthy, EMA_R(3.0), &rig.table, 1000U, &finding);
    TEST_ASSERT_EQUAL_INT(EMA_FINDING_NONE, finding.kind);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, behind.verdict);
    TEST_ASSERT_EQUAL_HEX32(plain.reasons | (uint32_t)EMA_REASON_OTHER_COMMAND, behind.reasons);
    EMA_ASSERT_SAME_BITS(plain.identified, behind.identified, sizeof plain.identified);
    TEST_ASSERT_EQUAL_UINT32(plain.evaluations + 1U, behind.evaluations);
}

static void one_value_alone(void)
{
    const ema_actuator_t truth = faulty(EMA_R(0.138), EMA_R(0.05));
    config.identified[0] = config.identified[1];
    config.identified_count = 1U;
    ema_finding_t finding;
    const ema_result_t behind = guarded_result(&truth, EMA_R(4.0), &rig.table, 1000U, &finding);
    EMA_ASSERT_CLOSE(0.05, (double)behind.identified[0].estimate, 0.002, 0.0);
    TEST_ASSERT_EQUAL_INT(EMA_FINDING_ADEQUATE, finding.kind);
}

/* A table that is no longer what it was when the search began: nothing is said, and no verdict either. */
static void table_that_changes(void)
{
    ema_finding_t finding;
    ema_result_t result;
    EMA_ASSERT_STATUS(EMA_OK, ema_guarded_init(&guarded, &config, &rig.table));
    feed(NULL, &healthy, EMA_R(4.0), EMA_TABLE_RECORD_ROWS);
    while (ema_guarded_phase(&guarded) != EMA_GUARDED_SESSION) {
        EMA_ASSERT_STATUS(EMA_OK, ema_guarded_run(&guarded, 1000U));
    }
    rig.table.version += 1U;
    run(&guarded, 1000U);
    EMA_ASSERT_STATUS(EMA_OK, ema_guarded_result(&guarded, &result, &finding));
    TEST_ASSERT_EQUAL_INT(EMA_FINDING_NONE, finding.kind);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, result.verdict);
    TEST_ASSERT_BITS_HIGH(EMA_REASON_OTHER_COMMAND, result.reasons);
}

/* A rod that begins beyond the ends of travel has no model, beside the table and in the session. */
static void rod_beyond_the_travel(void)
{
    const ema_real far_mm = EMA_R(2.0) * healthy.params.travel_mm;
    const ema_sample_t sample = {far_mm, {far_mm}};
    const ema_signatures_t* const tables[] = {&rig.table, NULL};
    for (size_t k = 0; k < 2U; ++k) {
        EMA_ASSERT_STATUS(EMA_OK, ema_guarded_init(&guarded, &config, tables[k]));
        for (uint32_t row = 0; row < EMA_ROWS_MIN; ++row) {
            EMA_ASSERT_STATUS(EMA_OK, ema_guarded_feed(&guarded, &sample));
        }
        /* no steps are refused before anything is begun */
        EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_guarded_run(&guarded, 0U));
        TEST_ASSERT_EQUAL_INT(EMA_GUARDED_FEEDING, ema_guarded_phase(&guarded));
        EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_guarded_run(&guarded, 10U));
    }
}

static void order_and_refusals(void)
{
    ema_result_t result;
    ema_finding_t finding;
    const ema_sample_t sample = {EMA_R(0.0), {EMA_R(0.0)}};
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_guarded_init(NULL, &config, &rig.table));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_guarded_init(&guarded, NULL, &rig.table));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_guarded_feed(NULL, &sample));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_guarded_run(NULL, 1U));
    static ema_guarded_t never;
    EMA_ASSERT_STATUS(EMA_ERR_ORDER, ema_guarded_run(&never, 1U));
    EMA_ASSERT_STATUS(EMA_OK, ema_guarded_init(&guarded, &config, &rig.table));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_guarded_result(NULL, &result, &finding));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_guarded_result(&guarded, NULL, &finding));
    EMA_ASSERT_STATUS(EMA_ERR_ORDER, ema_guarded_result(&guarded, &result, &finding));
    EMA_ASSERT_STATUS(EMA_ERR_SHORT, ema_guarded_run(&guarded, 1U));
    feed(NULL, &healthy, EMA_R(4.0), EMA_TABLE_RECORD_ROWS);
    EMA_ASSERT_STATUS(EMA_OK, ema_guarded_run(&guarded, 1U));
    TEST_ASSERT_EQUAL_INT(EMA_GUARDED_STARTING, ema_guarded_phase(&guarded));
    EMA_ASSERT_STATUS(EMA_ERR_ORDER, ema_guarded_feed(&guarded, &sample));
    EMA_ASSERT_STATUS(EMA_ERR_ORDER, ema_guarded_result(&guarded, &result, &finding));
    while (ema_guarded_phase(&guarded) != EMA_PHASE_SCREENING) {
        EMA_ASSERT_STATUS(EMA_OK, ema_guarded_run(&guarded, 1000U));
    }
    EMA_ASSERT_STATUS(EMA_OK, ema_guarded_result(&guarded, &result, &finding));
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, result.verdict);
    TEST_ASSERT_EQUAL_HEX32(EMA_REASON_NOT_FINISHED, result.reasons);
    TEST_ASSERT_EQUAL_INT(EMA_FINDING_NONE, finding.kind);
    run(&guarded, 1000U);
    EMA_ASSERT_STATUS(EMA_OK, ema_guarded_run(&guarded, 1000U));
    EMA_ASSERT_STATUS(EMA_OK, ema_guarded_result(&guarded, &result, NULL));
    TEST_ASSERT_EQUAL_HEX32(0U, result.reasons);

    rig.table.fingerprint ^= 1U;
    EMA_ASSERT_STATUS(EMA_ERR_TABLE, ema_guarded_init(&guarded, &config, &rig.table));
    rig.table.fingerprint ^= 1U;
    config.identified[1].id = EMA_VALUE_ID(inertia_kgm2);
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_guarded_init(&guarded, &config, &rig.table));
    config.identified_count = 0U;
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_guarded_init(&guarded, &config, &rig.table));
}

/* A call that is refused changes nothing: what has been fed stays, and feeding may go on, with a table and without. */
static void no_session_has_the_phase_of_one_that_was_not_fed(void)
{
    TEST_ASSERT_EQUAL_INT(EMA_GUARDED_FEEDING, ema_guarded_phase(NULL));
}

static void refused_calls_lose_nothing(void)
{
    static ema_guarded_t before;
    const ema_signatures_t* const tables[2] = {NULL, &rig.table};
    const ema_sample_t sample = {EMA_R(0.0), {EMA_R(0.0)}};
    for (uint32_t k = 0; k < 2U; ++k) {
        EMA_ASSERT_STATUS(EMA_OK, ema_guarded_init(&guarded, &config, tables[k]));
        EMA_ASSERT_STATUS(EMA_OK, ema_guarded_feed(&guarded, &sample));
        EMA_ASSERT_STATUS(EMA_ERR_SHORT, ema_guarded_run(&guarded, 1U));
        TEST_ASSERT_EQUAL_INT(EMA_GUARDED_FEEDING, ema_guarded_phase(&guarded));
        EMA_ASSERT_STATUS(EMA_OK, ema_guarded_feed(&guarded, &sample));
        TEST_ASSERT_EQUAL_UINT32(2U, guarded.session.record.count);
    }
    before = guarded;
    rig.table.fingerprint ^= 1U;
    EMA_ASSERT_STATUS(EMA_ERR_TABLE, ema_guarded_init(&guarded, &config, &rig.table));
    rig.table.fingerprint ^= 1U;
    const ema_session_config_t sound = config;
    config.record.buffer_bytes = 0U;
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_guarded_init(&guarded, &config, &rig.table));
    config = sound;
    config.actuator = NULL;
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_guarded_init(&guarded, &config, &rig.table));
    config = sound;
    EMA_ASSERT_SAME_BITS(&before, &guarded, sizeof before);
}

/* More values than a session takes, all of them in the table. */
static void too_many_values(void)
{
    for (uint32_t i = 0; i < EMA_IDENTIFIED_MAX; ++i) {
        config.identified[i] = config.identified[0];
    }
    config.identified_count = EMA_IDENTIFIED_MAX + 1U;
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_guarded_init(&guarded, &config, &rig.table));
}

/* While the session searches, its result is not finished, and the table has nothing to object yet. */
static void result_while_it_searches(void)
{
    ema_result_t result;
    ema_finding_t finding;
    EMA_ASSERT_STATUS(EMA_OK, ema_guarded_init(&guarded, &config, &rig.table));
    feed(NULL, &healthy, EMA_R(3.0), EMA_TABLE_RECORD_ROWS);
    while (ema_session_phase(&guarded.session) != EMA_PHASE_SEARCHING) {
        EMA_ASSERT_STATUS(EMA_OK, ema_guarded_run(&guarded, 1000U));
    }
    EMA_ASSERT_STATUS(EMA_OK, ema_guarded_result(&guarded, &result, &finding));
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, result.verdict);
    TEST_ASSERT_EQUAL_HEX32(EMA_REASON_NOT_FINISHED, result.reasons);
    TEST_ASSERT_EQUAL_INT(EMA_FINDING_NONE, finding.kind);
    /* the run beside the table is counted */
    TEST_ASSERT_TRUE(result.model_steps >= EMA_TABLE_RECORD_ROWS);
}

/* What a caller must not do between slices: it is told, or it costs the answer, and nothing is written past an array.
 */
static void a_configuration_that_changes_harms_nothing(void)
{
    ema_result_t result;
    EMA_ASSERT_STATUS(EMA_OK, ema_guarded_init(&guarded, &config, &rig.table));
    feed(NULL, &healthy, EMA_R(4.0), EMA_TABLE_RECORD_ROWS);
    EMA_ASSERT_STATUS(EMA_OK, ema_guarded_run(&guarded, 1U));
    const uint32_t count = config.identified_count;
    config.identified_count = 9U;
    while (ema_guarded_run(&guarded, 1000U) == EMA_OK) {
        TEST_ASSERT_EQUAL_INT(EMA_GUARDED_STARTING, ema_guarded_phase(&guarded));
    }
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_guarded_run(&guarded, 1000U));
    TEST_ASSERT_EQUAL_INT(EMA_GUARDED_STARTING, ema_guarded_phase(&guarded));
    config.identified_count = count;
    const ema_value_id_t ids[] = {config.identified[0].id, config.identified[1].id};
    config.identified[0].id = UINT16_MAX;
    while (ema_guarded_phase(&guarded) == EMA_GUARDED_STARTING) {
        EMA_ASSERT_STATUS(EMA_OK, ema_guarded_run(&guarded, 1000U));
    }
    config.identified[1].id = (ema_value_id_t)EMA_VALUE_COUNT;
    run(&guarded, 1000U);
    EMA_ASSERT_STATUS(EMA_OK, ema_guarded_result(&guarded, &result, NULL));
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, result.verdict);
    config.identified[0].id = ids[0];
    config.identified[1].id = ids[1];
    config.identified_count = 9U;
    EMA_ASSERT_STATUS(EMA_OK, ema_guarded_run(&guarded, 1000U)); /* done: nothing is read of it any more */
}

static void running_on_after_the_end_changes_nothing(void)
{
    static ema_guarded_t before;
    ema_result_t result;
    EMA_ASSERT_STATUS(EMA_OK, ema_guarded_init(&guarded, &config, &rig.table));
    feed(NULL, &healthy, EMA_R(4.0), EMA_TABLE_RECORD_ROWS);
    run(&guarded, 1000U);
    (void)memcpy(&before, &guarded, sizeof before);
    EMA_ASSERT_STATUS(EMA_OK, ema_guarded_run(&guarded, 1000U));
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_guarded_run(&guarded, 0U));
    TEST_ASSERT_EQUAL_MEMORY(&before, &guarded, sizeof before);
    EMA_ASSERT_STATUS(EMA_OK, ema_guarded_result(&guarded, &result, NULL));
}

static void test_rows_in_the_buffer_and_missed_ones_are_the_sessions(void)
{
    const ema_actuator_t truth = faulty(EMA_R(0.2), EMA_R(0.0275));
    const ema_result_t fed = guarded_result(&truth, EMA_R(4.0), NULL, UINT32_MAX, NULL);
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_guarded_adopt(NULL, 1U));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_guarded_gap(NULL));
    EMA_ASSERT_STATUS(EMA_ERR_ORDER, ema_guarded_adopt(&guarded, 1U));
    EMA_ASSERT_STATUS(EMA_ERR_ORDER, ema_guarded_gap(&guarded));
    EMA_ASSERT_STATUS(EMA_OK, ema_guarded_init(&guarded, &config, NULL));
    EMA_ASSERT_STATUS(EMA_OK, ema_guarded_adopt(&guarded, EMA_TABLE_RECORD_ROWS));
    EMA_ASSERT_STATUS(EMA_OK, ema_guarded_gap(&guarded));
    run(&guarded, UINT32_MAX);
    ema_result_t result;
    EMA_ASSERT_STATUS(EMA_OK, ema_guarded_result(&guarded, &result, NULL));
    TEST_ASSERT_EQUAL_HEX32(fed.reasons | (uint32_t)EMA_REASON_GAP, result.reasons);
    EMA_ASSERT_SAME_BITS(fed.identified, result.identified, sizeof fed.identified);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(without_a_table_it_is_the_session);
    RUN_TEST(same_answer_in_fewer_runs);
    RUN_TEST(slices_do_not_matter);
    RUN_TEST(copies_go_on);
    RUN_TEST(a_missing_effect_takes_the_fault_back);
    RUN_TEST(the_day_is_searched_behind_the_table_too);
    RUN_TEST(another_command);
    RUN_TEST(one_value_alone);
    RUN_TEST(too_many_values);
    RUN_TEST(table_that_changes);
    RUN_TEST(rod_beyond_the_travel);
    RUN_TEST(order_and_refusals);
    RUN_TEST(refused_calls_lose_nothing);
    RUN_TEST(a_configuration_that_changes_harms_nothing);
    RUN_TEST(running_on_after_the_end_changes_nothing);
    RUN_TEST(no_session_has_the_phase_of_one_that_was_not_fed);
    RUN_TEST(result_while_it_searches);
    RUN_TEST(test_rows_in_the_buffer_and_missed_ones_are_the_sessions);
    return UNITY_END();
}
