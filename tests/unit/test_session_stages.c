/* The search in two stages: least squares from the healthy values, the annealer where that does not settle it. */
#include "ema/ema.h"

#include <math.h>

#include "base/ema_bounds.h"
#include "ema_rig.h"
#include "session/ema_scoring.h"

#define ROWS_MAX 10000U

static ema_real buffer[ROWS_MAX * 2U];
static ema_actuator_t healthy;
static ema_session_config_t config;
static ema_session_t session;

void setUp(void)
{
    healthy = ema_rig_actuator();
    (void)memset(&session, 0, sizeof session);
    const ema_record_config_t record = ema_rig_real_record(buffer, sizeof buffer, false);
    EMA_ASSERT_STATUS(EMA_OK, ema_session_config_default(&config, &healthy, &record));
}

void tearDown(void)
{
}

static ema_actuator_t worn(ema_real csj_Nm, ema_real blk_mm)
{
    ema_actuator_t truth = healthy;
    truth.params.csj_Nm = csj_Nm;
    truth.params.blk_mm = blk_mm;
    return truth;
}

static void init_and_feed(const ema_actuator_t* truth, uint32_t rows, ema_real noise_mm)
{
    const ema_command_t chirp = ema_rig_chirp(EMA_R(4.0), EMA_R(1.0e-3) * (ema_real)rows, truth->params.step_s);
    ema_model_t model = ema_rig_model(truth, EMA_R(0.0));
    ema_random_t noise;
    ema_random_init(&noise, UINT64_C(2024), UINT64_C(3));
    EMA_ASSERT_STATUS(EMA_OK, ema_session_init(&session, &config));
    for (uint32_t row = 0; row < rows; ++row) {
        const ema_real command_mm = ema_command_at(&chirp, row);
        const ema_output_t shown = ema_rig_step(&model, command_mm);
        const ema_sample_t sample = {command_mm, {shown.position_mm + (noise_mm * ema_random_normal(&noise))}};
        EMA_ASSERT_STATUS(EMA_OK, ema_session_feed(&session, &sample));
    }
}

static ema_result_t identify(const ema_actuator_t* truth, ema_real noise_mm)
{
    init_and_feed(truth, ROWS_MAX, noise_mm);
    return ema_rig_result(&session, UINT32_MAX);
}

/* The three cases of the paper from the healthy values, as exactly as by the annealer, in a tenth of its runs. */
static void test_the_paper_cases_are_found_by_least_squares(void)
{
    const ema_real cases[3][2] = {
        {EMA_R(0.3), EMA_R(0.04125)}, {EMA_R(0.1449), EMA_R(0.066)}, {EMA_R(0.13938), EMA_R(0.03333)}};
    for (uint32_t k = 0; k < 3U; ++k) {
        const ema_actuator_t truth = worn(cases[k][0], cases[k][1]);
        const ema_result_t result = identify(&truth, EMA_R(0.0));
        TEST_ASSERT_EQUAL_INT(EMA_STAGE_LEAST_SQUARES, result.stage);
        TEST_ASSERT_EQUAL_INT(EMA_OUTCOME_TOLERANCE, result.outcome);
        TEST_ASSERT_EQUAL_HEX32(0U, result.reasons);
        EMA_ASSERT_CLOSE((double)cases[k][0], (double)result.identified[0].estimate, 1.0e-4 * 0.138, 0.0);
        EMA_ASSERT_CLOSE((double)cases[k][1], (double)result.identified[1].estimate, 1.0e-4 * 0.033, 0.0);
        TEST_ASSERT_TRUE(result.evaluations <= 30U);
        TEST_ASSERT_EQUAL_UINT32(0U, result.search.evaluations);
        TEST_ASSERT_TRUE(result.objective_after < (result.objective_before * EMA_R(1.0e-4)));
    }
}

/* Both searches end at one point: estimates apart by a tenth of their errors, one objective, one verdict. */
static void test_both_searches_end_alike_with_noise(void)
{
    const ema_actuator_t truth = worn(EMA_R(0.165), EMA_R(0.05));
    const ema_result_t both = identify(&truth, healthy.params.position_noise_mm);
    config.search = EMA_SEARCH_ANNEALER;
    const ema_result_t alone = identify(&truth, healthy.params.position_noise_mm);
    TEST_ASSERT_EQUAL_INT(EMA_STAGE_LEAST_SQUARES, both.stage);
    TEST_ASSERT_EQUAL_INT(EMA_STAGE_ANNEALER, alone.stage);
    for (uint32_t i = 0; i < 2U; ++i) {
        const double std = (double)alone.identified[i].std;
        EMA_ASSERT_CLOSE((double)alone.identified[i].estimate, (double)both.identified[i].estimate, 0.1 * std, 0.0);
        EMA_ASSERT_CLOSE(std, (double)both.identified[i].std, 0.0, 0.02);
    }
    EMA_ASSERT_CLOSE((double)alone.objective_before, (double)both.objective_before, 0.0, 1.0e-5);
    EMA_ASSERT_CLOSE((double)alone.objective_after, (double)both.objective_after, 0.0, 1.0e-5);
    TEST_ASSERT_EQUAL_INT(alone.verdict, both.verdict);
    TEST_ASSERT_EQUAL_HEX32(alone.reasons, both.reasons);
}

/* A model that lacks something: a second start ends at the same point, which confirms it. */
static void test_a_doubtful_end_is_confirmed_from_another_start(void)
{
    ema_actuator_t truth = healthy;
    truth.params.resistance_ohm *= EMA_R(1.3);
    const ema_result_t result = identify(&truth, healthy.params.position_noise_mm);
    TEST_ASSERT_TRUE(session.second_start);
    TEST_ASSERT_EQUAL_INT(EMA_STAGE_LEAST_SQUARES, result.stage);
    TEST_ASSERT_FALSE(result.adequate);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, result.verdict);
    TEST_ASSERT_BITS_HIGH(EMA_REASON_INADEQUATE, result.reasons);
}

static void test_an_end_at_a_bound_is_confirmed_from_another_start(void)
{
    const ema_actuator_t truth = worn(EMA_R(0.138), EMA_R(0.105));
    const ema_result_t result = identify(&truth, healthy.params.position_noise_mm);
    TEST_ASSERT_TRUE(session.second_start);
    TEST_ASSERT_EQUAL_INT(EMA_STAGE_LEAST_SQUARES, result.stage);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, result.verdict);
    TEST_ASSERT_TRUE(result.identified[1].at_bound);
    TEST_ASSERT_FALSE(result.identified[0].at_bound);
    TEST_ASSERT_BITS_HIGH(EMA_REASON_AT_BOUND, result.reasons);
}

/* From where nothing moves, the friction being too high, the least squares find no way: the annealer does, and its
 * evaluations and theirs stay inside one budget. */
static void test_the_annealer_goes_on_where_least_squares_do_not(void)
{
    const ema_actuator_t truth = worn(EMA_R(0.2), EMA_R(0.05));
    config.start_at_healthy = false;
    config.annealer.start[0] = EMA_R(1.0);
    config.annealer.start[1] = EMA_R(1.0);
    const ema_result_t result = identify(&truth, healthy.params.position_noise_mm);
    TEST_ASSERT_EQUAL_INT(EMA_STAGE_ANNEALER, result.stage);
    TEST_ASSERT_TRUE(result.search.evaluations > 0U);
    TEST_ASSERT_TRUE(result.evaluations <= (config.annealer.evaluation_budget + 3U));
    TEST_ASSERT_EQUAL_INT(EMA_OUTCOME_TOLERANCE, result.outcome);
    EMA_ASSERT_CLOSE(0.2, (double)result.identified[0].estimate, 0.01 * 0.138, 0.0);
    EMA_ASSERT_CLOSE(0.05, (double)result.identified[1].estimate, 0.02 * 0.033, 0.0);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_FAULT, result.verdict);
}

static void test_the_budget_holds_for_both_stages(void)
{
    const ema_actuator_t truth = worn(EMA_R(0.3), EMA_R(0.04125));
    for (uint32_t budget = 1U; budget < 14U; budget += 3U) {
        config.annealer.evaluation_budget = budget;
        init_and_feed(&truth, 1000U, EMA_R(0.0));
        const ema_result_t result = ema_rig_result(&session, UINT32_MAX);
        /* the assessment comes on top, as with the annealer alone, and the healthy run where it is no candidate */
        TEST_ASSERT_TRUE(result.evaluations <= (budget + 4U));
        TEST_ASSERT_EQUAL_INT(EMA_OUTCOME_BUDGET, result.outcome);
        TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, result.verdict);
        TEST_ASSERT_BITS_HIGH(EMA_REASON_NOT_CONVERGED, result.reasons);
    }
}

/* Of records that either stage answers: the slices do not matter, nor a copy that goes on after its original is gone.
 */
static void test_slices_and_copies_change_no_bit(void)
{
    static ema_session_t copy;
    for (uint32_t which = 0; which < 3U; ++which) {
        ema_actuator_t truth = worn(EMA_R(0.25), EMA_R(0.05));
        setUp();
        if (which == 1U) {
            truth.params.resistance_ohm *= EMA_R(1.3);
        } else if (which == 2U) {
            config.start_at_healthy = false;
            config.annealer.start[0] = EMA_R(1.0);
            config.annealer.evaluation_budget = 40U;
        } else {
            /* found at once */
        }
        init_and_feed(&truth, 1000U, EMA_R(0.0));
        const ema_result_t whole = ema_rig_result(&session, UINT32_MAX);
        const uint32_t slices[4] = {1U, 7U, 250U, 1000U};
        for (uint32_t k = 0; k < 4U; ++k) {
            init_and_feed(&truth, 1000U, EMA_R(0.0));
            for (uint32_t slice = 0; slice < (40U * k); ++slice) {
                EMA_ASSERT_STATUS(EMA_OK, ema_session_run(&session, slices[k]));
            }
            copy = session;
            (void)memset(&session, 0xA5, sizeof session);
            const ema_result_t sliced = ema_rig_result(&copy, slices[k]);
            EMA_ASSERT_SAME_BITS(&whole, &sliced, sizeof whole);
        }
    }
}

static void test_giving_runs_up_changes_no_decision(void)
{
    ema_actuator_t truth = worn(EMA_R(0.25), EMA_R(0.07));
    truth.params.resistance_ohm *= EMA_R(1.1);
    ema_result_t early = identify(&truth, EMA_R(0.0));
    config.abandon = false;
    const ema_result_t full = identify(&truth, EMA_R(0.0));
    TEST_ASSERT_TRUE(early.model_steps <= full.model_steps);
    early.model_steps = full.model_steps;
    EMA_ASSERT_SAME_BITS(&full, &early, sizeof full);
}

/* While it runs the result is undecided and names the stage; the values searched are four at the most. */
static void test_four_values_are_found_and_the_stage_is_named_meanwhile(void)
{
    healthy.options.day_values = 1;
    EMA_ASSERT_STATUS(EMA_OK, ema_session_config_day(&config));
    TEST_ASSERT_EQUAL_UINT32(4U, config.identified_count);
    ema_actuator_t truth = worn(EMA_R(0.138) * EMA_R(1.4), EMA_R(0.066));
    truth.params.viscous_Nm_s_per_rad *= EMA_R(1.6);
    truth.params.resistance_ohm *= EMA_R(0.92);
    init_and_feed(&truth, ROWS_MAX, healthy.params.position_noise_mm);
    EMA_ASSERT_STATUS(EMA_OK, ema_session_run(&session, 1U));
    ema_result_t result;
    EMA_ASSERT_STATUS(EMA_OK, ema_session_result(&session, &result));
    TEST_ASSERT_EQUAL_INT(EMA_STAGE_LEAST_SQUARES, result.stage);
    TEST_ASSERT_EQUAL_HEX32(EMA_REASON_NOT_FINISHED, result.reasons);
    result = ema_rig_result(&session, 5000U);
    TEST_ASSERT_EQUAL_INT(EMA_STAGE_LEAST_SQUARES, result.stage);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_FAULT, result.verdict);
    const double expected_percent[4] = {40.0, 100.0, 60.0, -8.0};
    for (uint32_t i = 0; i < 4U; ++i) {
        const double std_percent =
            100.0 * (double)result.identified[i].std / (double)ema_value_of(&healthy, config.identified[i].id);
        EMA_ASSERT_CLOSE(expected_percent[i], (double)result.identified[i].shift_percent, 4.0 * std_percent, 0.0);
    }
    TEST_ASSERT_TRUE(result.evaluations <= 60U);
}

/* A start that a table has placed: the healthy values are run once for their cost, the descent begins at the place. */
static void test_a_placed_start_is_where_the_descent_begins(void)
{
    const ema_actuator_t truth = worn(EMA_R(0.2), EMA_R(0.05));
    const ema_real value[EMA_IDENTIFIED_MAX] = {EMA_R(0.199), EMA_R(0.0502)};
    init_and_feed(&truth, ROWS_MAX, EMA_R(0.0));
    const ema_result_t healthy_start = ema_rig_result(&session, UINT32_MAX);
    init_and_feed(&truth, ROWS_MAX, EMA_R(0.0));
    ema_session_place_start(&session, value);
    const ema_result_t placed = ema_rig_result(&session, 1000U);
    TEST_ASSERT_TRUE(placed.evaluations < healthy_start.evaluations);
    EMA_ASSERT_CLOSE((double)healthy_start.objective_before, (double)placed.objective_before, 0.0, 1.0e-6);
    EMA_ASSERT_CLOSE(0.2, (double)placed.identified[0].estimate, 2.0e-5, 0.0);
    EMA_ASSERT_CLOSE(0.05, (double)placed.identified[1].estimate, 1.0e-5, 0.0);
}

static void test_first_run_refuses_a_rod_outside_the_travel_and_may_be_repeated(void)
{
    const ema_sample_t outside = {EMA_R(30.0), {EMA_R(30.0)}};
    EMA_ASSERT_STATUS(EMA_OK, ema_session_init(&session, &config));
    for (uint32_t row = 0; row < EMA_ROWS_MIN; ++row) {
        EMA_ASSERT_STATUS(EMA_OK, ema_session_feed(&session, &outside));
    }
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_session_run(&session, 1U));
    TEST_ASSERT_EQUAL_INT(EMA_PHASE_FEEDING, ema_session_phase(&session));
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_session_run(&session, 1U));
}

static void test_undecided_when_nothing_moved(void)
{
    const ema_sample_t still = {0};
    EMA_ASSERT_STATUS(EMA_OK, ema_session_init(&session, &config));
    for (uint32_t row = 0; row < 200U; ++row) {
        EMA_ASSERT_STATUS(EMA_OK, ema_session_feed(&session, &still));
    }
    const ema_result_t result = ema_rig_result(&session, UINT32_MAX);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, result.verdict);
    TEST_ASSERT_BITS_HIGH(EMA_REASON_NOT_SENSITIVE, result.reasons);
}

/* Against the contract, so the answer is worth nothing: undecided, and nothing is read or written past an array. */
static void test_other_values_or_weights_between_slices_decide_nothing(void)
{
    const ema_actuator_t truth = worn(EMA_R(0.25), EMA_R(0.05));
    for (uint32_t what = 0; what < 2U; ++what) {
        setUp();
        init_and_feed(&truth, 1000U, EMA_R(0.0));
        EMA_ASSERT_STATUS(EMA_OK, ema_session_run(&session, 1U));
        if (what == 0U) {
            config.identified[0].id = UINT16_MAX;
            config.identified[1].id = (ema_value_id_t)EMA_VALUE_COUNT;
        } else {
            config.weight[EMA_CHANNEL_POSITION] = EMA_R(0.0);
        }
        const ema_result_t result = ema_rig_result(&session, 1000U);
        TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, result.verdict);
        TEST_ASSERT_BITS_HIGH(EMA_REASON_NOT_SENSITIVE, result.reasons);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_the_paper_cases_are_found_by_least_squares);
    RUN_TEST(test_both_searches_end_alike_with_noise);
    RUN_TEST(test_a_doubtful_end_is_confirmed_from_another_start);
    RUN_TEST(test_an_end_at_a_bound_is_confirmed_from_another_start);
    RUN_TEST(test_the_annealer_goes_on_where_least_squares_do_not);
    RUN_TEST(test_the_budget_holds_for_both_stages);
    RUN_TEST(test_slices_and_copies_change_no_bit);
    RUN_TEST(test_giving_runs_up_changes_no_decision);
    RUN_TEST(test_four_values_are_found_and_the_stage_is_named_meanwhile);
    RUN_TEST(test_a_placed_start_is_where_the_descent_begins);
    RUN_TEST(test_first_run_refuses_a_rod_outside_the_travel_and_may_be_repeated);
    RUN_TEST(test_undecided_when_nothing_moved);
    RUN_TEST(test_other_values_or_weights_between_slices_decide_nothing);
    return UNITY_END();
}
