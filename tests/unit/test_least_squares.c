/* The search by least squares: it finds what a record was made with, inside its bounds, whatever the slices; it says
 * what the record determines; and it refuses what makes no search. */
#include "ema/ema.h"

#include <math.h>

#include "ema_rig.h"

#define ROWS 2000U
#define EIGHT 8U

static ema_real buffer[ROWS * 5U];
static ema_record_t record;
static ema_actuator_t actuator;
static ema_command_t chirp;
static ema_least_squares_config_t config;
static EMA_GUARDED(ema_least_squares_t) guarded;
static ema_least_squares_t* const search = &guarded.value;

/* Of the estimates of a noisy record: they change with any change of the arithmetic, and then only on purpose. They are
 * the same on every machine and from every compiler. */
#if EMA_REAL64
#define FINGERPRINT UINT64_C(0xA97F959F1BAF7C5A)
#else
#define FINGERPRINT UINT64_C(0x868DC56EF9FA1F38)
#endif

static const ema_real noise[EMA_CHANNEL_COUNT] = {EMA_R(0.005), EMA_R(0.005), EMA_R(0.03), EMA_R(0.03)};

void setUp(void)
{
    const ema_searched_t searched[EIGHT] = {
        {EMA_VALUE_ID(csj_Nm), EMA_VALUE_ID(csj_Nm), EMA_R(0.02), EMA_R(1.0), EMA_R(0.138)},
        {EMA_VALUE_ID(blk_mm), EMA_VALUE_ID(blk_mm), EMA_R(0.0), EMA_R(0.1), EMA_R(0.033)},
        {EMA_VALUE_ID(resistance_ohm), EMA_VALUE_ID(resistance_ohm), EMA_R(0.7), EMA_R(1.4), EMA_R(0.99)},
        {EMA_VALUE_ID(torque_constant_Nm_per_A), EMA_VALUE_ID(back_emf_V_s_per_rad), EMA_R(0.045), EMA_R(0.075),
         EMA_R(0.0612)},
        {EMA_VALUE_ID(kp_per_m), EMA_VALUE_ID(kp_per_m), EMA_R(280.0), EMA_R(520.0), EMA_R(400.0)},
        {EMA_VALUE_ID(load_torque_Nm), EMA_VALUE_ID(load_torque_Nm), EMA_R(-0.1), EMA_R(0.1), EMA_R(0.0)},
        {EMA_VALUE_ID(viscous_Nm_s_per_rad), EMA_VALUE_ID(viscous_Nm_s_per_rad), EMA_R(3.0e-5), EMA_R(3.0e-4),
         EMA_R(1.0e-4)},
        {EMA_VALUE_ID(dynamic_ratio), EMA_VALUE_ID(dynamic_ratio), EMA_R(0.5), EMA_R(1.0), EMA_R(0.95)}};
    actuator = ema_rig_actuator();
    chirp = ema_rig_chirp(EMA_R(4.0), EMA_R(2.0), actuator.params.step_s);
    (void)memset(&config, 0, sizeof config);
    config.actuator = &actuator;
    config.count = EIGHT;
    config.run_budget = 2500U;
    config.restarts = 8U;
    for (uint32_t k = 0; k < EIGHT; ++k) {
        config.searched[k] = searched[k];
    }
    for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
        config.noise[channel] = noise[channel];
    }
    EMA_GUARD_SET(guarded);
}

void tearDown(void)
{
    EMA_ASSERT_GUARDS(guarded);
}

/* Worn as the search is to find it. */
static ema_actuator_t worn_actuator(void)
{
    ema_actuator_t worn = actuator;
    worn.params.csj_Nm = EMA_R(0.2);
    worn.params.blk_mm = EMA_R(0.05);
    worn.params.resistance_ohm = EMA_R(1.1);
    worn.params.torque_constant_Nm_per_A *= EMA_R(0.96);
    worn.params.back_emf_V_s_per_rad *= EMA_R(0.96);
    worn.params.kp_per_m = EMA_R(420.0);
    worn.params.load_torque_Nm = EMA_R(0.01);
    worn.params.viscous_Nm_s_per_rad = EMA_R(1.3e-4);
    worn.params.dynamic_ratio = EMA_R(0.9);
    return worn;
}

static const double truth[EIGHT] = {0.2, 0.05, 1.1, 0.0612 * 0.96, 420.0, 0.01, 1.3e-4, 0.9};

/* `rows` rows of `plant`, all channels with `share` of their noise. */
static void make_record(const ema_actuator_t* plant, uint32_t rows, ema_real share)
{
    const ema_record_config_t kept = ema_rig_real_record(buffer, sizeof buffer, true);
    ema_random_t random;
    ema_random_init(&random, UINT64_C(7), UINT64_C(1));
    ema_rig_record(&record, &kept, plant, &chirp, rows);
    for (uint32_t row = 0; row < rows; ++row) {
        for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
            buffer[(row * 5U) + 1U + channel] += share * noise[channel] * ema_random_normal(&random);
        }
    }
}

static ema_least_squares_result_t run(uint32_t slice)
{
    ema_least_squares_result_t result;
    EMA_ASSERT_STATUS(EMA_OK, ema_least_squares_init(search, &config, &record));
    while (!ema_least_squares_done(search)) {
        EMA_ASSERT_STATUS(EMA_OK, ema_least_squares_run(search, slice));
    }
    (void)memset(&result, 0, sizeof result);
    EMA_ASSERT_STATUS(EMA_OK, ema_least_squares_result(search, &result));
    return result;
}

static void test_eight_values_of_a_noisy_record(void)
{
    const ema_actuator_t worn = worn_actuator();
    make_record(&worn, ROWS, EMA_R(1.0));
    const ema_least_squares_result_t result = run(UINT32_MAX);
    TEST_ASSERT_EQUAL_INT(EMA_OUTCOME_TOLERANCE, result.outcome);
    TEST_ASSERT_TRUE(result.adequate && result.crossed);
    TEST_ASSERT_TRUE(result.misfit_before > EMA_R(10.0));
    EMA_ASSERT_CLOSE(1.0, result.misfit_after, 0.03, 0.0);
    EMA_ASSERT_CLOSE(0.005, result.residual_rms_mm, 2.0e-4, 0.0);
    EMA_ASSERT_CLOSE(0.0, result.residual_correlation, 0.07, 0.0);
    TEST_ASSERT_TRUE(result.runs <= 300U);
    TEST_ASSERT_TRUE(result.model_steps <= ((uint64_t)result.runs * ROWS));
    TEST_ASSERT_EQUAL_UINT32(EIGHT, result.count);
    for (uint32_t k = 0; k < EIGHT; ++k) {
        const ema_found_t* const found = &result.value[k];
        TEST_ASSERT_EQUAL_INT(EMA_DETERMINED, found->determined);
        TEST_ASSERT_FALSE(found->at_bound);
        TEST_ASSERT_TRUE(found->std > EMA_R(0.0));
        EMA_ASSERT_CLOSE(truth[k], found->estimate, 4.0 * ((double)found->std + (double)found->bias), 0.0);
        EMA_ASSERT_CLOSE(found->noise_std, found->std, 0.0, 0.1);
        const double range = (double)config.searched[k].upper - (double)config.searched[k].lower;
        TEST_ASSERT_TRUE((3.92 * (double)found->noise_std) < (0.5 * range));
    }
}

/* Without noise nothing is left but the rounding, and the numbers are those of the record. */
static void test_values_of_an_exact_record(void)
{
    const ema_actuator_t worn = worn_actuator();
    make_record(&worn, ROWS, EMA_R(0.0));
    const ema_least_squares_result_t result = run(1000U);
    TEST_ASSERT_TRUE(result.misfit_after < EMA_R(0.01));
    for (uint32_t k = 0; k < EIGHT; ++k) {
        EMA_ASSERT_CLOSE(truth[k], result.value[k].estimate, 0.1 * (double)result.value[k].noise_std, 0.0);
    }
}

/* What the sensors' noise says of two values, against sums made here in double of the model's own runs. */
static void test_noise_errors_are_those_of_the_sensitivities(void)
{
    static ema_output_t rows[3][ROWS];
    double square[3] = {0.0, 0.0, 0.0};
    config.count = 2U;
    config.run_budget = 3U;
    for (uint32_t k = 0; k < 3U; ++k) {
        const double delta[3] = {0.0, 1.0e-3 * (1.0 - 0.02), 1.0e-3 * 0.1};
        ema_actuator_t beside = actuator;
        beside.params.csj_Nm += (ema_real)((k == 1U) ? delta[1] : 0.0);
        beside.params.blk_mm += (ema_real)((k == 2U) ? delta[2] : 0.0);
        make_record(&beside, ROWS, EMA_R(0.0));
        for (uint32_t row = 0; row < ROWS; ++row) {
            (void)memcpy(&rows[k][row].position_mm, &buffer[(row * 5U) + 1U], 4U * sizeof(ema_real));
        }
    }
    make_record(&actuator, ROWS, EMA_R(1.0));
    for (uint32_t row = 0; row < ROWS; ++row) {
        for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
            double slope[3];
            for (uint32_t k = 0; k < 3U; ++k) {
                slope[k] = ((double)(&rows[k][row].position_mm)[channel] - (double)(&rows[0][row].position_mm)[channel])
                           / (1.0e-3 * (double)noise[channel]);
            }
            square[0] += slope[1] * slope[1];
            square[1] += slope[1] * slope[2];
            square[2] += slope[2] * slope[2];
        }
    }
    const ema_least_squares_result_t result = run(UINT32_MAX);
    const double determinant = (square[0] * square[2]) - (square[1] * square[1]);
    EMA_ASSERT_CLOSE(0.98 * sqrt(square[2] / determinant), result.value[0].noise_std, 0.0,
                     EMA_BY_PRECISION(2.0e-2, 1.0e-6));
    EMA_ASSERT_CLOSE(0.1 * sqrt(square[0] / determinant), result.value[1].noise_std, 0.0,
                     EMA_BY_PRECISION(2.0e-2, 1.0e-6));
    TEST_ASSERT_EQUAL_UINT32(1U, result.value[0].partner);
    TEST_ASSERT_EQUAL_UINT32(0U, result.value[1].partner);
}

static void test_slices_change_no_bit(void)
{
    const uint32_t slices[4] = {1U, 7U, 159U, 1000U};
    const ema_actuator_t worn = worn_actuator();
    config.count = 3U;
    make_record(&worn, 600U, EMA_R(1.0));
    const ema_least_squares_result_t whole = run(UINT32_MAX);
    for (uint32_t k = 0; k < 4U; ++k) {
        const ema_least_squares_result_t sliced = run(slices[k]);
        EMA_ASSERT_SAME_BITS(&whole, &sliced, sizeof whole);
    }
}

/* No slice makes more model steps than it was given; what is not divided is left to the next. */
/* FNV-1a over the bytes of the estimates and their errors. */
static void test_the_same_bits_everywhere(void)
{
    const ema_actuator_t worn = worn_actuator();
    make_record(&worn, 1000U, EMA_R(1.0));
    const ema_least_squares_result_t result = run(1000U);
    uint64_t hash = UINT64_C(14695981039346656037);
    for (uint32_t k = 0; k < EIGHT; ++k) {
        const ema_real numbers[4] = {result.value[k].estimate, result.value[k].std, result.value[k].bias,
                                     result.value[k].noise_std};
        for (size_t place = 0U; place < sizeof numbers; ++place) {
            hash = (hash ^ ((const unsigned char*)numbers)[place]) * UINT64_C(1099511628211);
        }
    }
    TEST_ASSERT_EQUAL_HEX64(FINGERPRINT, hash);
}

/* A value whose truth is its own bound: the descent that begins in its middle finds nothing better. */
static void test_truth_on_a_bound_is_found_and_asked_again(void)
{
    ema_actuator_t worn = worn_actuator();
    worn.params.dynamic_ratio = EMA_R(1.0);
    make_record(&worn, ROWS, EMA_R(1.0));
    const ema_least_squares_result_t result = run(1000U);
    TEST_ASSERT_EQUAL_INT(EMA_OUTCOME_TOLERANCE, result.outcome);
    TEST_ASSERT_TRUE(result.adequate);
    TEST_ASSERT_TRUE(result.starts >= 2U);
    TEST_ASSERT_TRUE(result.runs < 1000U);
    EMA_ASSERT_CLOSE(1.0, result.value[7].estimate, 0.02, 0.0);
    TEST_ASSERT_TRUE(result.value[7].estimate <= EMA_R(1.0));
}

static void test_slice_makes_no_more_steps_than_it_may(void)
{
    const ema_actuator_t worn = worn_actuator();
    config.count = 2U;
    make_record(&worn, 500U, EMA_R(1.0));
    EMA_ASSERT_STATUS(EMA_OK, ema_least_squares_init(search, &config, &record));
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_least_squares_run(search, 0U));
    TEST_ASSERT_EQUAL_INT(EMA_SQUARES_PREPARING, search->phase);
    /* three models, 160 each, and 20 steps */
    EMA_ASSERT_STATUS(EMA_OK, ema_least_squares_run(search, 500U));
    TEST_ASSERT_EQUAL_UINT64(20U, search->model_steps);
    while (!ema_least_squares_done(search)) {
        const uint64_t before = search->model_steps;
        EMA_ASSERT_STATUS(EMA_OK, ema_least_squares_run(search, 170U));
        TEST_ASSERT_TRUE((search->model_steps - before) <= 170U);
    }
    const uint64_t after = search->model_steps;
    EMA_ASSERT_STATUS(EMA_OK, ema_least_squares_run(search, 1000U));
    TEST_ASSERT_EQUAL_UINT64(after, search->model_steps);
}

static void test_copy_is_a_checkpoint(void)
{
    static ema_least_squares_t copy;
    ema_least_squares_result_t whole;
    ema_least_squares_result_t resumed;
    const ema_actuator_t worn = worn_actuator();
    config.count = 2U;
    make_record(&worn, 600U, EMA_R(1.0));
    (void)memset(&whole, 0, sizeof whole);
    (void)memset(&resumed, 0, sizeof resumed);
    EMA_ASSERT_STATUS(EMA_OK, ema_least_squares_init(search, &config, &record));
    EMA_ASSERT_STATUS(EMA_OK, ema_least_squares_run(search, 7001U));
    TEST_ASSERT_FALSE(ema_least_squares_done(search));
    copy = *search;
    while (!ema_least_squares_done(search)) {
        EMA_ASSERT_STATUS(EMA_OK, ema_least_squares_run(search, UINT32_MAX));
    }
    EMA_ASSERT_STATUS(EMA_OK, ema_least_squares_result(search, &whole));
    (void)memset(search, 0xA5, sizeof *search);
    while (!ema_least_squares_done(&copy)) {
        EMA_ASSERT_STATUS(EMA_OK, ema_least_squares_run(&copy, 13U));
    }
    EMA_ASSERT_STATUS(EMA_OK, ema_least_squares_result(&copy, &resumed));
    EMA_ASSERT_SAME_BITS(&whole, &resumed, sizeof whole);
}

/* The record's own values lie beyond a bound: the estimate stays on it, and says so. */
static void test_estimate_stays_inside_its_bounds(void)
{
    const ema_actuator_t worn = worn_actuator();
    make_record(&worn, ROWS, EMA_R(1.0));
    config.searched[2].upper = EMA_R(1.05);
    const ema_least_squares_result_t result = run(1000U);
    TEST_ASSERT_TRUE(result.value[2].estimate == EMA_R(1.05));
    TEST_ASSERT_TRUE(result.value[2].at_bound);
    TEST_ASSERT_TRUE(result.starts > 1U);
    for (uint32_t k = 0; k < EIGHT; ++k) {
        TEST_ASSERT_TRUE((result.value[k].estimate >= config.searched[k].lower)
                         && (result.value[k].estimate <= config.searched[k].upper));
    }
}

/* Friction so high that nothing moves: one start stays there, further ones leave it. */
static void test_further_starts_leave_a_plateau(void)
{
    const ema_actuator_t worn = worn_actuator();
    make_record(&worn, ROWS, EMA_R(1.0));
    config.count = 2U;
    config.searched[0].upper = EMA_R(2.0);
    config.searched[0].start = EMA_R(1.9);
    actuator = worn;
    config.restarts = 0U;
    const ema_least_squares_result_t stuck = run(1000U);
    TEST_ASSERT_EQUAL_UINT32(1U, stuck.starts);
    TEST_ASSERT_FALSE(stuck.adequate);
    TEST_ASSERT_TRUE(stuck.misfit_after > EMA_R(10.0));
    config.restarts = 8U;
    const ema_least_squares_result_t result = run(1000U);
    TEST_ASSERT_TRUE(result.starts > 1U);
    TEST_ASSERT_TRUE(result.adequate);
    EMA_ASSERT_CLOSE(0.2, result.value[0].estimate, 4.0 * (double)result.value[0].std, 0.0);
    EMA_ASSERT_CLOSE(0.05, result.value[1].estimate, 4.0 * (double)result.value[1].std, 0.0);
}

/* Where the model lacks something every descent ends alike, and three are enough. */
static void test_record_that_is_not_explained_is_left_after_three_that_end_alike(void)
{
    ema_actuator_t worn = worn_actuator();
    worn.params.inertia_kgm2 *= EMA_R(1.5);
    make_record(&worn, ROWS, EMA_R(1.0));
    config.count = 2U;
    const ema_least_squares_result_t result = run(1000U);
    TEST_ASSERT_FALSE(result.adequate);
    TEST_ASSERT_EQUAL_UINT32(3U, result.starts);
    TEST_ASSERT_EQUAL_INT(EMA_OUTCOME_TOLERANCE, result.outcome);
}

/* A budget of the first march alone: what is identifiable is said, before any search. */
static void test_first_march_says_what_is_identifiable(void)
{
    ema_least_squares_result_t result;
    make_record(&actuator, ROWS, EMA_R(1.0));
    config.run_budget = 1U + EIGHT;
    EMA_ASSERT_STATUS(EMA_OK, ema_least_squares_init(search, &config, &record));
    EMA_ASSERT_STATUS(EMA_OK, ema_least_squares_run(search, 1000U));
    EMA_ASSERT_STATUS(EMA_ERR_ORDER, ema_least_squares_result(search, &result));
    result = run(1000U);
    TEST_ASSERT_EQUAL_INT(EMA_OUTCOME_BUDGET, result.outcome);
    TEST_ASSERT_EQUAL_UINT32(1U + EIGHT, result.runs);
    TEST_ASSERT_TRUE(result.misfit_before == result.misfit_after);
    for (uint32_t k = 0; k < EIGHT; ++k) {
        EMA_ASSERT_CLOSE(config.searched[k].start, result.value[k].estimate, 0.0, 4.0 * EMA_EPS);
        TEST_ASSERT_EQUAL_INT(EMA_DETERMINED, result.value[k].determined);
    }
}

/* Every budget is kept. */
static void test_budget_is_kept(void)
{
    ema_actuator_t worn = worn_actuator();
    /* not to be explained, so that descents follow each other until none can begin */
    worn.params.inertia_kgm2 *= EMA_R(2.0);
    make_record(&worn, 600U, EMA_R(1.0));
    config.count = 3U;
    uint32_t ended = 0U;
    for (uint32_t budget = 4U; budget < 80U; ++budget) {
        config.run_budget = budget;
        const ema_least_squares_result_t result = run(UINT32_MAX);
        TEST_ASSERT_TRUE(result.runs <= budget);
        ended += (result.outcome == EMA_OUTCOME_BUDGET) ? 1U : 0U;
    }
    TEST_ASSERT_TRUE(ended > 30U);
}

/* Several model steps between two rows. */
static void test_rows_apart(void)
{
    ema_actuator_t worn = worn_actuator();
    worn.options.record_every_steps = 4;
    actuator.options.record_every_steps = 4;
    make_record(&worn, ROWS / 4U, EMA_R(1.0));
    actuator = worn;
    actuator.params.csj_Nm = EMA_R(0.138);
    config.count = 2U;
    const ema_least_squares_result_t result = run(1000U);
    TEST_ASSERT_TRUE(result.model_steps > (3U * ROWS));
    EMA_ASSERT_CLOSE(0.2, result.value[0].estimate, 4.0 * (double)result.value[0].std, 0.0);
    EMA_ASSERT_CLOSE(0.05, result.value[1].estimate, 4.0 * (double)result.value[1].std, 0.0);
}

/* The quarter of a wave in which the rod only goes forward: friction and load are one resistance, and a value that the
 * model does not use does nothing. */
static void test_values_that_do_the_same_are_told_together(void)
{
    const ema_searched_t idle = {EMA_VALUE_ID(position_noise_mm), EMA_VALUE_ID(position_noise_mm), EMA_R(0.0),
                                 EMA_R(1.0), EMA_R(0.5)};
    chirp = ema_rig_chirp(EMA_R(0.2), EMA_R(2.0), actuator.params.step_s);
    make_record(&actuator, ROWS, EMA_R(1.0));
    config.count = 4U;
    config.searched[1] = idle;
    config.searched[3] = config.searched[5];
    const ema_least_squares_result_t result = run(1000U);
    TEST_ASSERT_EQUAL_INT(EMA_DETERMINED_TOGETHER, result.value[0].determined);
    TEST_ASSERT_EQUAL_INT(EMA_DETERMINED_NOT, result.value[1].determined);
    TEST_ASSERT_EQUAL_INT(EMA_DETERMINED, result.value[2].determined);
    TEST_ASSERT_EQUAL_INT(EMA_DETERMINED_TOGETHER, result.value[3].determined);
    TEST_ASSERT_EQUAL_UINT32(3U, result.value[0].partner);
    TEST_ASSERT_EQUAL_UINT32(1U, result.value[1].partner);
    TEST_ASSERT_EQUAL_UINT32(0U, result.value[3].partner);
    TEST_ASSERT_TRUE(result.value[1].std == EMA_COST_MAX);
    TEST_ASSERT_TRUE(result.value[1].bias == EMA_COST_MAX);
    TEST_ASSERT_TRUE(result.value[1].noise_std == EMA_COST_MAX);
    TEST_ASSERT_FALSE(result.crossed);
    /* nor the other way round */
    chirp.config.amplitude_mm = -chirp.config.amplitude_mm;
    make_record(&actuator, ROWS, EMA_R(1.0));
    const ema_least_squares_result_t back = run(1000U);
    TEST_ASSERT_TRUE(search->best.pushed[0]);
    TEST_ASSERT_FALSE(back.crossed);
}

/* Two thirds of the bounds make no model, being too stiff for the step; the search goes around them. */
static void test_bounds_may_hold_values_without_a_model(void)
{
    const ema_searched_t viscous = {EMA_VALUE_ID(viscous_Nm_s_per_rad), EMA_VALUE_ID(viscous_Nm_s_per_rad), EMA_R(0.0),
                                    EMA_R(10.0), EMA_R(1.0e-4)};
    ema_actuator_t worn = actuator;
    config.count = 1U;
    config.searched[0] = viscous;
    worn.params.viscous_Nm_s_per_rad = EMA_R(0.02);
    make_record(&worn, ROWS, EMA_R(1.0));
    const ema_least_squares_result_t result = run(1000U);
    EMA_ASSERT_CLOSE(0.02, result.value[0].estimate, 4.0 * (double)result.value[0].std, 0.0);
    /* of a machine that does not move the steps go up to where no model is, and are shortened */
    worn.params.csj_Nm = EMA_R(5.0);
    make_record(&worn, ROWS, EMA_R(0.0));
    config.searched[0].start = EMA_R(0.5);
    config.restarts = 0U;
    const ema_least_squares_result_t still = run(1000U);
    TEST_ASSERT_TRUE((still.value[0].estimate > EMA_R(0.5)) && (still.value[0].estimate < EMA_R(8.0)));
    TEST_ASSERT_TRUE(still.misfit_after < still.misfit_before);
    /* and a start that makes none is refused */
    config.searched[0].start = EMA_R(10.0);
    EMA_ASSERT_STATUS(EMA_ERR_STIFF, ema_least_squares_init(search, &config, &record));
}

/* A start behind which nothing has a model, at a bound before which nothing may be tried: no sensitivity, and none to
 * be had elsewhere. */
static void test_start_alone_among_values_without_a_model(void)
{
    ema_model_t model;
    ema_actuator_t stiff = actuator;
    ema_real held = EMA_R(1.0);
    ema_real refused = EMA_R(10.0);
    for (uint32_t k = 0; k < 60U; ++k) {
        stiff.params.viscous_Nm_s_per_rad = EMA_R(0.5) * (held + refused);
        if (ema_model_init(&model, &stiff, EMA_R(0.0)) == EMA_OK) {
            held = stiff.params.viscous_Nm_s_per_rad;
        } else {
            refused = stiff.params.viscous_Nm_s_per_rad;
        }
    }
    const ema_searched_t viscous = {EMA_VALUE_ID(viscous_Nm_s_per_rad), EMA_VALUE_ID(viscous_Nm_s_per_rad), held,
                                    EMA_R(10.0), held};
    make_record(&actuator, 300U, EMA_R(1.0));
    config.count = 2U;
    config.searched[1] = viscous;
    const ema_least_squares_result_t result = run(1000U);
    TEST_ASSERT_EQUAL_UINT32(1U + config.restarts, result.starts);
    TEST_ASSERT_EQUAL_INT(EMA_DETERMINED_NOT, result.value[1].determined);
    TEST_ASSERT_TRUE(result.value[1].estimate == held);
    TEST_ASSERT_TRUE(result.value[1].noise_std == EMA_COST_MAX);
}

/* A signal so large beside its noise that its squares leave the numbers: nothing is known, and that is said. */
static void test_sums_that_overflow_are_told(void)
{
    ema_least_squares_result_t result;
    make_record(&actuator, 600U, EMA_R(1.0));
    config.count = 2U;
    config.restarts = 2U;
    for (uint32_t row = 1U; row < 600U; ++row) {
        buffer[(row * 5U) + 1U] = EMA_BY_PRECISION(EMA_R(1.0e15), EMA_R(1.0e155));
    }
    EMA_ASSERT_STATUS(EMA_OK, ema_least_squares_init(search, &config, &record));
    while (!ema_least_squares_done(search)) {
        EMA_ASSERT_STATUS(EMA_OK, ema_least_squares_run(search, 1000U));
    }
    TEST_ASSERT_EQUAL_UINT32(3U, search->starts);
    EMA_ASSERT_STATUS(EMA_ERR_DIVERGED, ema_least_squares_result(search, &result));
    /* nor is there a march left to begin elsewhere */
    config.run_budget = 4U;
    EMA_ASSERT_STATUS(EMA_OK, ema_least_squares_init(search, &config, &record));
    while (!ema_least_squares_done(search)) {
        EMA_ASSERT_STATUS(EMA_OK, ema_least_squares_run(search, 1000U));
    }
    TEST_ASSERT_EQUAL_UINT32(1U, search->starts);
    TEST_ASSERT_EQUAL_INT(EMA_OUTCOME_BUDGET, search->outcome);
}

/* A record of integers, and of a command that is a function. */
static void test_other_records(void)
{
    static int16_t counts[ROWS * 2U];
    ema_record_config_t kept = {.buffer = counts,
                                .buffer_bytes = sizeof counts,
                                .format = EMA_RECORD_INT16,
                                .command = &chirp,
                                .keep = {true, false, true, false}};
    const ema_actuator_t worn = worn_actuator();
    kept.full_scale[EMA_CHANNEL_POSITION] = EMA_R(4.0);
    kept.full_scale[EMA_CHANNEL_CURRENT] = EMA_R(40.0);
    ema_rig_record(&record, &kept, &worn, &chirp, ROWS);
    actuator = worn;
    config.count = 3U;
    config.noise[EMA_CHANNEL_MOTOR_POSITION] = EMA_R(0.0);
    config.noise[EMA_CHANNEL_VOLTAGE] = EMA_R(0.0);
    const ema_least_squares_result_t result = run(1000U);
    for (uint32_t k = 0; k < 3U; ++k) {
        EMA_ASSERT_CLOSE(truth[k], result.value[k].estimate, 3.0 * (double)result.value[k].noise_std, 0.0);
    }
    config.noise[EMA_CHANNEL_VOLTAGE] = EMA_R(0.03);
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_least_squares_init(search, &config, &record));
}

static void test_pointers_are_needed(void)
{
    ema_least_squares_result_t result;
    make_record(&actuator, 100U, EMA_R(0.0));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_least_squares_init(NULL, &config, &record));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_least_squares_init(search, NULL, &record));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_least_squares_init(search, &config, NULL));
    config.actuator = NULL;
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_least_squares_init(search, &config, &record));
    static ema_least_squares_t never;
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_least_squares_run(NULL, 1U));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_least_squares_run(&never, 1U));
    TEST_ASSERT_FALSE(ema_least_squares_done(NULL));
    TEST_ASSERT_FALSE(ema_least_squares_done(&never));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_least_squares_result(NULL, &result));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_least_squares_result(search, NULL));
}

/* Each change of the configuration by itself is refused; what is put back is not. */
#define ASSERT_REFUSED(expected, place, bad)                                                                           \
    do {                                                                                                               \
        const ema_least_squares_config_t before = config;                                                              \
        (place) = (bad);                                                                                               \
        EMA_ASSERT_STATUS((expected), ema_least_squares_init(search, &config, &record));                               \
        config = before;                                                                                               \
        EMA_ASSERT_STATUS(EMA_OK, ema_least_squares_init(search, &config, &record));                                   \
    } while (0)

static void test_configurations_that_cannot_be(void)
{
    make_record(&actuator, 100U, EMA_R(0.0));
    ASSERT_REFUSED(EMA_ERR_RANGE, config.count, 0U);
    ASSERT_REFUSED(EMA_ERR_RANGE, config.count, EMA_LEAST_SQUARES_MAX + 1U);
    ASSERT_REFUSED(EMA_ERR_RANGE, config.run_budget, EIGHT);
    ASSERT_REFUSED(EMA_ERR_RANGE, config.searched[1].id, (ema_value_id_t)EMA_VALUE_COUNT);
    ASSERT_REFUSED(EMA_ERR_RANGE, config.searched[3].with, (ema_value_id_t)EMA_VALUE_COUNT);
    ASSERT_REFUSED(EMA_ERR_RANGE, config.searched[3].with, EMA_EFFECT_VALUE_ID(learned_torque, gain));
    ASSERT_REFUSED(EMA_ERR_RANGE, config.searched[1].id, EMA_EFFECT_VALUE_ID(learned_torque, gain));
    ASSERT_REFUSED(EMA_ERR_RANGE, config.searched[0].lower, EMA_R(-0.1));
    ASSERT_REFUSED(EMA_ERR_RANGE, config.searched[0].upper, EMA_R(101.0));
    ASSERT_REFUSED(EMA_ERR_BOUNDS, config.searched[0].upper, config.searched[0].lower);
    ASSERT_REFUSED(EMA_ERR_BOUNDS, config.searched[0].lower, (ema_real)NAN);
    ASSERT_REFUSED(EMA_ERR_RANGE, config.searched[0].start, EMA_R(0.01));
    ASSERT_REFUSED(EMA_ERR_RANGE, config.searched[0].start, EMA_R(1.01));
    ASSERT_REFUSED(EMA_ERR_RANGE, config.searched[0].start, (ema_real)NAN);
    /* a share of nothing is nothing, and the gain would leave its range with the torque constant */
    ASSERT_REFUSED(EMA_ERR_RANGE, config.searched[5].with, EMA_VALUE_ID(csj_Nm));
    ASSERT_REFUSED(EMA_ERR_RANGE, config.searched[3].with, EMA_VALUE_ID(output_limit));
    ASSERT_REFUSED(EMA_ERR_RANGE, config.noise[0], EMA_R(-0.005));
    ASSERT_REFUSED(EMA_ERR_RANGE, config.noise[0], (ema_real)NAN);
    ASSERT_REFUSED(EMA_ERR_RANGE, config.noise[0], EMA_R(1.0e-10));
    ASSERT_REFUSED(EMA_ERR_RANGE, config.noise[0], EMA_R(1.0e10));
    for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
        config.noise[channel] = EMA_R(0.0);
    }
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_least_squares_init(search, &config, &record));
}

static void test_records_and_actuators_that_cannot_be(void)
{
    make_record(&actuator, 2U, EMA_R(0.0));
    EMA_ASSERT_STATUS(EMA_ERR_SHORT, ema_least_squares_init(search, &config, &record));
    make_record(&actuator, 100U, EMA_R(0.0));
    actuator.params.supply_V = (ema_real)NAN;
    EMA_ASSERT_STATUS(EMA_ERR_NOT_FINITE, ema_least_squares_init(search, &config, &record));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_eight_values_of_a_noisy_record);
    RUN_TEST(test_values_of_an_exact_record);
    RUN_TEST(test_noise_errors_are_those_of_the_sensitivities);
    RUN_TEST(test_slices_change_no_bit);
    RUN_TEST(test_the_same_bits_everywhere);
    RUN_TEST(test_truth_on_a_bound_is_found_and_asked_again);
    RUN_TEST(test_slice_makes_no_more_steps_than_it_may);
    RUN_TEST(test_copy_is_a_checkpoint);
    RUN_TEST(test_estimate_stays_inside_its_bounds);
    RUN_TEST(test_further_starts_leave_a_plateau);
    RUN_TEST(test_record_that_is_not_explained_is_left_after_three_that_end_alike);
    RUN_TEST(test_first_march_says_what_is_identifiable);
    RUN_TEST(test_budget_is_kept);
    RUN_TEST(test_values_that_do_the_same_are_told_together);
    RUN_TEST(test_bounds_may_hold_values_without_a_model);
    RUN_TEST(test_start_alone_among_values_without_a_model);
    RUN_TEST(test_rows_apart);
    RUN_TEST(test_sums_that_overflow_are_told);
    RUN_TEST(test_other_records);
    RUN_TEST(test_pointers_are_needed);
    RUN_TEST(test_configurations_that_cannot_be);
    RUN_TEST(test_records_and_actuators_that_cannot_be);
    return UNITY_END();
}
