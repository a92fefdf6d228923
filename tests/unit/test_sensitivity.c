/* Standard errors and residual against finite differences and normal equations worked out here, in double, from the
 * model's own runs. */
#include "ema/ema.h"

#include <math.h>

#include "ema_rig.h"

#define ROWS 2000U
#define OUTPUTS (1U + EMA_IDENTIFIED_MAX)

static ema_real buffer[ROWS * 5U];
static ema_record_t record;
static ema_actuator_t actuator;
static ema_command_t chirp;
static ema_sensitivity_t sensitivity;

static const ema_value_id_t ids[4] = {EMA_VALUE_ID(csj_Nm), EMA_VALUE_ID(blk_mm), EMA_VALUE_ID(resistance_ohm),
                                      EMA_VALUE_ID(inertia_kgm2)};
static const ema_real deltas[4] = {EMA_R(1.38e-3), EMA_R(3.3e-4), EMA_R(9.9e-3), EMA_R(6.0e-7)};
static const ema_real position_only[EMA_CHANNEL_COUNT] = {EMA_R(1.0), EMA_R(0.0), EMA_R(0.0), EMA_R(0.0)};

void setUp(void)
{
    actuator = ema_rig_actuator();
    chirp = ema_rig_chirp(EMA_R(4.0), EMA_R(2.0), actuator.params.step_s);
    (void)memset(&sensitivity, 0xA5, sizeof sensitivity);
}

void tearDown(void)
{
}

/* A record of `rows` rows, every channel kept, from a plant of slightly more friction, with white noise that is shared
 * by `share` between neighbours. */
static void make_record(uint32_t rows, ema_real noise_mm, ema_real share)
{
    const ema_record_config_t config = ema_rig_real_record(buffer, sizeof buffer, true);
    ema_actuator_t truth = actuator;
    ema_random_t random;
    ema_real held = EMA_R(0.0);
    truth.params.csj_Nm += EMA_R(1.0e-5);
    ema_rig_record(&record, &config, &truth, &chirp, rows);
    ema_random_init(&random, UINT64_C(31), UINT64_C(3));
    for (uint32_t row = 0; row < rows; ++row) {
        held = (share * held) + (noise_mm * ema_random_normal(&random));
        /* command first, rod position second */
        buffer[(row * 5U) + 1U] += held;
        buffer[(row * 5U) + 3U] += noise_mm * ema_random_normal(&random);
    }
}

/* What the module should find, from whole runs one after the other. */
typedef struct {
    double std[EMA_IDENTIFIED_MAX];
    double rms_mm;
    double correlation;
    double variance;
} expected_t;

static double channel_of(const ema_output_t* output, uint32_t channel)
{
    const ema_real values[EMA_CHANNEL_COUNT] = {output->position_mm, output->motor_position_mm, output->current_A,
                                                output->voltage_V};
    return (double)values[channel];
}

static void simulate(const ema_actuator_t* plant, ema_output_t* rows)
{
    ema_model_t model = ema_rig_model(plant, EMA_R(0.0));
    const uint32_t every = (uint32_t)plant->options.record_every_steps;
    for (uint32_t row = 0; row < record.count; ++row) {
        for (uint32_t k = 0; k < every; ++k) {
            ema_sample_t sample;
            EMA_ASSERT_STATUS(EMA_OK, ema_record_read(&record, row, every, &sample));
            const ema_real command_mm =
                (record.command != NULL) ? ema_command_at(record.command, (row * every) + k) : sample.command_mm;
            const ema_output_t output = ema_rig_step(&model, command_mm);
            rows[row] = (k == 0U) ? output : rows[row];
        }
    }
}

/* Inverse of a small matrix by Gauss and Jordan with pivots of any size. */
static void invert(double matrix[EMA_IDENTIFIED_MAX][EMA_IDENTIFIED_MAX],
                   double inverse[EMA_IDENTIFIED_MAX][EMA_IDENTIFIED_MAX], uint32_t size)
{
    for (uint32_t i = 0; i < size; ++i) {
        for (uint32_t j = 0; j < size; ++j) {
            inverse[i][j] = (i == j) ? 1.0 : 0.0;
        }
    }
    for (uint32_t i = 0; i < size; ++i) {
        const double pivot = matrix[i][i];
        for (uint32_t j = 0; j < size; ++j) {
            matrix[i][j] /= pivot;
            inverse[i][j] /= pivot;
        }
        for (uint32_t k = 0; k < size; ++k) {
            const double factor = (k == i) ? 0.0 : matrix[k][i];
            for (uint32_t j = 0; j < size; ++j) {
                matrix[k][j] -= factor * matrix[i][j];
                inverse[k][j] -= factor * inverse[i][j];
            }
        }
    }
}

static expected_t expect(const ema_real weight[EMA_CHANNEL_COUNT], const ema_real* delta, uint32_t count)
{
    static ema_output_t runs[OUTPUTS][ROWS];
    expected_t expected = {{0.0}, 0.0, 0.0, 0.0};
    double normal[EMA_IDENTIFIED_MAX][EMA_IDENTIFIED_MAX] = {{0.0}};
    double inverse[EMA_IDENTIFIED_MAX][EMA_IDENTIFIED_MAX];
    double square = 0.0;
    double neighbours = 0.0;
    double weighted = 0.0;
    double last = 0.0;
    uint32_t channels = 0U;
    simulate(&actuator, runs[0]);
    for (uint32_t k = 0; k < count; ++k) {
        ema_actuator_t beside = actuator;
        EMA_ASSERT_STATUS(EMA_OK, ema_actuator_set(&beside, ids[k], ema_rig_value(&actuator, ids[k]) + delta[k]));
        simulate(&beside, runs[1U + k]);
    }
    for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
        channels += (weight[channel] > EMA_R(0.0)) ? 1U : 0U;
    }
    for (uint32_t row = 0; row < record.count; ++row) {
        ema_sample_t sample;
        EMA_ASSERT_STATUS(EMA_OK, ema_record_read(&record, row, 1U, &sample));
        const double residual_mm =
            (double)sample.channel[EMA_CHANNEL_POSITION] - channel_of(&runs[0][row], EMA_CHANNEL_POSITION);
        square += residual_mm * residual_mm;
        neighbours += residual_mm * last;
        last = residual_mm;
        for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
            const double w = (double)weight[channel];
            const double base = channel_of(&runs[0][row], channel);
            const double residual = (double)sample.channel[channel] - base;
            weighted += w * residual * residual;
            for (uint32_t i = 0; i < count; ++i) {
                for (uint32_t j = 0; j < count; ++j) {
                    normal[i][j] += w * ((channel_of(&runs[1U + i][row], channel) - base) / (double)delta[i])
                                    * ((channel_of(&runs[1U + j][row], channel) - base) / (double)delta[j]);
                }
            }
        }
    }
    invert(normal, inverse, count);
    expected.rms_mm = sqrt(square / record.count);
    expected.correlation = neighbours / square;
    const double widen = fmin(fmax(expected.correlation, 0.0), 0.999);
    expected.variance = (weighted / (((double)record.count * channels) - count)) * ((1.0 + widen) / (1.0 - widen));
    for (uint32_t i = 0; i < count; ++i) {
        expected.std[i] = sqrt(inverse[i][i] * expected.variance);
    }
    return expected;
}

static void start(const ema_real weight[EMA_CHANNEL_COUNT], const ema_real* delta, uint32_t count)
{
    EMA_ASSERT_STATUS(EMA_OK,
                      ema_sensitivity_start(&sensitivity, &actuator, &record, weight, ids, delta, count, EMA_R(0.0)));
}

static ema_sensitivity_result_t run_to_the_end(uint32_t slice)
{
    ema_sensitivity_result_t result;
    (void)memset(&result, 0, sizeof result);
    while (!ema_sensitivity_done(&sensitivity)) {
        TEST_ASSERT_TRUE(ema_sensitivity_run(&sensitivity, slice) > 0U);
    }
    ema_sensitivity_result(&sensitivity, &result);
    return result;
}

static void assert_agrees(const ema_real weight[EMA_CHANNEL_COUNT], const ema_real* delta, uint32_t count)
{
    const expected_t expected = expect(weight, delta, count);
    start(weight, delta, count);
    const ema_sensitivity_result_t result = run_to_the_end(UINT32_MAX);
    TEST_ASSERT_TRUE(result.determined);
    EMA_ASSERT_CLOSE(expected.rms_mm, result.residual_rms_mm, 0.0, EMA_BY_PRECISION(1.0e-5, 1.0e-12));
    EMA_ASSERT_CLOSE(expected.correlation, result.residual_correlation, EMA_BY_PRECISION(1.0e-5, 1.0e-12), 0.0);
    for (uint32_t i = 0; i < count; ++i) {
        TEST_ASSERT_TRUE(expected.std[i] > 0.0);
        EMA_ASSERT_CLOSE(expected.std[i], result.std[i], 0.0, EMA_BY_PRECISION(1.0e-3, 1.0e-9));
    }
}

static void test_errors_of_one_to_four_parameters(void)
{
    make_record(ROWS, EMA_R(0.005), EMA_R(0.0));
    for (uint32_t count = 1; count <= EMA_IDENTIFIED_MAX; ++count) {
        assert_agrees(position_only, deltas, count);
    }
}

static void test_errors_with_several_weighted_channels(void)
{
    const ema_real weight[EMA_CHANNEL_COUNT] = {EMA_R(1.0), EMA_R(0.5), EMA_R(1.0e-3), EMA_R(1.0e-4)};
    make_record(ROWS, EMA_R(0.005), EMA_R(0.0));
    assert_agrees(weight, deltas, 4U);
}

static void test_step_to_the_other_side_gives_nearly_the_same_errors(void)
{
    const ema_real other[2] = {-deltas[0], -deltas[1]};
    make_record(ROWS, EMA_R(0.005), EMA_R(0.0));
    assert_agrees(position_only, other, 2U);
    const ema_sensitivity_result_t backward = run_to_the_end(1U);
    start(position_only, deltas, 2U);
    const ema_sensitivity_result_t forward = run_to_the_end(UINT32_MAX);
    for (uint32_t i = 0; i < 2U; ++i) {
        EMA_ASSERT_CLOSE(forward.std[i], backward.std[i], 0.0, 0.1);
    }
}

static void test_rows_apart_and_a_command_between_them(void)
{
    actuator.options.record_every_steps = 4;
    make_record(ROWS / 4U, EMA_R(0.005), EMA_R(0.0));
    assert_agrees(position_only, deltas, 2U);
    /* without a recorded command a row is one place shorter */
    const ema_record_config_t config = {
        .buffer = buffer, .buffer_bytes = sizeof buffer, .format = EMA_RECORD_REAL, .command = &chirp};
    ema_actuator_t truth = actuator;
    truth.params.csj_Nm += EMA_R(2.0e-3);
    ema_rig_record(&record, &config, &truth, &chirp, ROWS / 4U);
    TEST_ASSERT_EQUAL_UINT32(1U, record.stride);
    assert_agrees(position_only, deltas, 2U);
}

static void test_slices_change_no_bit_and_make_what_they_say(void)
{
    make_record(300U, EMA_R(0.005), EMA_R(0.0));
    start(position_only, deltas, 2U);
    TEST_ASSERT_EQUAL_UINT32(900U, ema_sensitivity_run(&sensitivity, UINT32_MAX));
    TEST_ASSERT_TRUE(ema_sensitivity_done(&sensitivity));
    TEST_ASSERT_EQUAL_UINT32(0U, ema_sensitivity_run(&sensitivity, 100U));
    const ema_sensitivity_result_t whole = run_to_the_end(1U);
    const uint32_t slices[3] = {1U, 7U, 1000U};
    for (uint32_t k = 0; k < 3U; ++k) {
        start(position_only, deltas, 2U);
        TEST_ASSERT_EQUAL_UINT32(0U, ema_sensitivity_run(&sensitivity, 0U));
        uint32_t made = 0U;
        while (!ema_sensitivity_done(&sensitivity)) {
            const uint32_t now = ema_sensitivity_run(&sensitivity, slices[k]);
            TEST_ASSERT_TRUE((now >= 1U) && (now <= slices[k]) && (now <= sensitivity.work.spent));
            made += now;
        }
        TEST_ASSERT_EQUAL_UINT32(900U, made);
        const ema_sensitivity_result_t sliced = run_to_the_end(slices[k]);
        EMA_ASSERT_SAME_BITS(&whole, &sliced, sizeof whole);
    }
}

/* White noise leaves no bias; a slow wave under it, smaller than the noise, leaves one that grows with it and that the
 * errors do not tell. */
static void test_what_lasts_in_the_residual_is_told_as_bias(void)
{
    double bias[3];
    const ema_real wave_mm[3] = {EMA_R(0.0), EMA_R(0.002), EMA_R(0.004)};
    for (uint32_t k = 0; k < 3U; ++k) {
        make_record(ROWS, EMA_R(0.005), EMA_R(0.0));
        for (uint32_t row = 0; row < ROWS; ++row) {
            buffer[(row * 5U) + 1U] += ((row % 200U) < 100U) ? wave_mm[k] : -wave_mm[k];
        }
        start(position_only, deltas, 2U);
        const ema_sensitivity_result_t result = run_to_the_end(UINT32_MAX);
        bias[k] = (double)result.bias[1];
        TEST_ASSERT_TRUE(result.crossed);
        /* a wave of amplitude a is all along one parameter worth a/noise times sqrt(rows) standard errors of white
         * noise; a third of it is told */
        const double widest = 0.36 * ((double)wave_mm[k] / 0.005) * sqrt((double)ROWS) * (double)result.std[1];
        TEST_ASSERT_TRUE(bias[k] <= widest);
    }
    TEST_ASSERT_TRUE(bias[0] == 0.0);
    TEST_ASSERT_TRUE(bias[1] > 0.0);
    TEST_ASSERT_TRUE(bias[2] > (1.5 * bias[1]));
}

static void test_play_is_crossed_once_the_rod_was_pushed_both_ways(void)
{
    /* the chirp turns back behind a quarter of its first wave */
    const bool crossed[2] = {false, true};
    const uint32_t rows[2] = {ROWS / 40U, ROWS};
    for (uint32_t k = 0; k < 2U; ++k) {
        make_record(rows[k], EMA_R(0.0), EMA_R(0.0));
        start(position_only, deltas, 2U);
        const ema_sensitivity_result_t result = run_to_the_end(UINT32_MAX);
        TEST_ASSERT_TRUE(result.crossed == crossed[k]);
    }
}

/* The other way round: pushed back over a quarter of the first wave, and not yet forward again. */
static void test_play_that_was_only_pushed_back_is_not_crossed(void)
{
    const ema_record_config_t config = ema_rig_real_record(buffer, sizeof buffer, true);
    ema_command_t back = chirp;
    back.config.amplitude_mm = -chirp.config.amplitude_mm;
    ema_rig_record(&record, &config, &actuator, &back, ROWS / 8U);
    start(position_only, deltas, 2U);
    const ema_sensitivity_result_t result = run_to_the_end(UINT32_MAX);
    TEST_ASSERT_TRUE(sensitivity.state[0].play_mm < EMA_R(0.0));
    TEST_ASSERT_TRUE(result.determined);
    TEST_ASSERT_FALSE(result.crossed);
}

/* The same noise twice, once shared between neighbours: the errors widen as for a first-order autoregressive residual.
 */
static void test_shared_residual_widens_the_errors(void)
{
    make_record(ROWS, EMA_R(0.005), EMA_R(0.6));
    assert_agrees(position_only, deltas, 2U);
    const ema_sensitivity_result_t shared = run_to_the_end(1U);
    EMA_ASSERT_CLOSE(0.6, shared.residual_correlation, 0.06, 0.0);
    make_record(ROWS, EMA_R(0.005), EMA_R(0.0));
    start(position_only, deltas, 2U);
    const ema_sensitivity_result_t white = run_to_the_end(UINT32_MAX);
    EMA_ASSERT_CLOSE(0.0, white.residual_correlation, 0.07, 0.0);
    /* sqrt((1 + 0.6) / (1 - 0.6)) times sqrt(1 / (1 - 0.6^2)) for the larger residual */
    EMA_ASSERT_CLOSE(2.5, (double)shared.std[0] / (double)white.std[0], 0.3, 0.0);
}

/* What the sensor's noise is known to share widens the errors as before, and is no bias; what is shared beyond it is.
 */
static void test_noise_that_is_known_to_be_shared_is_no_bias(void)
{
    make_record(ROWS, EMA_R(0.005), EMA_R(0.6));
    start(position_only, deltas, 2U);
    const ema_sensitivity_result_t unknown = run_to_the_end(UINT32_MAX);
    const ema_real shared_mm = (ema_real)((double)unknown.residual_rms_mm * sqrt((double)unknown.residual_correlation));
    TEST_ASSERT_TRUE(unknown.bias[0] > unknown.std[0]);
    actuator.params.shared_noise_mm = EMA_R(0.8) * shared_mm;
    start(position_only, deltas, 2U);
    const ema_sensitivity_result_t partly = run_to_the_end(UINT32_MAX);
    /* sqrt(1 - 0.8^2), less for the scatter of a correlation, which is taken off both */
    EMA_ASSERT_CLOSE(0.6, (double)partly.bias[0] / (double)unknown.bias[0], 0.1, 0.0);
    TEST_ASSERT_TRUE(partly.std[0] == unknown.std[0]);
    actuator.params.shared_noise_mm = EMA_R(1.1) * shared_mm;
    start(position_only, deltas, 2U);
    const ema_sensitivity_result_t known = run_to_the_end(UINT32_MAX);
    TEST_ASSERT_TRUE((known.bias[0] == EMA_R(0.0)) && (known.bias[1] == EMA_R(0.0)));
    TEST_ASSERT_TRUE((known.std[0] == unknown.std[0]) && (known.std[1] == unknown.std[1]));
}

static void test_alternating_residual_does_not_narrow_the_errors(void)
{
    make_record(ROWS, EMA_R(0.0), EMA_R(0.0));
    for (uint32_t row = 0; row < ROWS; ++row) {
        buffer[(row * 5U) + 1U] += ((row & 1U) != 0U) ? EMA_R(0.005) : EMA_R(-0.005);
    }
    assert_agrees(position_only, deltas, 2U);
    const ema_sensitivity_result_t result = run_to_the_end(1U);
    TEST_ASSERT_TRUE(result.residual_correlation < EMA_R(-0.99));
}

static void test_residual_that_repeats_itself_leaves_the_errors_finite(void)
{
    make_record(ROWS, EMA_R(0.0), EMA_R(0.0));
    for (uint32_t row = 0; row < ROWS; ++row) {
        buffer[(row * 5U) + 1U] += EMA_R(0.5);
    }
    assert_agrees(position_only, deltas, 2U);
    const ema_sensitivity_result_t result = run_to_the_end(1U);
    TEST_ASSERT_TRUE(result.residual_correlation > EMA_R(0.999));
}

static void test_perfect_record_has_no_residual_and_no_errors(void)
{
    const ema_record_config_t config = ema_rig_real_record(buffer, sizeof buffer, true);
    ema_rig_record(&record, &config, &actuator, &chirp, 500U);
    start(position_only, deltas, 2U);
    const ema_sensitivity_result_t result = run_to_the_end(UINT32_MAX);
    TEST_ASSERT_TRUE(result.determined);
    TEST_ASSERT_TRUE(result.residual_rms_mm == EMA_R(0.0));
    TEST_ASSERT_TRUE(result.residual_correlation == EMA_R(0.0));
    TEST_ASSERT_TRUE(result.std[0] == EMA_R(0.0));
}

static void assert_undetermined(const ema_value_id_t* which, const ema_real* delta, uint32_t count)
{
    EMA_ASSERT_STATUS(EMA_OK, ema_sensitivity_start(&sensitivity, &actuator, &record, position_only, which, delta,
                                                    count, EMA_R(0.0)));
    const ema_sensitivity_result_t result = run_to_the_end(UINT32_MAX);
    TEST_ASSERT_FALSE(result.determined);
    for (uint32_t i = 0; i < count; ++i) {
        TEST_ASSERT_TRUE(result.std[i] == EMA_R(0.0));
    }
    TEST_ASSERT_TRUE(result.residual_rms_mm > EMA_R(0.004));
}

static void test_parameters_that_do_the_same_are_not_told_apart(void)
{
    const ema_value_id_t twice[2] = {EMA_VALUE_ID(csj_Nm), EMA_VALUE_ID(csj_Nm)};
    const ema_real delta[2] = {EMA_R(1.38e-3), EMA_R(1.38e-3)};
    make_record(ROWS, EMA_R(0.005), EMA_R(0.0));
    assert_undetermined(twice, delta, 2U);
}

static void test_parameter_that_does_nothing_is_not_determined(void)
{
    const ema_value_id_t idle[2] = {EMA_VALUE_ID(csj_Nm), EMA_VALUE_ID(position_noise_mm)};
    make_record(ROWS, EMA_R(0.005), EMA_R(0.0));
    assert_undetermined(idle, deltas, 2U);
}

static void test_step_of_zero_determines_nothing(void)
{
    const ema_real none[2] = {EMA_R(1.38e-3), EMA_R(0.0)};
    make_record(ROWS, EMA_R(0.005), EMA_R(0.0));
    assert_undetermined(ids, none, 2U);
}

/* A weight whose sums leave the range of numbers. */
static void test_sums_that_overflow_determine_nothing(void)
{
    const ema_real largest[EMA_CHANNEL_COUNT] = {EMA_BY_PRECISION(EMA_R(3.0e38), EMA_R(1.0e308))};
    make_record(ROWS, EMA_R(0.005), EMA_R(0.0));
    start(largest, deltas, 2U);
    const ema_sensitivity_result_t result = run_to_the_end(UINT32_MAX);
    TEST_ASSERT_FALSE(result.determined);
    TEST_ASSERT_TRUE(result.std[0] == EMA_R(0.0));
    TEST_ASSERT_TRUE(result.bias[0] == EMA_R(0.0));
}

static void test_fewer_rows_than_parameters_leave_finite_numbers(void)
{
    make_record(2U, EMA_R(0.005), EMA_R(0.0));
    start(position_only, deltas, 2U);
    const ema_sensitivity_result_t result = run_to_the_end(UINT32_MAX);
    TEST_ASSERT_FALSE(result.determined);
    TEST_ASSERT_TRUE(isfinite((double)result.residual_rms_mm));
}

static void test_copy_is_a_checkpoint(void)
{
    static ema_sensitivity_t copy;
    make_record(300U, EMA_R(0.005), EMA_R(0.0));
    start(position_only, deltas, 2U);
    const ema_sensitivity_result_t whole = run_to_the_end(UINT32_MAX);
    start(position_only, deltas, 2U);
    (void)ema_sensitivity_run(&sensitivity, 401U);
    copy = sensitivity;
    (void)run_to_the_end(UINT32_MAX);
    sensitivity = copy;
    const ema_sensitivity_result_t resumed = run_to_the_end(13U);
    EMA_ASSERT_SAME_BITS(&whole, &resumed, sizeof whole);
}

static void test_start_is_where_the_rod_rested(void)
{
    const ema_sample_t still = {EMA_R(3.0), {EMA_R(3.0), EMA_R(3.0)}};
    const ema_record_config_t config = ema_rig_real_record(buffer, sizeof buffer, true);
    EMA_ASSERT_STATUS(EMA_OK, ema_record_init(&record, &config));
    EMA_ASSERT_STATUS(EMA_OK, ema_record_append(&record, &still));
    EMA_ASSERT_STATUS(
        EMA_OK, ema_sensitivity_start(&sensitivity, &actuator, &record, position_only, ids, deltas, 2U, EMA_R(3.0)));
    const ema_sensitivity_result_t result = run_to_the_end(UINT32_MAX);
    TEST_ASSERT_TRUE(result.residual_rms_mm == EMA_R(0.0));
}

static void test_start_needs_its_pointers(void)
{
    make_record(10U, EMA_R(0.005), EMA_R(0.0));
    const ema_real zero = EMA_R(0.0);
    EMA_ASSERT_STATUS(EMA_ERR_NULL,
                      ema_sensitivity_start(NULL, &actuator, &record, position_only, ids, deltas, 2U, zero));
    EMA_ASSERT_STATUS(EMA_ERR_NULL,
                      ema_sensitivity_start(&sensitivity, NULL, &record, position_only, ids, deltas, 2U, zero));
    EMA_ASSERT_STATUS(EMA_ERR_NULL,
                      ema_sensitivity_start(&sensitivity, &actuator, NULL, position_only, ids, deltas, 2U, zero));
    EMA_ASSERT_STATUS(EMA_ERR_NULL,
                      ema_sensitivity_start(&sensitivity, &actuator, &record, NULL, ids, deltas, 2U, zero));
    EMA_ASSERT_STATUS(EMA_ERR_NULL,
                      ema_sensitivity_start(&sensitivity, &actuator, &record, position_only, NULL, deltas, 2U, zero));
    EMA_ASSERT_STATUS(EMA_ERR_NULL,
                      ema_sensitivity_start(&sensitivity, &actuator, &record, position_only, ids, NULL, 2U, zero));
}

static void assert_refused(ema_status_t expected, const ema_real* weight, const ema_value_id_t* which, uint32_t count,
                           unsigned line)
{
    static ema_sensitivity_t before;
    before = sensitivity;
    ema_assert_status(expected,
                      ema_sensitivity_start(&sensitivity, &actuator, &record, weight, which, deltas, count, EMA_R(0.0)),
                      line);
    ema_assert_same_bits(&before, &sensitivity, sizeof before, line);
}

#define ASSERT_REFUSED(expected, weight, which, count)                                                                 \
    assert_refused((expected), (weight), (which), (count), (unsigned)__LINE__)

static void test_start_refuses_an_empty_record(void)
{
    const ema_record_config_t config = ema_rig_real_record(buffer, sizeof buffer, true);
    EMA_ASSERT_STATUS(EMA_OK, ema_record_init(&record, &config));
    ASSERT_REFUSED(EMA_ERR_SHORT, position_only, ids, 2U);
}

static void test_start_refuses_too_many_parameters_and_unknown_ones(void)
{
    const ema_value_id_t unknown[2] = {EMA_VALUE_ID(csj_Nm), (ema_value_id_t)EMA_VALUE_COUNT};
    make_record(10U, EMA_R(0.005), EMA_R(0.0));
    ASSERT_REFUSED(EMA_ERR_RANGE, position_only, ids, EMA_IDENTIFIED_MAX + 1U);
    ASSERT_REFUSED(EMA_ERR_RANGE, position_only, unknown, 2U);
}

static void test_start_refuses_weights_that_cannot_be(void)
{
    make_record(10U, EMA_R(0.005), EMA_R(0.0));
    const ema_real negative[EMA_CHANNEL_COUNT] = {EMA_R(1.0), EMA_R(-1.0)};
    const ema_real nothing[EMA_CHANNEL_COUNT] = {(ema_real)NAN};
    const ema_real current[EMA_CHANNEL_COUNT] = {EMA_R(1.0), EMA_R(0.0), EMA_R(1.0)};
    ASSERT_REFUSED(EMA_ERR_RANGE, negative, ids, 2U);
    ASSERT_REFUSED(EMA_ERR_RANGE, nothing, ids, 2U);
    const ema_record_config_t config = ema_rig_real_record(buffer, sizeof buffer, false);
    ema_rig_record(&record, &config, &actuator, &chirp, 10U);
    ASSERT_REFUSED(EMA_ERR_RANGE, current, ids, 2U);
}

static void test_start_refuses_what_makes_no_model(void)
{
    make_record(10U, EMA_R(0.005), EMA_R(0.0));
    const ema_real too_far[2] = {EMA_R(1.38e-3), EMA_R(-1.0)};
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_sensitivity_start(&sensitivity, &actuator, &record, position_only, ids,
                                                           too_far, 2U, EMA_R(0.0)));
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_sensitivity_start(&sensitivity, &actuator, &record, position_only, ids, deltas,
                                                           2U, EMA_R(26.0)));
    EMA_ASSERT_STATUS(EMA_ERR_NOT_FINITE, ema_sensitivity_start(&sensitivity, &actuator, &record, position_only, ids,
                                                                deltas, 2U, (ema_real)NAN));
    actuator.params.lead_mm = (ema_real)NAN;
    EMA_ASSERT_STATUS(EMA_ERR_NOT_FINITE, ema_sensitivity_start(&sensitivity, &actuator, &record, position_only, ids,
                                                                deltas, 2U, EMA_R(0.0)));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_errors_of_one_to_four_parameters);
    RUN_TEST(test_errors_with_several_weighted_channels);
    RUN_TEST(test_step_to_the_other_side_gives_nearly_the_same_errors);
    RUN_TEST(test_rows_apart_and_a_command_between_them);
    RUN_TEST(test_slices_change_no_bit_and_make_what_they_say);
    RUN_TEST(test_shared_residual_widens_the_errors);
    RUN_TEST(test_noise_that_is_known_to_be_shared_is_no_bias);
    RUN_TEST(test_what_lasts_in_the_residual_is_told_as_bias);
    RUN_TEST(test_play_is_crossed_once_the_rod_was_pushed_both_ways);
    RUN_TEST(test_play_that_was_only_pushed_back_is_not_crossed);
    RUN_TEST(test_alternating_residual_does_not_narrow_the_errors);
    RUN_TEST(test_residual_that_repeats_itself_leaves_the_errors_finite);
    RUN_TEST(test_perfect_record_has_no_residual_and_no_errors);
    RUN_TEST(test_parameters_that_do_the_same_are_not_told_apart);
    RUN_TEST(test_parameter_that_does_nothing_is_not_determined);
    RUN_TEST(test_step_of_zero_determines_nothing);
    RUN_TEST(test_sums_that_overflow_determine_nothing);
    RUN_TEST(test_fewer_rows_than_parameters_leave_finite_numbers);
    RUN_TEST(test_copy_is_a_checkpoint);
    RUN_TEST(test_start_is_where_the_rod_rested);
    RUN_TEST(test_start_needs_its_pointers);
    RUN_TEST(test_start_refuses_an_empty_record);
    RUN_TEST(test_start_refuses_too_many_parameters_and_unknown_ones);
    RUN_TEST(test_start_refuses_weights_that_cannot_be);
    RUN_TEST(test_start_refuses_what_makes_no_model);
    return UNITY_END();
}
