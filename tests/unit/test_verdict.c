/* The verdict as a table: what estimates, residual and outcome mean, on both sides of every limit. */
#include "session/ema_verdict.h"

#include <math.h>

#include "ema_rig.h"
#include "session/ema_temperature_correction.h"

static ema_actuator_t healthy;
static ema_session_config_t config;

/* Thresholds of 5 % (CSJ) and 10 % (BLK), three standard errors of confidence, 5 um of noise. */
void setUp(void)
{
    static ema_real buffer[4];
    healthy = ema_rig_actuator();
    healthy.params.csj_min_shift_percent = EMA_R(5.0);
    healthy.params.blk_min_shift_percent = EMA_R(10.0);
    healthy.params.confidence_std = EMA_R(3.0);
    healthy.params.position_noise_mm = EMA_R(0.005);
    healthy.params.adequacy_ratio = EMA_R(2.0);
    healthy.params.structure_ratio = EMA_R(0.3);
    const ema_record_config_t record = ema_rig_real_record(buffer, sizeof buffer, false);
    EMA_ASSERT_STATUS(EMA_OK, ema_session_config_default(&config, &healthy, &record));
}

void tearDown(void)
{
}

/* One line of the table. Standard errors are in % of the healthy value. */
typedef struct {
    double csj_percent;
    double csj_std_percent;
    double blk_percent;
    double blk_std_percent;
    double rms_um;
    double correlation;
    ema_verdict_t verdict;
    uint32_t reasons;
} line_t;

static ema_estimate_t estimate_of(ema_real nominal, double shift_percent, double std_percent)
{
    const ema_estimate_t estimate = {.estimate = nominal * (ema_real)(1.0 + (shift_percent / 100.0)),
                                     .std = nominal * (ema_real)(std_percent / 100.0),
                                     .shift_percent = (ema_real)shift_percent};
    return estimate;
}

static ema_result_t result_of(const line_t* line)
{
    ema_result_t result = {
        .identified_count = 2U, .outcome = EMA_OUTCOME_TOLERANCE, .reasons = 0xFFFFU, .verdict = EMA_VERDICT_UNDECIDED};
    result.identified[0] = estimate_of(healthy.params.csj_Nm, line->csj_percent, line->csj_std_percent);
    result.identified[1] = estimate_of(healthy.params.blk_mm, line->blk_percent, line->blk_std_percent);
    result.residual_rms_mm = (ema_real)(line->rms_um * 1.0e-3);
    result.residual_correlation = (ema_real)line->correlation;
    return result;
}

static void judge_lines(const line_t* lines, size_t count)
{
    for (size_t k = 0; k < count; ++k) {
        ema_result_t result = result_of(&lines[k]);
        ema_temperature_correction(&config, &result);
        ema_verdict_judge(&config, true, &result);
        TEST_ASSERT_EQUAL_HEX32_MESSAGE(lines[k].reasons, result.reasons, "reasons of a line");
        TEST_ASSERT_EQUAL_INT_MESSAGE(lines[k].verdict, result.verdict, "verdict of a line");
        const bool inadequate = (lines[k].reasons & (uint32_t)EMA_REASON_INADEQUATE) != 0U;
        TEST_ASSERT_TRUE(result.adequate == !inadequate);
    }
}

#define JUDGE(lines) judge_lines((lines), sizeof(lines) / sizeof((lines)[0]))

#define HEALTHY EMA_VERDICT_HEALTHY, 0U
#define FAULT EMA_VERDICT_FAULT, 0U
#define UNDECIDED(reasons) EMA_VERDICT_UNDECIDED, (uint32_t)(reasons)

/* What the ground test does not show, here 2.5 thresholds, withholds both answers. */
static void test_what_is_not_seen_is_doubt(void)
{
    healthy.params.unseen_percent = EMA_R(250.0);
    const line_t lines[] = {
        {0.0, 0.04, 0.0, 0.8, 5.0, 0.0, UNDECIDED(EMA_REASON_NEAR_THRESHOLD)},
        /* CSJ: 5 % and 12.5 % */
        {17.3, 0.04, 0.0, 0.8, 5.0, 0.0, UNDECIDED(EMA_REASON_NEAR_THRESHOLD)},
        {17.7, 0.04, 0.0, 0.8, 5.0, 0.0, FAULT},
        /* BLK: 10 %, 25 % and 3 x 0.8 % */
        {0.0, 0.04, 37.3, 0.8, 5.0, 0.0, UNDECIDED(EMA_REASON_NEAR_THRESHOLD)},
        {0.0, 0.04, 37.5, 0.8, 5.0, 0.0, FAULT},
    };
    JUDGE(lines);
}

static void test_shift_against_its_threshold(void)
{
    const line_t lines[] = {
        {0.0, 0.04, 0.0, 0.8, 5.0, 0.0, HEALTHY},
        /* CSJ: threshold 5 %, doubt 3 x 0.1 % */
        {4.6, 0.1, 0.0, 0.8, 5.0, 0.0, HEALTHY},
        {4.8, 0.1, 0.0, 0.8, 5.0, 0.0, UNDECIDED(EMA_REASON_NEAR_THRESHOLD)},
        {5.2, 0.1, 0.0, 0.8, 5.0, 0.0, UNDECIDED(EMA_REASON_NEAR_THRESHOLD)},
        {5.4, 0.1, 0.0, 0.8, 5.0, 0.0, FAULT},
        /* BLK: threshold 10 %, doubt 3 x 0.8 % */
        {0.0, 0.04, 7.5, 0.8, 5.0, 0.0, HEALTHY},
        {0.0, 0.04, 7.7, 0.8, 5.0, 0.0, UNDECIDED(EMA_REASON_NEAR_THRESHOLD)},
        {0.0, 0.04, 12.3, 0.8, 5.0, 0.0, UNDECIDED(EMA_REASON_NEAR_THRESHOLD)},
        {0.0, 0.04, 12.5, 0.8, 5.0, 0.0, FAULT},
        /* without doubt the threshold itself divides */
        {4.99, 0.0, 0.0, 0.0, 5.0, 0.0, HEALTHY},
        {5.01, 0.0, 0.0, 0.0, 5.0, 0.0, FAULT},
        {117.4, 0.04, 25.0, 0.8, 5.0, 0.0, FAULT},
    };
    JUDGE(lines);
}

/* Where healthy runs of a unit are read 4 % apart, 12 % are within what a sound one shows: neither a fault nor healthy
 * above the threshold of 10 %, and no fall below. */
static void test_what_scatters_more_than_its_threshold_is_undecided_between(void)
{
    healthy.params.csj_min_shift_percent = EMA_R(10.0);
    healthy.params.csj_scatter_percent = EMA_R(4.0);
    EMA_ASSERT_STATUS(EMA_OK, ema_session_config_default(&config, &healthy, &config.record));
    const line_t lines[] = {
        {9.6, 0.1, 0.0, 0.8, 5.0, 0.0, HEALTHY},
        {9.8, 0.1, 0.0, 0.8, 5.0, 0.0, UNDECIDED(EMA_REASON_NEAR_THRESHOLD)},
        {12.2, 0.1, 0.0, 0.8, 5.0, 0.0, UNDECIDED(EMA_REASON_NEAR_THRESHOLD)},
        {12.4, 0.1, 0.0, 0.8, 5.0, 0.0, FAULT},
        {-11.6, 0.1, 0.0, 0.8, 5.0, 0.0, HEALTHY},
        {-11.8, 0.1, 0.0, 0.8, 5.0, 0.0, UNDECIDED(EMA_REASON_NEAR_THRESHOLD)},
        {-12.4, 0.1, 0.0, 0.8, 5.0, 0.0, UNDECIDED(EMA_REASON_BELOW_HEALTHY)},
        /* the play of the same unit scatters less than its threshold, which stays */
        {0.0, 0.1, 12.5, 0.8, 5.0, 0.0, FAULT},
    };
    healthy.params.blk_scatter_percent = EMA_R(1.0);
    JUDGE(lines);
}

/* On a day that leaves friction open by 6 %, a reading below the threshold is surely below three of them; where it
 * leaves open 8 % a reading of +1.9 % is not, and where 9.2 % no reading of a sound unit is. */
static void test_what_may_be_much_more_for_its_scatter_is_not_healthy(void)
{
    healthy.params.csj_min_shift_percent = EMA_R(5.0);
    healthy.params.csj_scatter_percent = EMA_R(6.0);
    EMA_ASSERT_STATUS(EMA_OK, ema_session_config_default(&config, &healthy, &config.record));
    const line_t lines[] = {
        {4.6, 0.1, 0.0, 0.8, 5.0, 0.0, HEALTHY},
        {0.0, 0.1, 0.0, 0.8, 5.0, 0.0, HEALTHY},
    };
    JUDGE(lines);
    healthy.params.csj_scatter_percent = EMA_R(8.0);
    const line_t wider[] = {
        {1.7, 0.1, 0.0, 0.8, 5.0, 0.0, HEALTHY},
        {1.9, 0.1, 0.0, 0.8, 5.0, 0.0, UNDECIDED(EMA_REASON_NEAR_THRESHOLD)},
        {-9.0, 0.1, 0.0, 0.8, 5.0, 0.0, HEALTHY},
    };
    JUDGE(wider);
    healthy.params.csj_scatter_percent = EMA_R(9.2);
    const line_t never[] = {{0.0, 0.1, 0.0, 0.8, 5.0, 0.0, UNDECIDED(EMA_REASON_NEAR_THRESHOLD)}};
    JUDGE(never);
}

static void test_negative_shift_is_no_fault(void)
{
    const line_t lines[] = {
        {-4.6, 0.1, 0.0, 0.8, 5.0, 0.0, HEALTHY},
        {-4.8, 0.1, 0.0, 0.8, 5.0, 0.0, UNDECIDED(EMA_REASON_NEAR_THRESHOLD)},
        {-5.2, 0.1, 0.0, 0.8, 5.0, 0.0, UNDECIDED(EMA_REASON_NEAR_THRESHOLD)},
        {-5.4, 0.1, 0.0, 0.8, 5.0, 0.0, UNDECIDED(EMA_REASON_BELOW_HEALTHY)},
        {0.0, 0.04, -12.5, 0.8, 5.0, 0.0, UNDECIDED(EMA_REASON_BELOW_HEALTHY)},
        /* a fall casts doubt on the fault beside it */
        {30.0, 0.1, -20.0, 0.8, 5.0, 0.0, UNDECIDED(EMA_REASON_BELOW_HEALTHY)},
    };
    JUDGE(lines);
}

static void test_what_is_no_number_is_never_healthy(void)
{
    const double nan = (double)NAN;
    const line_t lines[] = {
        {0.0, nan, 0.0, 0.8, 5.0, 0.0, UNDECIDED(EMA_REASON_NOT_SENSITIVE)},
        {30.0, 0.1, 0.0, nan, 5.0, 0.0, UNDECIDED(EMA_REASON_NOT_SENSITIVE)},
        {nan, 0.1, 0.0, 0.8, 5.0, 0.0, UNDECIDED(EMA_REASON_NEAR_THRESHOLD)},
    };
    JUDGE(lines);
}

static void test_sure_fault_stands_beside_a_neighbours_doubt(void)
{
    const line_t lines[] = {
        {30.0, 0.1, 10.0, 0.8, 5.0, 0.0, FAULT},
        {5.0, 0.1, 40.0, 0.8, 5.0, 0.0, FAULT},
        {5.0, 0.1, 10.0, 0.8, 5.0, 0.0, UNDECIDED(EMA_REASON_NEAR_THRESHOLD)},
    };
    JUDGE(lines);
}

static void test_parameter_that_the_record_does_not_show(void)
{
    const line_t lines[] = {
        /* doubt 3 x 33 % is under, 3 x 34 % over the healthy value itself */
        {0.0, 0.04, 0.0, 33.0, 5.0, 0.0, UNDECIDED(EMA_REASON_NEAR_THRESHOLD)},
        {0.0, 0.04, 0.0, 34.0, 5.0, 0.0, UNDECIDED(EMA_REASON_NOT_SENSITIVE)},
        {0.0, 34.0, 0.0, 0.8, 5.0, 0.0, UNDECIDED(EMA_REASON_NOT_SENSITIVE)},
        {30.0, 0.1, 0.0, 34.0, 5.0, 0.0, UNDECIDED(EMA_REASON_NOT_SENSITIVE)},
    };
    JUDGE(lines);
}

static void test_residual_larger_than_the_noise_explains(void)
{
    const line_t lines[] = {
        {0.0, 0.04, 0.0, 0.8, 9.9, 0.0, HEALTHY}, {0.0, 0.04, 0.0, 0.8, 10.1, 0.0, UNDECIDED(EMA_REASON_INADEQUATE)},
        {30.0, 0.04, 0.0, 0.8, 9.9, 0.0, FAULT},  {30.0, 0.04, 0.0, 0.8, 10.1, 0.0, UNDECIDED(EMA_REASON_INADEQUATE)},
        {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, HEALTHY},
    };
    JUDGE(lines);
}

/* rms * sqrt(correlation) against 0.3 * 5 um = 1.5 um */
static void test_residual_that_neighbours_share(void)
{
    const line_t lines[] = {
        {0.0, 0.04, 0.0, 0.8, 5.0, 0.08, HEALTHY},
        {0.0, 0.04, 0.0, 0.8, 5.0, 0.10, UNDECIDED(EMA_REASON_INADEQUATE)},
        {30.0, 0.04, 0.0, 0.8, 5.0, 0.10, UNDECIDED(EMA_REASON_INADEQUATE)},
        /* small and all shared: no noise at all, only structure */
        {0.0, 0.04, 0.0, 0.8, 1.4, 0.999, HEALTHY},
        {0.0, 0.04, 0.0, 0.8, 1.6, 0.999, UNDECIDED(EMA_REASON_INADEQUATE)},
        /* neighbours that alternate share nothing */
        {0.0, 0.04, 0.0, 0.8, 9.0, -0.5, HEALTHY},
        {0.0, 0.04, 0.0, 0.8, 9.0, -1.0, HEALTHY},
    };
    JUDGE(lines);
}

/* Noise of 5 um rms of which neighbours share 4.5 um: what is beyond it counts, 1.5 um as before. */
static void test_noise_that_neighbours_share_is_no_structure(void)
{
    healthy.params.shared_noise_mm = EMA_R(0.0045);
    const line_t lines[] = {
        {0.0, 0.04, 0.0, 0.8, 5.0, 0.83, HEALTHY},
        {0.0, 0.04, 0.0, 0.8, 5.0, 0.89, HEALTHY},
        {0.0, 0.04, 0.0, 0.8, 5.0, 0.91, UNDECIDED(EMA_REASON_INADEQUATE)},
        {30.0, 0.04, 0.0, 0.8, 5.0, 0.91, UNDECIDED(EMA_REASON_INADEQUATE)},
        {30.0, 0.04, 0.0, 0.8, 5.0, 0.89, FAULT},
    };
    JUDGE(lines);
}

static void test_structure_ratio_moves_its_limit(void)
{
    const line_t strict = {0.0, 0.04, 0.0, 0.8, 5.0, 0.05, UNDECIDED(EMA_REASON_INADEQUATE)};
    const line_t loose = {0.0, 0.04, 0.0, 0.8, 5.0, 0.95, HEALTHY};
    healthy.params.structure_ratio = EMA_R(0.2);
    judge_lines(&strict, 1U);
    healthy.params.structure_ratio = EMA_R(1.0);
    judge_lines(&loose, 1U);
    healthy.params.structure_ratio = EMA_R(0.0);
    judge_lines(&strict, 1U);
    /* at zero, a white residual still passes */
    const line_t white = {0.0, 0.04, 0.0, 0.8, 5.0, 0.0, HEALTHY};
    judge_lines(&white, 1U);
}

static void test_adequacy_ratio_noise_and_confidence_move_their_limits(void)
{
    const line_t large = {0.0, 0.04, 0.0, 0.8, 12.0, 0.0, HEALTHY};
    const line_t small = {0.0, 0.04, 0.0, 0.8, 6.0, 0.0, UNDECIDED(EMA_REASON_INADEQUATE)};
    healthy.params.adequacy_ratio = EMA_R(3.0);
    judge_lines(&large, 1U);
    healthy.params.adequacy_ratio = EMA_R(1.0);
    judge_lines(&small, 1U);
    healthy.params.adequacy_ratio = EMA_R(2.0);
    healthy.params.position_noise_mm = EMA_R(0.0025);
    judge_lines(&small, 1U);
    healthy.params.position_noise_mm = EMA_R(0.01);
    judge_lines(&large, 1U);
    const line_t near_blk = {0.0, 0.04, 12.3, 0.8, 5.0, 0.0, FAULT};
    healthy.params.position_noise_mm = EMA_R(0.005);
    healthy.params.confidence_std = EMA_R(2.0);
    judge_lines(&near_blk, 1U);
}

static void test_residual_that_is_no_number_is_inadequate(void)
{
    const line_t line = {0.0, 0.04, 0.0, 0.8, 5.0, 0.0, HEALTHY};
    ema_result_t result = result_of(&line);
    result.residual_rms_mm = (ema_real)NAN;
    ema_verdict_judge(&config, true, &result);
    TEST_ASSERT_FALSE(result.adequate);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, result.verdict);
    TEST_ASSERT_EQUAL_HEX32(EMA_REASON_INADEQUATE, result.reasons);
}

static void test_estimate_on_a_bound_is_not_believed(void)
{
    for (uint32_t which = 0; which < 2U; ++which) {
        const line_t line = {30.0, 0.1, 0.0, 0.8, 5.0, 0.0, FAULT};
        ema_result_t result = result_of(&line);
        result.identified[which].at_bound = true;
        ema_verdict_judge(&config, true, &result);
        TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, result.verdict);
        TEST_ASSERT_EQUAL_HEX32(EMA_REASON_AT_BOUND, result.reasons);
        TEST_ASSERT_TRUE(result.adequate);
    }
}

static void test_outcome_of_the_search(void)
{
    const ema_outcome_t outcomes[3] = {EMA_OUTCOME_TOLERANCE, EMA_OUTCOME_COUNT, EMA_OUTCOME_BUDGET};
    for (uint32_t k = 0; k < 3U; ++k) {
        const line_t line = {30.0, 0.1, 0.0, 0.8, 5.0, 0.0, FAULT};
        ema_result_t result = result_of(&line);
        result.outcome = outcomes[k];
        ema_verdict_judge(&config, true, &result);
        const bool budget = outcomes[k] == EMA_OUTCOME_BUDGET;
        TEST_ASSERT_EQUAL_INT(budget ? EMA_VERDICT_UNDECIDED : EMA_VERDICT_FAULT, result.verdict);
        TEST_ASSERT_EQUAL_HEX32(budget ? (uint32_t)EMA_REASON_NOT_CONVERGED : 0U, result.reasons);
    }
}

static void test_no_standard_errors_no_verdict(void)
{
    const line_t line = {30.0, 0.0, 0.0, 0.0, 5.0, 0.0, FAULT};
    ema_result_t result = result_of(&line);
    ema_verdict_judge(&config, false, &result);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, result.verdict);
    TEST_ASSERT_EQUAL_HEX32(EMA_REASON_NOT_SENSITIVE, result.reasons);
}

static void test_reasons_add_up(void)
{
    const line_t line = {5.0, 0.1, -20.0, 0.8, 50.0, 0.9, FAULT};
    ema_result_t result = result_of(&line);
    result.outcome = EMA_OUTCOME_BUDGET;
    result.identified[0].at_bound = true;
    ema_verdict_judge(&config, false, &result);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, result.verdict);
    TEST_ASSERT_EQUAL_HEX32(EMA_REASON_INADEQUATE | EMA_REASON_AT_BOUND | EMA_REASON_NOT_CONVERGED
                                | EMA_REASON_NEAR_THRESHOLD | EMA_REASON_NOT_SENSITIVE | EMA_REASON_BELOW_HEALTHY,
                            result.reasons);
}

static void test_only_the_identified_parameters_count(void)
{
    const line_t line = {0.0, 0.04, 90.0, 0.8, 5.0, 0.0, HEALTHY};
    ema_result_t result = result_of(&line);
    config.identified_count = 1U;
    ema_verdict_judge(&config, true, &result);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_HEALTHY, result.verdict);
}

/* Bias stands beside the standard errors where a shift is held against its threshold, and does not make a parameter
 * undetermined. */
static void test_bias_widens_the_doubt(void)
{
    line_t line = {0.0, 0.04, 8.5, 0.1, 5.0, 0.0, HEALTHY};
    ema_result_t result = result_of(&line);
    ema_verdict_judge(&config, true, &result);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_HEALTHY, result.verdict);
    result.identified[1].bias = healthy.params.blk_mm * EMA_R(0.02);
    ema_verdict_judge(&config, true, &result);
    TEST_ASSERT_EQUAL_HEX32(EMA_REASON_NEAR_THRESHOLD, result.reasons);
    line.blk_percent = 12.85;
    result = result_of(&line);
    ema_verdict_judge(&config, true, &result);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_FAULT, result.verdict);
    result.identified[1].bias = healthy.params.blk_mm * EMA_R(0.03);
    ema_verdict_judge(&config, true, &result);
    TEST_ASSERT_EQUAL_HEX32(EMA_REASON_NEAR_THRESHOLD, result.reasons);
    result.identified[1].bias = healthy.params.blk_mm * EMA_R(5.0);
    ema_verdict_judge(&config, true, &result);
    TEST_ASSERT_EQUAL_HEX32(EMA_REASON_NEAR_THRESHOLD, result.reasons);
    result.identified[1].bias = (ema_real)NAN;
    ema_verdict_judge(&config, true, &result);
    TEST_ASSERT_EQUAL_HEX32(EMA_REASON_NEAR_THRESHOLD, result.reasons);
}

/* A healthy value may be negative: its size counts. */
static void test_negative_healthy_value(void)
{
    healthy.params.load_torque_Nm = EMA_R(-0.05);
    config.identified[0].id = EMA_VALUE_ID(load_torque_Nm);
    line_t line = {30.0, 0.1, 0.0, 0.8, 5.0, 0.0, FAULT};
    ema_result_t result = result_of(&line);
    result.identified[0].std = EMA_R(0.05) * EMA_R(0.34);
    ema_verdict_judge(&config, true, &result);
    TEST_ASSERT_EQUAL_HEX32(EMA_REASON_NOT_SENSITIVE, result.reasons);
    result.identified[0].std = EMA_R(0.05) * EMA_R(0.001);
    ema_verdict_judge(&config, true, &result);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_FAULT, result.verdict);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_shift_against_its_threshold);
    RUN_TEST(test_what_is_not_seen_is_doubt);
    RUN_TEST(test_what_scatters_more_than_its_threshold_is_undecided_between);
    RUN_TEST(test_what_may_be_much_more_for_its_scatter_is_not_healthy);
    RUN_TEST(test_negative_shift_is_no_fault);
    RUN_TEST(test_what_is_no_number_is_never_healthy);
    RUN_TEST(test_sure_fault_stands_beside_a_neighbours_doubt);
    RUN_TEST(test_parameter_that_the_record_does_not_show);
    RUN_TEST(test_residual_larger_than_the_noise_explains);
    RUN_TEST(test_residual_that_neighbours_share);
    RUN_TEST(test_noise_that_neighbours_share_is_no_structure);
    RUN_TEST(test_structure_ratio_moves_its_limit);
    RUN_TEST(test_adequacy_ratio_noise_and_confidence_move_their_limits);
    RUN_TEST(test_residual_that_is_no_number_is_inadequate);
    RUN_TEST(test_estimate_on_a_bound_is_not_believed);
    RUN_TEST(test_outcome_of_the_search);
    RUN_TEST(test_no_standard_errors_no_verdict);
    RUN_TEST(test_reasons_add_up);
    RUN_TEST(test_only_the_identified_parameters_count);
    RUN_TEST(test_bias_widens_the_doubt);
    RUN_TEST(test_negative_healthy_value);
    return UNITY_END();
}
