/* The whole module through its four calls: answers on its own records, verdicts, slices, copies, and every refusal. The
 * search is the annealer's alone; test_session_stages.c is about both stages. */
#include "ema/ema.h"

#include <math.h>

#include "ema_rig.h"
#include "session/ema_session_search.h"

#define ROWS_MAX 10000U
#define ALL_STEPS UINT32_MAX

static ema_real buffer[ROWS_MAX * 5U];
static ema_actuator_t healthy;
static ema_session_config_t config;
static ema_session_t session;

void setUp(void)
{
    healthy = ema_rig_actuator();
    (void)memset(&session, 0, sizeof session);
    const ema_record_config_t record = ema_rig_real_record(buffer, sizeof buffer, false);
    EMA_ASSERT_STATUS(EMA_OK, ema_session_config_default(&config, &healthy, &record));
    config.search = EMA_SEARCH_ANNEALER;
}

void tearDown(void)
{
}

/* What made the record: the actuator, where it rested, what moved it, and its sensor's noise. */
typedef struct {
    ema_actuator_t actuator;
    ema_real start_mm;
    ema_real shift_mm; /* added to the chirp */
    ema_real end_hz;
    ema_real duration_s;
    ema_real noise_mm;
} truth_t;

static truth_t truth_of(ema_real csj_Nm, ema_real blk_mm)
{
    truth_t truth = {.actuator = ema_rig_actuator(), .end_hz = EMA_R(4.0), .duration_s = EMA_R(10.0)};
    truth.actuator.params.csj_Nm = csj_Nm;
    truth.actuator.params.blk_mm = blk_mm;
    return truth;
}

/* A second of chirp: enough rows, and soon done in slices of one step. */
static truth_t short_truth(ema_real csj_Nm, ema_real blk_mm)
{
    truth_t truth = truth_of(csj_Nm, blk_mm);
    truth.end_hz = EMA_R(3.0);
    truth.duration_s = EMA_R(1.0);
    return truth;
}

static void feed(const truth_t* truth)
{
    const ema_real step_s = truth->actuator.params.step_s;
    const uint32_t every = (uint32_t)truth->actuator.options.record_every_steps;
    const uint32_t rows = (uint32_t)((truth->duration_s / (step_s * (ema_real)every)) + EMA_R(0.5));
    const ema_command_t chirp = ema_rig_chirp(truth->end_hz, truth->duration_s, step_s);
    ema_model_t model = ema_rig_model(&truth->actuator, truth->start_mm);
    ema_random_t noise;
    ema_random_init(&noise, UINT64_C(2024), UINT64_C(3));
    for (uint32_t row = 0; row < rows; ++row) {
        const ema_real command_mm = truth->shift_mm + ema_command_at(&chirp, row * every);
        const ema_output_t first = ema_rig_step(&model, command_mm);
        const ema_real read_mm = first.position_mm + (truth->noise_mm * ema_random_normal(&noise));
        const ema_sample_t sample = {command_mm, {read_mm, first.motor_position_mm, first.current_A, first.voltage_V}};
        EMA_ASSERT_STATUS(EMA_OK, ema_session_feed(&session, &sample));
        if (every > 1U) {
            (void)ema_rig_hold(&model, command_mm, every - 1U);
        }
    }
}

static void init_and_feed(const truth_t* truth)
{
    EMA_ASSERT_STATUS(EMA_OK, ema_session_init(&session, &config));
    feed(truth);
}

/* Runs to the end in slices; how many calls it took. */
static uint64_t run_in_slices(ema_session_t* any, uint32_t steps)
{
    uint64_t slices = 0U;
    while (ema_session_phase(any) != EMA_PHASE_DONE) {
        EMA_ASSERT_STATUS(EMA_OK, ema_session_run(any, steps));
        ++slices;
    }
    return slices;
}

static ema_result_t result_of(const ema_session_t* any)
{
    ema_result_t result;
    (void)memset(&result, 0, sizeof result);
    EMA_ASSERT_STATUS(EMA_OK, ema_session_result(any, &result));
    return result;
}

static ema_result_t identify(const truth_t* truth)
{
    init_and_feed(truth);
    (void)run_in_slices(&session, ALL_STEPS);
    return result_of(&session);
}

/* Sum over the record's rows of the squared position error of `actuator`, in mm^2 s. */
static double direct_cost(const ema_actuator_t* actuator, ema_real start_mm)
{
    ema_model_t model = ema_rig_model(actuator, start_mm);
    const uint32_t every = (uint32_t)actuator->options.record_every_steps;
    double sum = 0.0;
    for (uint32_t row = 0; row < session.record.count; ++row) {
        ema_sample_t sample;
        EMA_ASSERT_STATUS(EMA_OK, ema_record_read(&session.record, row, every, &sample));
        const ema_output_t output = ema_rig_step(&model, sample.command_mm);
        const double error = (double)sample.channel[EMA_CHANNEL_POSITION] - (double)output.position_mm;
        sum += error * error;
        if (every > 1U) {
            (void)ema_rig_hold(&model, sample.command_mm, every - 1U);
        }
    }
    return sum * (double)actuator->params.step_s * (double)every;
}

/* Error of an estimate in % of the healthy value. */
static double error_percent(const ema_estimate_t* estimate, ema_real truth, ema_real nominal)
{
    return (fabs((double)estimate->estimate - (double)truth) / (double)nominal) * 100.0;
}

static void assert_found(const ema_result_t* result, const truth_t* truth, double allowed_percent)
{
    const ema_params_t* const found = &truth->actuator.params;
    TEST_ASSERT_TRUE(error_percent(&result->identified[0], found->csj_Nm, healthy.params.csj_Nm) <= allowed_percent);
    TEST_ASSERT_TRUE(error_percent(&result->identified[1], found->blk_mm, healthy.params.blk_mm) <= allowed_percent);
}

/* The three cases of the paper, from the healthy start and from the four corners, well inside the budget. */
static void find_from_everywhere(ema_real csj_Nm, ema_real blk_mm)
{
    const truth_t truth = truth_of(csj_Nm, blk_mm);
    for (uint32_t start = 0; start < 5U; ++start) {
        for (uint64_t seed = 1; seed <= 2U; ++seed) {
            config.annealer.seed = seed;
            config.start_at_healthy = start == 4U;
            config.annealer.start[0] = (ema_real)(start & 1U);
            config.annealer.start[1] = (ema_real)((start >> 1U) & 1U);
            const ema_result_t result = identify(&truth);
            assert_found(&result, &truth, 0.01);
            TEST_ASSERT_TRUE(result.evaluations <= 400U);
            TEST_ASSERT_EQUAL_INT(EMA_OUTCOME_TOLERANCE, result.outcome);
            TEST_ASSERT_TRUE(result.adequate);
            TEST_ASSERT_TRUE(result.objective_after < (result.objective_before * EMA_R(1.0e-4)));
            TEST_ASSERT_EQUAL_UINT32(result.search.evaluations + (config.start_at_healthy ? 3U : 4U),
                                     result.evaluations);
        }
    }
}

static void test_case_a_is_found_from_every_start(void)
{
    find_from_everywhere(EMA_R(0.3), EMA_R(0.04125));
}

static void test_case_b_is_found_from_every_start(void)
{
    find_from_everywhere(EMA_R(0.1449), EMA_R(0.066));
}

static void test_case_c_is_found_from_every_start(void)
{
    find_from_everywhere(EMA_R(0.13938), EMA_R(0.03333));
}

static void test_result_says_what_was_found_in_its_units(void)
{
    const truth_t truth = truth_of(EMA_R(0.3), EMA_R(0.04125));
    const ema_result_t result = identify(&truth);
    TEST_ASSERT_EQUAL_UINT32(2U, result.identified_count);
    EMA_ASSERT_CLOSE(117.391, result.identified[0].shift_percent, 0.02, 0.0);
    EMA_ASSERT_CLOSE(25.0, result.identified[1].shift_percent, 0.02, 0.0);
    TEST_ASSERT_FALSE(result.identified[0].at_bound);
    TEST_ASSERT_FALSE(result.identified[1].at_bound);
    EMA_ASSERT_CLOSE(direct_cost(&healthy, EMA_R(0.0)), result.objective_before, 0.0, 20.0 * EMA_EPS);
    ema_actuator_t best = healthy;
    best.params.csj_Nm = result.identified[0].estimate;
    best.params.blk_mm = result.identified[1].estimate;
    EMA_ASSERT_CLOSE(direct_cost(&best, EMA_R(0.0)), result.objective_after, 1.0e-12, 1.0e-3);
    EMA_ASSERT_CLOSE(sqrt(direct_cost(&best, EMA_R(0.0)) / 10.0), result.residual_rms_mm, 1.0e-9, 1.0e-3);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_FAULT, result.verdict);
    TEST_ASSERT_EQUAL_HEX32(0U, result.reasons);
    EMA_ASSERT_SAME_BITS(&session.annealer.info, &result.search, sizeof result.search);
    EMA_ASSERT_SAME_BITS(&session.annealer.random, &result.random, sizeof result.random);
}

static void test_noisy_fault_is_called_with_honest_errors(void)
{
    truth_t truth = truth_of(EMA_R(0.3), EMA_R(0.04125));
    truth.noise_mm = healthy.params.position_noise_mm;
    const ema_result_t result = identify(&truth);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_FAULT, result.verdict);
    TEST_ASSERT_TRUE(result.adequate);
    EMA_ASSERT_CLOSE(truth.noise_mm, result.residual_rms_mm, 0.0, 0.03);
    EMA_ASSERT_CLOSE(0.0, result.residual_correlation, 0.04, 0.0);
    /* the scatter that the project's own noise trials and the published figures agree on, within a factor of two */
    const double csj_percent = ((double)result.identified[0].std / 0.138) * 100.0;
    const double blk_percent = ((double)result.identified[1].std / 0.033) * 100.0;
    TEST_ASSERT_TRUE((csj_percent > 0.015) && (csj_percent < 0.08));
    TEST_ASSERT_TRUE((blk_percent > 0.3) && (blk_percent < 1.6));
    EMA_ASSERT_CLOSE(0.3, result.identified[0].estimate, 4.0 * (double)result.identified[0].std, 0.0);
    EMA_ASSERT_CLOSE(0.04125, result.identified[1].estimate, 4.0 * (double)result.identified[1].std, 0.0);
}

static double half_95_of(const ema_result_t* result, uint32_t place)
{
    ema_real half_95 = EMA_R(-1.0);
    EMA_ASSERT_STATUS(EMA_OK, ema_session_half_95(&config, result, place, &half_95));
    return (double)half_95;
}

/* Half an interval is 1.96 standard deviations of all that is known to move the estimate; scatter is a share of the
 * value, of the healthy one where nothing is worn. Only CSJ and BLK have one. */
static void test_interval_holds_noise_bias_and_scatter(void)
{
    truth_t truth = truth_of(EMA_R(0.3), EMA_R(0.033));
    truth.noise_mm = healthy.params.position_noise_mm;
    ema_result_t result = identify(&truth);
    const double healthy_value[2] = {0.138, 0.033};
    for (uint32_t i = 0; i < 2U; ++i) {
        const ema_estimate_t* const found = &result.identified[i];
        const double known = hypot((double)found->std, (double)found->bias);
        EMA_ASSERT_CLOSE(1.96 * known, half_95_of(&result, i), 0.0, 1.0e-5);
    }
    healthy.params.csj_scatter_percent = EMA_R(1.0);
    healthy.params.blk_scatter_percent = EMA_R(2.0);
    EMA_ASSERT_STATUS(EMA_OK, ema_session_result(&session, &result));
    for (uint32_t i = 0; i < 2U; ++i) {
        const ema_estimate_t* const found = &result.identified[i];
        const double known = hypot((double)found->std, (double)found->bias);
        const double scatter = 0.01 * (double)(i + 1U) * fmax((double)found->estimate, healthy_value[i]);
        EMA_ASSERT_CLOSE(1.96 * hypot(known, scatter), half_95_of(&result, i), 0.0, 1.0e-5);
    }
    healthy.params.unseen_percent = EMA_R(300.0);
    for (uint32_t i = 0; i < 2U; ++i) {
        const ema_estimate_t* const found = &result.identified[i];
        const double known = hypot((double)found->std, (double)found->bias);
        const double scatter = 0.01 * (double)(i + 1U) * fmax((double)found->estimate, healthy_value[i]);
        /* three thresholds, of 5 and 10 %, are three standard deviations */
        const double unseen = 0.05 * (double)(i + 1U) * healthy_value[i];
        EMA_ASSERT_CLOSE(1.96 * hypot(hypot(known, scatter), unseen), half_95_of(&result, i), 0.0, 1.0e-5);
    }
    /* one value in doubt takes nothing from what is known of the other */
    ema_result_t doubted = result;
    doubted.reasons = (uint32_t)EMA_REASON_NOT_SENSITIVE;
    TEST_ASSERT_TRUE(half_95_of(&doubted, 0U) == half_95_of(&result, 0U));
    doubted.identified[0].std = EMA_R(0.0);
    EMA_ASSERT_CLOSE(healthy.params.csj_upper_Nm - healthy.params.csj_lower_Nm, half_95_of(&doubted, 0U), 0.0, 1.0e-6);
    config.identified[1].id = EMA_VALUE_ID(resistance_ohm);
    healthy.params.unseen_percent = EMA_R(0.0);
    result.identified[1].scatter_percent = EMA_R(0.0);
    const double other = hypot((double)result.identified[1].std, (double)result.identified[1].bias);
    EMA_ASSERT_CLOSE(1.96 * other, half_95_of(&result, 1U), 0.0, 1.0e-5);
}

static void test_interval_is_refused_of_what_is_not_there(void)
{
    ema_result_t result = {0};
    result.identified_count = 1U;
    ema_real half_95 = EMA_R(-1.0);
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_session_half_95(NULL, &result, 0U, &half_95));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_session_half_95(&config, NULL, 0U, &half_95));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_session_half_95(&config, &result, 0U, NULL));
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_session_half_95(&config, &result, 1U, &half_95));
    result.identified_count = EMA_IDENTIFIED_MAX + 1U;
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_session_half_95(&config, &result, 2U, &half_95));
    config.identified_count = EMA_IDENTIFIED_MAX + 1U;
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_session_half_95(&config, &result, EMA_IDENTIFIED_MAX, &half_95));
    config.actuator = NULL;
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_session_half_95(&config, &result, 0U, &half_95));
    TEST_ASSERT_TRUE(half_95 == EMA_R(-1.0));
}

static void test_noisy_healthy_record_is_called_healthy(void)
{
    truth_t truth = truth_of(EMA_R(0.138), EMA_R(0.033));
    truth.noise_mm = healthy.params.position_noise_mm;
    const ema_result_t result = identify(&truth);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_HEALTHY, result.verdict);
    TEST_ASSERT_EQUAL_HEX32(0U, result.reasons);
}

static void test_scaled_integers_carry_the_same_answer(void)
{
    const truth_t truth = truth_of(EMA_R(0.3), EMA_R(0.04125));
    config.record.format = EMA_RECORD_INT16;
    config.record.command_full_scale_mm = EMA_R(2.5);
    config.record.full_scale[EMA_CHANNEL_POSITION] = EMA_R(2.5);
    const ema_result_t result = identify(&truth);
    assert_found(&result, &truth, 0.2);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_FAULT, result.verdict);
    /* rounding to counts of 2.5 mm / 32767 */
    TEST_ASSERT_TRUE(result.residual_rms_mm > EMA_R(1.0e-5));
    TEST_ASSERT_TRUE(result.residual_rms_mm < EMA_R(1.0e-4));
}

static void test_rows_at_every_fifth_step_carry_the_same_answer(void)
{
    healthy.options.record_every_steps = 5;
    truth_t truth = truth_of(EMA_R(0.3), EMA_R(0.04125));
    truth.actuator.options.record_every_steps = 5;
    const ema_result_t result = identify(&truth);
    TEST_ASSERT_EQUAL_UINT32(2000U, session.record.count);
    assert_found(&result, &truth, 0.01);
}

static void test_command_that_is_a_function_needs_no_recorded_one(void)
{
    const truth_t truth = truth_of(EMA_R(0.3), EMA_R(0.04125));
    const ema_result_t recorded = identify(&truth);
    const ema_command_t chirp = ema_rig_chirp(truth.end_hz, truth.duration_s, truth.actuator.params.step_s);
    config.record.command = &chirp;
    const ema_result_t computed = identify(&truth);
    TEST_ASSERT_EQUAL_UINT32(1U, session.record.stride);
    EMA_ASSERT_SAME_BITS(&recorded, &computed, sizeof recorded);
}

/* Mean speed of the command that was fed. */
static ema_real asked_mm_s(const truth_t* truth)
{
    return session.record.asked_mm / (truth->duration_s - truth->actuator.params.step_s);
}

static void test_rows_that_lie_in_the_buffer_give_the_bits_of_those_that_were_fed(void)
{
    const truth_t truth = short_truth(EMA_R(0.3), EMA_R(0.04125));
    const ema_result_t fed = identify(&truth);
    const uint32_t rows = session.record.count;
    EMA_ASSERT_STATUS(EMA_OK, ema_session_init(&session, &config));
    EMA_ASSERT_STATUS(EMA_OK, ema_session_adopt(&session, rows / 2U));
    EMA_ASSERT_STATUS(EMA_OK, ema_session_adopt(&session, rows - (rows / 2U)));
    (void)run_in_slices(&session, ALL_STEPS);
    const ema_result_t adopted = result_of(&session);
    EMA_ASSERT_SAME_BITS(&fed, &adopted, sizeof fed);
    EMA_ASSERT_STATUS(EMA_ERR_ORDER, ema_session_adopt(&session, 1U));
}

static void test_missed_samples_decide_nothing(void)
{
    const truth_t truth = short_truth(EMA_R(0.3), EMA_R(0.04125));
    const ema_result_t whole = identify(&truth);
    EMA_ASSERT_STATUS(EMA_OK, ema_session_init(&session, &config));
    EMA_ASSERT_STATUS(EMA_OK, ema_session_gap(&session));
    feed(&truth);
    (void)run_in_slices(&session, ALL_STEPS);
    ema_result_t missed = result_of(&session);
    TEST_ASSERT_EQUAL_HEX32(whole.reasons | (uint32_t)EMA_REASON_GAP, missed.reasons);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, missed.verdict);
    /* and it changes nothing else */
    missed.reasons = whole.reasons;
    missed.verdict = whole.verdict;
    EMA_ASSERT_SAME_BITS(&whole, &missed, sizeof whole);
    EMA_ASSERT_STATUS(EMA_ERR_ORDER, ema_session_gap(&session));
    TEST_ASSERT_EQUAL_HEX32(whole.reasons, identify(&truth).reasons);
}

static void test_a_refused_sample_that_is_ignored_decides_nothing(void)
{
    const truth_t truth = short_truth(EMA_R(0.3), EMA_R(0.04125));
    const ema_result_t whole = identify(&truth);
    ema_sample_t refused = {0};
    refused.channel[EMA_CHANNEL_POSITION] = (ema_real)NAN;
    EMA_ASSERT_STATUS(EMA_OK, ema_session_init(&session, &config));
    EMA_ASSERT_STATUS(EMA_ERR_NOT_FINITE, ema_session_feed(&session, &refused));
    feed(&truth);
    (void)run_in_slices(&session, ALL_STEPS);
    const ema_result_t missing = result_of(&session);
    TEST_ASSERT_EQUAL_HEX32(whole.reasons | (uint32_t)EMA_REASON_GAP, missing.reasons);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, missing.verdict);
}

/* The thresholds of a unit hold for its ground test. */
static void test_another_command_than_the_ground_test_decides_nothing(void)
{
    const truth_t truth = truth_of(EMA_R(0.3), EMA_R(0.04125));
    const ema_result_t any = identify(&truth);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_FAULT, any.verdict);
    const ema_real speed_mm_s = asked_mm_s(&truth);
    /* amplitude 2 mm, 0.1 to 4 Hz: four amplitudes a turn, and 20.5 turns */
    EMA_ASSERT_CLOSE((4.0 * 2.0 * 20.5) / 10.0, speed_mm_s, 0.0, 0.01);

    healthy.params.command_speed_mm_s = EMA_R(1.04) * speed_mm_s;
    const ema_result_t same = identify(&truth);
    EMA_ASSERT_SAME_BITS(&any, &same, sizeof any);

    healthy.params.command_speed_mm_s = EMA_R(1.06) * speed_mm_s;
    const ema_result_t slower = identify(&truth);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, slower.verdict);
    TEST_ASSERT_EQUAL_HEX32(EMA_REASON_OTHER_COMMAND, slower.reasons);
    EMA_ASSERT_SAME_BITS(any.identified, slower.identified, sizeof any.identified);
    healthy.params.command_speed_mm_s = EMA_R(0.94) * speed_mm_s;
    TEST_ASSERT_EQUAL_HEX32(EMA_REASON_OTHER_COMMAND, identify(&truth).reasons);

    /* a command that is a function is the firmware's own */
    const ema_command_t chirp = ema_rig_chirp(truth.end_hz, truth.duration_s, truth.actuator.params.step_s);
    config.record.command = &chirp;
    TEST_ASSERT_EQUAL_HEX32(0U, identify(&truth).reasons);
}

/* Counts round every command to a step: the way is that of the steps, and the same but for the turning points. */
static void test_way_of_the_command_does_not_grow_by_its_rounding(void)
{
    const truth_t truth = truth_of(EMA_R(0.3), EMA_R(0.04125));
    init_and_feed(&truth);
    const ema_real exact_mm = session.record.asked_mm;
    config.record.format = EMA_RECORD_INT16;
    config.record.command_full_scale_mm = EMA_R(100.0);
    for (uint32_t channel = 0; channel < (uint32_t)EMA_CHANNEL_COUNT; ++channel) {
        config.record.full_scale[channel] = EMA_R(100.0);
    }
    init_and_feed(&truth);
    /* 41 turning points, each two counts of 3 um off at the most, of 164 mm */
    EMA_ASSERT_CLOSE(exact_mm, session.record.asked_mm, 41.0 * 2.0 * (100.0 / 32767.0), 0.0);
}

static void test_one_parameter_alone_is_found(void)
{
    const truth_t truth = truth_of(EMA_R(0.3), EMA_R(0.033));
    config.identified_count = 1U;
    const ema_result_t result = identify(&truth);
    TEST_ASSERT_EQUAL_UINT32(1U, result.identified_count);
    TEST_ASSERT_TRUE(error_percent(&result.identified[0], EMA_R(0.3), EMA_R(0.138)) <= 0.01);
    TEST_ASSERT_TRUE(result.identified[1].estimate == EMA_R(0.0));
    TEST_ASSERT_EQUAL_UINT32(result.search.evaluations + 2U, result.evaluations);
}

static void test_four_parameters_are_found_with_the_current_weighted(void)
{
    truth_t truth = truth_of(EMA_R(0.2), EMA_R(0.05));
    truth.actuator.params.resistance_ohm = EMA_R(1.2);
    truth.actuator.params.inertia_kgm2 = EMA_R(7.0e-5);
    config.record.keep[EMA_CHANNEL_CURRENT] = true;
    config.weight[EMA_CHANNEL_CURRENT] = EMA_R(1.0e-3);
    config.identified_count = 4U;
    const ema_identified_t resistance = {EMA_VALUE_ID(resistance_ohm), EMA_R(0.7), EMA_R(1.4), EMA_R(5.0)};
    const ema_identified_t inertia = {EMA_VALUE_ID(inertia_kgm2), EMA_R(4.0e-5), EMA_R(9.0e-5), EMA_R(5.0)};
    config.identified[2] = resistance;
    config.identified[3] = inertia;
    config.annealer.evaluation_budget = 1200U;
    config.annealer.cooling = EMA_R(0.95);
    const ema_result_t result = identify(&truth);
    TEST_ASSERT_EQUAL_UINT32(4U, result.identified_count);
    assert_found(&result, &truth, 0.1);
    TEST_ASSERT_TRUE(error_percent(&result.identified[2], EMA_R(1.2), EMA_R(0.99)) <= 0.1);
    TEST_ASSERT_TRUE(error_percent(&result.identified[3], EMA_R(7.0e-5), EMA_R(6.0e-5)) <= 0.1);
}

/* A rod away from zero: the model starts where it rested. */
static void test_start_is_the_command_when_the_rod_agrees_with_it(void)
{
    truth_t truth = short_truth(EMA_R(0.2), EMA_R(0.05));
    truth.start_mm = EMA_R(5.0);
    truth.shift_mm = EMA_R(5.0);
    truth.noise_mm = healthy.params.position_noise_mm;
    init_and_feed(&truth);
    EMA_ASSERT_STATUS(EMA_OK, ema_session_run(&session, 1U));
    TEST_ASSERT_TRUE(ema_session_search_start_mm(&session) == EMA_R(5.0));
}

static void test_start_is_the_rod_when_it_rests_elsewhere(void)
{
    truth_t truth = short_truth(EMA_R(0.2), EMA_R(0.05));
    truth.start_mm = EMA_R(4.0);
    truth.shift_mm = EMA_R(5.0);
    const ema_result_t result = identify(&truth);
    /* the first row is the rod at the end of no step: where it rested */
    EMA_ASSERT_CLOSE(4.0, ema_session_search_start_mm(&session), 1.0e-6, 0.0);
    assert_found(&result, &truth, 0.1);
    EMA_ASSERT_CLOSE(direct_cost(&healthy, ema_session_search_start_mm(&session)), result.objective_before, 0.0,
                     20.0 * EMA_EPS);
}

static void test_result_is_the_same_bits_for_any_slices(void)
{
    const truth_t truth = short_truth(EMA_R(0.25), EMA_R(0.05));
    const ema_result_t whole = identify(&truth);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_FAULT, whole.verdict);
    const uint32_t slices[3] = {1U, 7U, 1000U};
    for (uint32_t k = 0; k < 3U; ++k) {
        init_and_feed(&truth);
        const uint64_t calls = run_in_slices(&session, slices[k]);
        const ema_result_t sliced = result_of(&session);
        EMA_ASSERT_SAME_BITS(&whole, &sliced, sizeof whole);
        /* a slice makes the steps it may, less 64 for each model run that ends in it */
        const uint64_t least = (whole.model_steps + slices[k] - 1U) / slices[k];
        const uint64_t most =
            ((whole.model_steps + (UINT64_C(64) * whole.evaluations)) / slices[k]) + whole.evaluations + 1U;
        TEST_ASSERT_TRUE(calls >= least);
        TEST_ASSERT_TRUE(calls <= most);
    }
}

/* It would be asked for without end. */
static void test_slice_of_no_steps_is_refused_and_changes_nothing(void)
{
    const truth_t truth = short_truth(EMA_R(0.25), EMA_R(0.05));
    init_and_feed(&truth);
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_session_run(&session, 0U));
    TEST_ASSERT_EQUAL_INT(EMA_PHASE_FEEDING, ema_session_phase(&session));
    EMA_ASSERT_STATUS(EMA_OK, ema_session_run(&session, 1U));
    const uint64_t steps = session.model_steps;
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_session_run(&session, 0U));
    TEST_ASSERT_EQUAL_UINT64(steps, session.model_steps);
    TEST_ASSERT_EQUAL_INT(EMA_PHASE_SEARCHING, ema_session_phase(&session));
}

static void test_giving_runs_up_changes_no_decision(void)
{
    const truth_t truth = truth_of(EMA_R(0.3), EMA_R(0.04125));
    for (uint64_t seed = 1; seed <= 3U; ++seed) {
        config.annealer.seed = seed;
        config.abandon = true;
        ema_result_t early = identify(&truth);
        ema_annealer_t path = session.annealer;
        config.abandon = false;
        ema_result_t full = identify(&truth);
        TEST_ASSERT_EQUAL_UINT64((uint64_t)full.evaluations * ROWS_MAX, full.model_steps);
        /* runs were given up, or nothing was compared: a tenth of the steps at least */
        TEST_ASSERT_TRUE((early.model_steps * 10U) < (full.model_steps * 9U));
        early.model_steps = full.model_steps;
        EMA_ASSERT_SAME_BITS(&full, &early, sizeof full);
        path.last_cost = session.annealer.last_cost;
        EMA_ASSERT_SAME_BITS(&session.annealer, &path, sizeof path);
    }
}

static void test_giving_runs_up_changes_no_step_of_the_path(void)
{
    static ema_session_t full;
    const truth_t truth = short_truth(EMA_R(0.25), EMA_R(0.05));
    static ema_session_config_t patient;
    patient = config;
    patient.abandon = false;
    init_and_feed(&truth);
    full = session;
    full.config = &patient;
    uint32_t compared = 0U;
    while (ema_session_phase(&session) != EMA_PHASE_DONE) {
        const uint32_t before = session.evaluations;
        while ((session.evaluations == before) && (ema_session_phase(&session) != EMA_PHASE_DONE)) {
            EMA_ASSERT_STATUS(EMA_OK, ema_session_run(&session, 1U));
        }
        while ((full.evaluations == before) && (ema_session_phase(&full) != EMA_PHASE_DONE)) {
            EMA_ASSERT_STATUS(EMA_OK, ema_session_run(&full, 1U));
        }
        EMA_ASSERT_SAME_BITS(full.annealer.candidate.x, session.annealer.candidate.x, sizeof full.annealer.candidate.x);
        EMA_ASSERT_SAME_BITS(&full.annealer.info, &session.annealer.info, sizeof full.annealer.info);
        ++compared;
    }
    TEST_ASSERT_TRUE(compared > 50U);
}

static void test_copy_at_any_moment_resumes_to_the_same_bits(void)
{
    static ema_session_t copy;
    const truth_t truth = short_truth(EMA_R(0.25), EMA_R(0.05));
    const ema_result_t whole = identify(&truth);
    /* in the first run, in the search, and in the runs after it */
    const uint64_t moments[4] = {1U, 333U, whole.model_steps / 2U, whole.model_steps - 500U};
    for (uint32_t k = 0; k < 4U; ++k) {
        init_and_feed(&truth);
        EMA_ASSERT_STATUS(EMA_OK, ema_session_run(&session, (uint32_t)moments[k]));
        copy = session;
        /* the original goes on differently, then is lost */
        EMA_ASSERT_STATUS(EMA_OK, ema_session_run(&session, 123U));
        (void)memset(&session, 0xA5, sizeof session);
        (void)run_in_slices(&copy, 100U);
        const ema_result_t resumed = result_of(&copy);
        EMA_ASSERT_SAME_BITS(&whole, &resumed, sizeof whole);
    }
}

static void test_same_session_twice_gives_the_same_bits_and_another_seed_does_not(void)
{
    const truth_t truth = short_truth(EMA_R(0.25), EMA_R(0.05));
    const ema_result_t first = identify(&truth);
    const ema_result_t second = identify(&truth);
    EMA_ASSERT_SAME_BITS(&first, &second, sizeof first);
    config.annealer.seed = 77U;
    const ema_result_t other = identify(&truth);
    TEST_ASSERT_FALSE(first.random.state == other.random.state);
    assert_found(&other, &truth, 0.1);
}

static void test_phases_follow_each_other(void)
{
    const truth_t truth = short_truth(EMA_R(0.25), EMA_R(0.05));
    ema_phase_t last = EMA_PHASE_FEEDING;
    uint32_t seen = 1U << (uint32_t)EMA_PHASE_FEEDING;
    init_and_feed(&truth);
    TEST_ASSERT_EQUAL_INT(EMA_PHASE_FEEDING, ema_session_phase(&session));
    while (last != EMA_PHASE_DONE) {
        EMA_ASSERT_STATUS(EMA_OK, ema_session_run(&session, 100U));
        const ema_phase_t now = ema_session_phase(&session);
        TEST_ASSERT_TRUE(now >= last);
        last = now;
        seen |= 1U << (uint32_t)now;
    }
    TEST_ASSERT_EQUAL_HEX32(0xFU, seen);
}

static void test_running_on_after_the_end_changes_nothing(void)
{
    const truth_t truth = short_truth(EMA_R(0.25), EMA_R(0.05));
    const ema_result_t result = identify(&truth);
    EMA_ASSERT_STATUS(EMA_OK, ema_session_run(&session, ALL_STEPS));
    const ema_result_t again = result_of(&session);
    EMA_ASSERT_SAME_BITS(&result, &again, sizeof result);
}

/* Every reason for which a session does not decide. */

static void test_undecided_while_not_finished(void)
{
    const truth_t truth = short_truth(EMA_R(0.25), EMA_R(0.05));
    init_and_feed(&truth);
    while (ema_session_phase(&session) != EMA_PHASE_DONE) {
        EMA_ASSERT_STATUS(EMA_OK, ema_session_run(&session, 500U));
        const ema_result_t result = result_of(&session);
        if (ema_session_phase(&session) != EMA_PHASE_DONE) {
            TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, result.verdict);
            TEST_ASSERT_EQUAL_HEX32(EMA_REASON_NOT_FINISHED, result.reasons);
            TEST_ASSERT_FALSE(result.adequate);
        } else {
            TEST_ASSERT_EQUAL_HEX32(0U, result.reasons & (uint32_t)EMA_REASON_NOT_FINISHED);
        }
    }
}

static void test_undecided_at_the_upper_bound(void)
{
    truth_t truth = truth_of(EMA_R(0.138), EMA_R(0.3));
    truth.noise_mm = healthy.params.position_noise_mm;
    const ema_result_t result = identify(&truth);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, result.verdict);
    TEST_ASSERT_TRUE(result.identified[1].at_bound);
    TEST_ASSERT_FALSE(result.identified[0].at_bound);
    TEST_ASSERT_BITS_HIGH(EMA_REASON_AT_BOUND, result.reasons);
}

static void test_undecided_at_the_lower_bound(void)
{
    healthy.params.csj_lower_Nm = EMA_R(0.12);
    const ema_record_config_t record = config.record;
    EMA_ASSERT_STATUS(EMA_OK, ema_session_config_default(&config, &healthy, &record));
    config.search = EMA_SEARCH_ANNEALER;
    const truth_t truth = truth_of(EMA_R(0.1), EMA_R(0.033));
    const ema_result_t result = identify(&truth);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, result.verdict);
    TEST_ASSERT_TRUE(result.identified[0].at_bound);
    TEST_ASSERT_BITS_HIGH(EMA_REASON_AT_BOUND, result.reasons);
}

static void test_undecided_when_the_model_lacks_something(void)
{
    truth_t truth = truth_of(EMA_R(0.138), EMA_R(0.033));
    truth.actuator.params.resistance_ohm *= EMA_R(1.3);
    truth.noise_mm = healthy.params.position_noise_mm;
    const ema_result_t result = identify(&truth);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, result.verdict);
    TEST_ASSERT_FALSE(result.adequate);
    TEST_ASSERT_BITS_HIGH(EMA_REASON_INADEQUATE, result.reasons);
    /* the warm winding reads as a false fault: that is what the verdict holds back */
    TEST_ASSERT_TRUE(result.identified[0].shift_percent > EMA_R(5.0));
}

static void test_undecided_near_the_threshold(void)
{
    truth_t truth = truth_of(EMA_R(0.138) * EMA_R(1.05), EMA_R(0.033));
    truth.noise_mm = healthy.params.position_noise_mm;
    const ema_result_t result = identify(&truth);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, result.verdict);
    TEST_ASSERT_EQUAL_HEX32(EMA_REASON_NEAR_THRESHOLD, result.reasons);
    TEST_ASSERT_TRUE(result.adequate);
}

static void test_undecided_when_the_evaluations_are_used_up(void)
{
    const truth_t truth = truth_of(EMA_R(0.3), EMA_R(0.04125));
    config.annealer.evaluation_budget = 12U;
    const ema_result_t result = identify(&truth);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, result.verdict);
    TEST_ASSERT_EQUAL_INT(EMA_OUTCOME_BUDGET, result.outcome);
    TEST_ASSERT_BITS_HIGH(EMA_REASON_NOT_CONVERGED, result.reasons);
    TEST_ASSERT_EQUAL_UINT32(12U, result.search.evaluations);
}

static void test_undecided_when_nothing_moved(void)
{
    const ema_sample_t still = {0};
    EMA_ASSERT_STATUS(EMA_OK, ema_session_init(&session, &config));
    for (uint32_t row = 0; row < 200U; ++row) {
        EMA_ASSERT_STATUS(EMA_OK, ema_session_feed(&session, &still));
    }
    (void)run_in_slices(&session, ALL_STEPS);
    const ema_result_t result = result_of(&session);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, result.verdict);
    TEST_ASSERT_BITS_HIGH(EMA_REASON_NOT_SENSITIVE, result.reasons);
    TEST_ASSERT_TRUE(result.identified[0].std == EMA_R(0.0));
    /* nothing is known but the bounds of the search */
    EMA_ASSERT_CLOSE(healthy.params.csj_upper_Nm - healthy.params.csj_lower_Nm, half_95_of(&result, 0U), 0.0, 1.0e-6);
}

static void test_undecided_below_healthy(void)
{
    const truth_t truth = truth_of(EMA_R(0.1), EMA_R(0.033));
    const ema_result_t result = identify(&truth);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, result.verdict);
    TEST_ASSERT_EQUAL_HEX32(EMA_REASON_BELOW_HEALTHY, result.reasons);
    assert_found(&result, &truth, 0.01);
}

/* A rod that was only ever pushed one way does not show where the play ends, however exactly it shows the friction. */
static void test_undecided_when_the_rod_was_pushed_one_way(void)
{
    config.identified_count = 1U;
    EMA_ASSERT_STATUS(EMA_OK, ema_session_init(&session, &config));
    ema_actuator_t truth = healthy;
    truth.params.csj_Nm = EMA_R(0.2);
    ema_model_t model = ema_rig_model(&truth, EMA_R(0.0));
    for (uint32_t row = 0; row < 400U; ++row) {
        const ema_real command_mm = EMA_R(0.01) * (ema_real)row;
        const ema_output_t output = ema_rig_step(&model, command_mm);
        const ema_sample_t sample = {command_mm, {output.position_mm}};
        EMA_ASSERT_STATUS(EMA_OK, ema_session_feed(&session, &sample));
    }
    (void)run_in_slices(&session, ALL_STEPS);
    const ema_result_t result = result_of(&session);
    EMA_ASSERT_CLOSE(0.2, result.identified[0].estimate, 2.0e-4, 0.0);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, result.verdict);
    TEST_ASSERT_BITS_HIGH(EMA_REASON_NOT_SENSITIVE, result.reasons);
}

/* An estimate beside which no model can be made, since its time constant is too far below the step, is told without
 * standard errors.
 */
static void test_undecided_beside_what_makes_no_model(void)
{
    healthy.params.inductance_H = EMA_R(9.44e-6);
    healthy.params.resistance_ohm = EMA_R(1.0);
    const truth_t truth = {.actuator = healthy, .end_hz = EMA_R(3.0), .duration_s = EMA_R(0.2)};
    config.identified_count = 1U;
    config.identified[0].id = EMA_VALUE_ID(resistance_ohm);
    config.identified[0].lower = EMA_R(0.9);
    config.identified[0].upper = EMA_R(2.0);
    config.start_at_healthy = true;
    config.annealer.evaluation_budget = 20U;
    const ema_result_t result = identify(&truth);
    TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, result.verdict);
    TEST_ASSERT_BITS_HIGH(EMA_REASON_NOT_SENSITIVE, result.reasons);
    EMA_ASSERT_CLOSE(1.0, result.identified[0].estimate, 0.01, 0.0);
    TEST_ASSERT_TRUE(result.identified[0].std == EMA_R(0.0));
    TEST_ASSERT_TRUE(result.residual_rms_mm == EMA_R(0.0));
}

/* Standard errors at the upper bound of the search come from a step inwards. */
static void test_estimate_at_its_upper_bound_still_has_an_error(void)
{
    truth_t truth = truth_of(EMA_R(0.138), EMA_R(0.1));
    truth.noise_mm = healthy.params.position_noise_mm;
    const ema_result_t result = identify(&truth);
    TEST_ASSERT_TRUE(result.identified[1].estimate > EMA_R(0.0985));
    TEST_ASSERT_TRUE(result.identified[1].std > EMA_R(0.0));
    TEST_ASSERT_EQUAL_HEX32(0U, result.reasons & (uint32_t)EMA_REASON_NOT_SENSITIVE);
}

/* Refusals. */

static void test_default_configuration_is_the_search_table(void)
{
    TEST_ASSERT_EQUAL_UINT32(2U, config.identified_count);
    TEST_ASSERT_EQUAL_UINT16(EMA_VALUE_ID(csj_Nm), config.identified[0].id);
    TEST_ASSERT_EQUAL_UINT16(EMA_VALUE_ID(blk_mm), config.identified[1].id);
    TEST_ASSERT_TRUE(config.identified[0].lower == healthy.params.csj_lower_Nm);
    TEST_ASSERT_TRUE(config.identified[0].upper == healthy.params.csj_upper_Nm);
    TEST_ASSERT_TRUE(config.identified[1].lower == healthy.params.blk_lower_mm);
    TEST_ASSERT_TRUE(config.identified[1].upper == healthy.params.blk_upper_mm);
    TEST_ASSERT_TRUE(config.identified[0].min_shift_percent == healthy.params.csj_min_shift_percent);
    TEST_ASSERT_TRUE(config.identified[1].min_shift_percent == healthy.params.blk_min_shift_percent);
    TEST_ASSERT_TRUE(config.weight[EMA_CHANNEL_POSITION] == EMA_R(1.0));
    TEST_ASSERT_TRUE(config.weight[EMA_CHANNEL_CURRENT] == EMA_R(0.0));
    TEST_ASSERT_EQUAL_UINT32(400U, config.annealer.evaluation_budget);
    TEST_ASSERT_TRUE(config.start_at_healthy);
    TEST_ASSERT_TRUE(config.abandon);
    TEST_ASSERT_EQUAL_PTR(&healthy, config.actuator);
}

static void test_default_configuration_needs_its_pointers(void)
{
    const ema_record_config_t record = config.record;
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_session_config_default(NULL, &healthy, &record));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_session_config_default(&config, NULL, &record));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_session_config_default(&config, &healthy, NULL));
}

static void test_calls_need_their_pointers(void)
{
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_session_adopt(NULL, 1U));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_session_gap(NULL));
    const ema_sample_t sample = {0};
    ema_result_t result;
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_session_init(NULL, &config));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_session_init(&session, NULL));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_session_feed(NULL, &sample));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_session_feed(&session, NULL));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_session_run(NULL, 1U));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_session_result(NULL, &result));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_session_result(&session, NULL));
    config.actuator = NULL;
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_session_init(&session, &config));
    config.actuator = &healthy;
    config.record.buffer = NULL;
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_session_init(&session, &config));
}

/* Init must answer `expected` and leave the session as it was. */
static void assert_refused(ema_status_t expected, unsigned line)
{
    static ema_session_t before;
    (void)memset(&session, 0x5A, sizeof session);
    before = session;
    ema_assert_status(expected, ema_session_init(&session, &config), line);
    ema_assert_same_bits(&before, &session, sizeof before, line);
}

#define ASSERT_REFUSED(expected) assert_refused((expected), (unsigned)__LINE__)

static void test_init_refuses_an_actuator_outside_its_ranges(void)
{
    healthy.params.lead_mm = EMA_R(-1.0);
    ASSERT_REFUSED(EMA_ERR_RANGE);
    healthy.params.lead_mm = (ema_real)NAN;
    ASSERT_REFUSED(EMA_ERR_NOT_FINITE);
}

static void test_init_refuses_a_wrong_number_of_parameters(void)
{
    config.identified_count = 0U;
    ASSERT_REFUSED(EMA_ERR_RANGE);
    config.identified_count = EMA_IDENTIFIED_MAX + 1U;
    ASSERT_REFUSED(EMA_ERR_RANGE);
}

static void test_init_refuses_bounds_that_are_no_interval(void)
{
    const ema_identified_t csj = config.identified[0];
    config.identified[0].lower = csj.upper;
    ASSERT_REFUSED(EMA_ERR_BOUNDS);
    config.identified[0].lower = csj.upper + EMA_R(1.0);
    ASSERT_REFUSED(EMA_ERR_BOUNDS);
    config.identified[0].lower = (ema_real)NAN;
    ASSERT_REFUSED(EMA_ERR_BOUNDS);
    config.identified[0] = csj;
    config.identified[0].upper = (ema_real)NAN;
    ASSERT_REFUSED(EMA_ERR_BOUNDS);
}

static void test_init_refuses_an_unknown_parameter(void)
{
    config.identified[1].id = (ema_value_id_t)EMA_VALUE_COUNT;
    ASSERT_REFUSED(EMA_ERR_RANGE);
}

static void test_init_refuses_a_healthy_value_outside_the_bounds(void)
{
    config.identified[0].lower = EMA_R(0.14);
    ASSERT_REFUSED(EMA_ERR_RANGE);
    config.identified[0].lower = EMA_R(0.01);
    config.identified[0].upper = EMA_R(0.13);
    ASSERT_REFUSED(EMA_ERR_RANGE);
}

static void test_init_refuses_a_healthy_value_of_zero(void)
{
    healthy.params.blk_mm = EMA_R(0.0);
    ASSERT_REFUSED(EMA_ERR_RANGE);
}

static void test_init_refuses_a_threshold_that_is_none(void)
{
    config.identified[0].min_shift_percent = EMA_R(-1.0);
    ASSERT_REFUSED(EMA_ERR_RANGE);
    config.identified[0].min_shift_percent = (ema_real)NAN;
    ASSERT_REFUSED(EMA_ERR_RANGE);
}

static void test_init_refuses_a_search_outside_what_the_model_takes(void)
{
    config.identified[0].upper = EMA_R(100.5);
    ASSERT_REFUSED(EMA_ERR_RANGE);
    config.identified[0].upper = (ema_real)INFINITY;
    ASSERT_REFUSED(EMA_ERR_RANGE);
    config.identified[0].upper = EMA_R(1.5);
    config.identified[1].lower = EMA_R(-0.01);
    ASSERT_REFUSED(EMA_ERR_RANGE);
}

static void test_init_refuses_a_bad_record(void)
{
    config.record.buffer_bytes = 1U;
    ASSERT_REFUSED(EMA_ERR_RANGE);
}

static void test_init_refuses_a_bad_annealer(void)
{
    config.annealer.cooling = EMA_R(1.0);
    ASSERT_REFUSED(EMA_ERR_RANGE);
}

static void test_feeding_is_refused_once_the_search_runs(void)
{
    const truth_t truth = short_truth(EMA_R(0.25), EMA_R(0.05));
    const ema_sample_t sample = {0};
    init_and_feed(&truth);
    EMA_ASSERT_STATUS(EMA_OK, ema_session_run(&session, 1U));
    const uint32_t rows = session.record.count;
    EMA_ASSERT_STATUS(EMA_ERR_ORDER, ema_session_feed(&session, &sample));
    TEST_ASSERT_EQUAL_UINT32(rows, session.record.count);
    (void)run_in_slices(&session, ALL_STEPS);
    EMA_ASSERT_STATUS(EMA_ERR_ORDER, ema_session_feed(&session, &sample));
}

static void test_feeding_passes_the_records_refusals_on(void)
{
    ema_sample_t sample = {0};
    config.record.buffer_bytes = EMA_RECORD_REAL_BYTES(3, 2);
    EMA_ASSERT_STATUS(EMA_OK, ema_session_init(&session, &config));
    sample.channel[EMA_CHANNEL_POSITION] = (ema_real)NAN;
    EMA_ASSERT_STATUS(EMA_ERR_NOT_FINITE, ema_session_feed(&session, &sample));
    sample.channel[EMA_CHANNEL_POSITION] = EMA_R(0.0);
    for (uint32_t row = 0; row < 3U; ++row) {
        EMA_ASSERT_STATUS(EMA_OK, ema_session_feed(&session, &sample));
    }
    EMA_ASSERT_STATUS(EMA_ERR_FULL, ema_session_feed(&session, &sample));
}

static void test_a_row_too_many_is_no_gap(void)
{
    const ema_sample_t sample = {0};
    config.record.buffer_bytes = EMA_RECORD_REAL_BYTES(1, 2);
    EMA_ASSERT_STATUS(EMA_OK, ema_session_init(&session, &config));
    EMA_ASSERT_STATUS(EMA_OK, ema_session_feed(&session, &sample));
    EMA_ASSERT_STATUS(EMA_ERR_FULL, ema_session_feed(&session, &sample));
    TEST_ASSERT_FALSE(session.gap);
}

static void test_no_result_before_the_first_run(void)
{
    ema_result_t result;
    (void)memset(&result, 0x5A, sizeof result);
    const ema_result_t before = result;
    const truth_t truth = short_truth(EMA_R(0.25), EMA_R(0.05));
    init_and_feed(&truth);
    EMA_ASSERT_STATUS(EMA_ERR_ORDER, ema_session_result(&session, &result));
    EMA_ASSERT_SAME_BITS(&before, &result, sizeof before);
}

static void test_too_short_a_record_is_refused_and_may_be_fed_on(void)
{
    const ema_sample_t sample = {0};
    EMA_ASSERT_STATUS(EMA_OK, ema_session_init(&session, &config));
    EMA_ASSERT_STATUS(EMA_ERR_SHORT, ema_session_run(&session, 1U));
    for (uint32_t row = 0; row < (EMA_ROWS_MIN - 1U); ++row) {
        EMA_ASSERT_STATUS(EMA_OK, ema_session_feed(&session, &sample));
    }
    EMA_ASSERT_STATUS(EMA_ERR_SHORT, ema_session_run(&session, 1U));
    TEST_ASSERT_EQUAL_INT(EMA_PHASE_FEEDING, ema_session_phase(&session));
    EMA_ASSERT_STATUS(EMA_OK, ema_session_feed(&session, &sample));
    EMA_ASSERT_STATUS(EMA_OK, ema_session_run(&session, 1U));
    TEST_ASSERT_EQUAL_INT(EMA_PHASE_SEARCHING, ema_session_phase(&session));
}

static void test_init_refuses_weights_that_weigh_nothing_or_what_is_not_recorded(void)
{
    config.weight[EMA_CHANNEL_VOLTAGE] = EMA_R(1.0);
    ASSERT_REFUSED(EMA_ERR_RANGE);
    config.weight[EMA_CHANNEL_VOLTAGE] = EMA_R(-1.0);
    ASSERT_REFUSED(EMA_ERR_RANGE);
    config.weight[EMA_CHANNEL_VOLTAGE] = (ema_real)NAN;
    ASSERT_REFUSED(EMA_ERR_RANGE);
    config.weight[EMA_CHANNEL_VOLTAGE] = EMA_R(0.0);
    config.weight[EMA_CHANNEL_POSITION] = EMA_R(0.0);
    ASSERT_REFUSED(EMA_ERR_RANGE);
    config.weight[EMA_CHANNEL_POSITION] = (ema_real)INFINITY;
    ASSERT_REFUSED(EMA_ERR_RANGE);
}

static void test_init_refuses_the_same_parameter_twice(void)
{
    config.identified[1] = config.identified[0];
    ASSERT_REFUSED(EMA_ERR_RANGE);
}

static void test_init_refuses_an_unknown_format_of_the_record(void)
{
    config.record.format = (ema_record_format_t)7;
    ASSERT_REFUSED(EMA_ERR_RANGE);
}

static void test_another_number_of_parameters_between_slices_is_refused(void)
{
    const truth_t truth = short_truth(EMA_R(0.25), EMA_R(0.05));
    ema_result_t result;
    init_and_feed(&truth);
    EMA_ASSERT_STATUS(EMA_OK, ema_session_run(&session, 1U));
    const uint32_t count = config.identified_count;
    config.identified_count = EMA_IDENTIFIED_MAX + 1U;
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_session_run(&session, 1U));
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_session_result(&session, &result));
    config.identified_count = count;
    EMA_ASSERT_STATUS(EMA_OK, ema_session_run(&session, 1U));
    EMA_ASSERT_STATUS(EMA_OK, ema_session_result(&session, &result));
}

/* Against the contract, so the answer is worth nothing: undecided, and nothing is read or written past an array. */
static void test_other_parameters_or_weights_between_slices_decide_nothing(void)
{
    const truth_t truth = short_truth(EMA_R(0.25), EMA_R(0.05));
    for (uint32_t what = 0; what < 2U; ++what) {
        setUp();
        init_and_feed(&truth);
        EMA_ASSERT_STATUS(EMA_OK, ema_session_run(&session, 1U));
        if (what == 0U) {
            config.identified[0].id = UINT16_MAX;
            config.identified[1].id = (ema_value_id_t)EMA_VALUE_COUNT;
        } else {
            config.weight[EMA_CHANNEL_POSITION] = EMA_R(0.0);
        }
        ema_result_t result;
        (void)run_in_slices(&session, 1000U);
        EMA_ASSERT_STATUS(EMA_OK, ema_session_result(&session, &result));
        TEST_ASSERT_EQUAL_INT(EMA_VERDICT_UNDECIDED, result.verdict);
        TEST_ASSERT_BITS_HIGH(EMA_REASON_NOT_SENSITIVE, result.reasons);
    }
}

static void test_a_session_that_was_never_started_is_out_of_order(void)
{
    const ema_sample_t sample = {0};
    ema_result_t result;
    (void)memset(&session, 0, sizeof session);
    EMA_ASSERT_STATUS(EMA_ERR_ORDER, ema_session_feed(&session, &sample));
    EMA_ASSERT_STATUS(EMA_ERR_ORDER, ema_session_run(&session, 1U));
    EMA_ASSERT_STATUS(EMA_ERR_ORDER, ema_session_result(&session, &result));
    EMA_ASSERT_STATUS(EMA_ERR_ORDER, ema_session_adopt(&session, 1U));
    EMA_ASSERT_STATUS(EMA_ERR_ORDER, ema_session_gap(&session));
}

static void test_no_session_has_the_phase_of_one_that_was_not_fed(void)
{
    TEST_ASSERT_EQUAL_INT(EMA_PHASE_FEEDING, ema_session_phase(NULL));
}

static void test_first_run_refuses_a_rod_outside_the_travel(void)
{
    const ema_sample_t outside = {EMA_R(30.0), {EMA_R(30.0)}};
    EMA_ASSERT_STATUS(EMA_OK, ema_session_init(&session, &config));
    for (uint32_t row = 0; row < EMA_ROWS_MIN; ++row) {
        EMA_ASSERT_STATUS(EMA_OK, ema_session_feed(&session, &outside));
    }
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_session_run(&session, 1U));
}

static void test_session_writes_inside_itself_alone(void)
{
    static EMA_GUARDED(ema_session_t) box;
    const truth_t truth = short_truth(EMA_R(0.25), EMA_R(0.05));
    EMA_GUARD_SET(box);
    EMA_ASSERT_STATUS(EMA_OK, ema_session_init(&box.value, &config));
    init_and_feed(&truth);
    for (uint32_t row = 0; row < session.record.count; ++row) {
        ema_sample_t sample;
        EMA_ASSERT_STATUS(EMA_OK, ema_record_read(&session.record, row, 1U, &sample));
        EMA_ASSERT_STATUS(EMA_OK, ema_session_feed(&box.value, &sample));
    }
    (void)run_in_slices(&box.value, ALL_STEPS);
    EMA_ASSERT_GUARDS(box);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_case_a_is_found_from_every_start);
    RUN_TEST(test_case_b_is_found_from_every_start);
    RUN_TEST(test_case_c_is_found_from_every_start);
    RUN_TEST(test_result_says_what_was_found_in_its_units);
    RUN_TEST(test_noisy_fault_is_called_with_honest_errors);
    RUN_TEST(test_interval_holds_noise_bias_and_scatter);
    RUN_TEST(test_interval_is_refused_of_what_is_not_there);
    RUN_TEST(test_noisy_healthy_record_is_called_healthy);
    RUN_TEST(test_scaled_integers_carry_the_same_answer);
    RUN_TEST(test_rows_at_every_fifth_step_carry_the_same_answer);
    RUN_TEST(test_command_that_is_a_function_needs_no_recorded_one);
    RUN_TEST(test_rows_that_lie_in_the_buffer_give_the_bits_of_those_that_were_fed);
    RUN_TEST(test_missed_samples_decide_nothing);
    RUN_TEST(test_a_refused_sample_that_is_ignored_decides_nothing);
    RUN_TEST(test_another_command_than_the_ground_test_decides_nothing);
    RUN_TEST(test_way_of_the_command_does_not_grow_by_its_rounding);
    RUN_TEST(test_one_parameter_alone_is_found);
    RUN_TEST(test_four_parameters_are_found_with_the_current_weighted);
    RUN_TEST(test_start_is_the_command_when_the_rod_agrees_with_it);
    RUN_TEST(test_start_is_the_rod_when_it_rests_elsewhere);
    RUN_TEST(test_result_is_the_same_bits_for_any_slices);
    RUN_TEST(test_slice_of_no_steps_is_refused_and_changes_nothing);
    RUN_TEST(test_giving_runs_up_changes_no_decision);
    RUN_TEST(test_giving_runs_up_changes_no_step_of_the_path);
    RUN_TEST(test_copy_at_any_moment_resumes_to_the_same_bits);
    RUN_TEST(test_same_session_twice_gives_the_same_bits_and_another_seed_does_not);
    RUN_TEST(test_phases_follow_each_other);
    RUN_TEST(test_running_on_after_the_end_changes_nothing);
    RUN_TEST(test_undecided_while_not_finished);
    RUN_TEST(test_undecided_at_the_upper_bound);
    RUN_TEST(test_undecided_at_the_lower_bound);
    RUN_TEST(test_undecided_when_the_model_lacks_something);
    RUN_TEST(test_undecided_near_the_threshold);
    RUN_TEST(test_undecided_when_the_evaluations_are_used_up);
    RUN_TEST(test_undecided_when_nothing_moved);
    RUN_TEST(test_undecided_when_the_rod_was_pushed_one_way);
    RUN_TEST(test_undecided_beside_what_makes_no_model);
    RUN_TEST(test_undecided_below_healthy);
    RUN_TEST(test_estimate_at_its_upper_bound_still_has_an_error);
    RUN_TEST(test_default_configuration_is_the_search_table);
    RUN_TEST(test_default_configuration_needs_its_pointers);
    RUN_TEST(test_calls_need_their_pointers);
    RUN_TEST(test_init_refuses_an_actuator_outside_its_ranges);
    RUN_TEST(test_init_refuses_a_wrong_number_of_parameters);
    RUN_TEST(test_init_refuses_bounds_that_are_no_interval);
    RUN_TEST(test_init_refuses_an_unknown_parameter);
    RUN_TEST(test_init_refuses_a_healthy_value_outside_the_bounds);
    RUN_TEST(test_init_refuses_a_healthy_value_of_zero);
    RUN_TEST(test_init_refuses_a_threshold_that_is_none);
    RUN_TEST(test_init_refuses_a_search_outside_what_the_model_takes);
    RUN_TEST(test_init_refuses_a_bad_record);
    RUN_TEST(test_init_refuses_a_bad_annealer);
    RUN_TEST(test_feeding_is_refused_once_the_search_runs);
    RUN_TEST(test_feeding_passes_the_records_refusals_on);
    RUN_TEST(test_a_row_too_many_is_no_gap);
    RUN_TEST(test_no_result_before_the_first_run);
    RUN_TEST(test_too_short_a_record_is_refused_and_may_be_fed_on);
    RUN_TEST(test_init_refuses_weights_that_weigh_nothing_or_what_is_not_recorded);
    RUN_TEST(test_init_refuses_the_same_parameter_twice);
    RUN_TEST(test_init_refuses_an_unknown_format_of_the_record);
    RUN_TEST(test_another_number_of_parameters_between_slices_is_refused);
    RUN_TEST(test_other_parameters_or_weights_between_slices_decide_nothing);
    RUN_TEST(test_a_session_that_was_never_started_is_out_of_order);
    RUN_TEST(test_no_session_has_the_phase_of_one_that_was_not_fed);
    RUN_TEST(test_first_run_refuses_a_rod_outside_the_travel);
    RUN_TEST(test_session_writes_inside_itself_alone);
    return UNITY_END();
}
