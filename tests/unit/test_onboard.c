/* Signatures: sums of products against the same in double, names and sizes, every refusal, and that slices and copies
 * do not matter. */
#include "ema/ema.h"

#include <math.h>

#include "ema_signature_rig.h"

static ema_real buffer[EMA_TABLE_RECORD_ROWS * 5U];
static ema_signature_rig_t rig;
static ema_actuator_t healthy;
static ema_record_config_t config;
static ema_record_t record;
static ema_onboard_t onboard;

void setUp(void)
{
    healthy = ema_rig_actuator();
    ema_signature_rig(&rig, &healthy);
    config = ema_rig_real_record(buffer, sizeof buffer, true);
    EMA_ASSERT_STATUS(EMA_OK, ema_record_init(&record, &config));
    (void)memset(&onboard, 0xA5, sizeof onboard);
}

void tearDown(void)
{
}

static void record_rows(const ema_actuator_t* truth, uint32_t rows)
{
    const ema_command_t command = ema_signature_command(&healthy);
    ema_model_t model = ema_rig_model(truth, EMA_R(0.0));
    ema_random_t noise;
    ema_random_init(&noise, UINT64_C(77), UINT64_C(3));
    for (uint32_t row = 0; row < rows; ++row) {
        const ema_sample_t sample = ema_signature_sample(&model, &command, row, &noise);
        EMA_ASSERT_STATUS(EMA_OK, ema_record_append(&record, &sample));
    }
}

static ema_finding_t find(const ema_actuator_t* known, uint32_t slice)
{
    ema_finding_t finding;
    (void)memset(&finding, 0, sizeof finding);
    EMA_ASSERT_STATUS(EMA_OK, ema_onboard_start(&onboard, &rig.table, known, &record, EMA_R(0.0)));
    while (!ema_onboard_done(&onboard)) {
        TEST_ASSERT_TRUE(ema_onboard_run(&onboard, slice) > 0U);
    }
    TEST_ASSERT_EQUAL_UINT32(0U, ema_onboard_run(&onboard, slice));
    EMA_ASSERT_STATUS(EMA_OK, ema_onboard_result(&onboard, &finding));
    return finding;
}

static ema_actuator_t with_inertia(ema_real change)
{
    ema_actuator_t truth = healthy;
    truth.effects.inertia_change.change = change;
    return truth;
}

/* Every sum, worked out from the record in double with the table before it was rounded. */
static void products_agree(void)
{
    const ema_actuator_t truth = with_inertia(EMA_R(0.1));
    record_rows(&truth, EMA_TABLE_RECORD_ROWS);
    (void)find(&healthy, 200U);
    double expected[EMA_TABLE_ROWS] = {0.0};
    double square = 0.0;
    ema_model_t model = ema_rig_model(&healthy, EMA_R(0.0));
    for (uint32_t bin = 0; bin < EMA_TABLE_BINS; ++bin) {
        double sum[EMA_TABLE_CHANNELS] = {0.0};
        for (uint32_t k = 0; k < EMA_TABLE_BIN_ROWS; ++k) {
            ema_sample_t sample;
            EMA_ASSERT_STATUS(EMA_OK, ema_record_read(&record, (bin * EMA_TABLE_BIN_ROWS) + k, 1U, &sample));
            const ema_output_t output = ema_rig_step(&model, sample.command_mm);
            sum[0] += (double)sample.channel[EMA_CHANNEL_POSITION] - (double)output.position_mm;
            sum[1] += (double)sample.channel[EMA_CHANNEL_CURRENT] - (double)output.current_A;
        }
        for (uint32_t k = 0; k < EMA_TABLE_CHANNELS; ++k) {
            const double white = (sum[k] / (double)EMA_TABLE_BIN_ROWS) * (double)rig.table.weight[k];
            square += white * white;
            for (uint32_t row = 0; row < EMA_TABLE_ROWS; ++row) {
                expected[row] += white * rig.row[row][(bin * EMA_TABLE_CHANNELS) + k];
            }
        }
    }
    for (uint32_t row = 0; row < EMA_TABLE_ROWS; ++row) {
        EMA_ASSERT_CLOSE(expected[row], (double)onboard.scores.product[row], 1.0e-3 * sqrt(square), 1.0e-3);
    }
    EMA_ASSERT_CLOSE(square, (double)onboard.scores.square, 0.0, 1.0e-3);
}

static void names_and_sizes(void)
{
    const ema_actuator_t truth = with_inertia(-EMA_R(0.08));
    record_rows(&truth, EMA_TABLE_RECORD_ROWS);
    const ema_finding_t finding = find(&healthy, 1000U);
    TEST_ASSERT_EQUAL_INT(EMA_FINDING_MISSING, finding.kind);
    TEST_ASSERT_EQUAL_INT(EMA_EFFECT_ID_inertia_change, finding.effect);
    TEST_ASSERT_EQUAL_STRING("inertia_change", ema_effect_name(finding.effect));
    EMA_ASSERT_CLOSE(-0.08, (double)finding.size, 0.012, 0.0);
    TEST_ASSERT_TRUE(finding.alike == ((ema_effect_set_t)1U << (uint32_t)EMA_EFFECT_ID_inertia_change));
    TEST_ASSERT_TRUE(finding.score > finding.limit);
}

static void healthy_is_adequate(void)
{
    record_rows(&healthy, EMA_TABLE_RECORD_ROWS);
    const ema_finding_t finding = find(&healthy, 1000U);
    TEST_ASSERT_EQUAL_INT(EMA_FINDING_ADEQUATE, finding.kind);
    EMA_ASSERT_CLOSE(30.0, (double)finding.limit, 1.0e-6, 0.0);
    TEST_ASSERT_TRUE(finding.energy < rig.table.energy);
}

/* A fault is found as a shift, and is no effect; where it is known, nothing is left of it and the limit is wider. */
static void faults_are_shifts(void)
{
    ema_actuator_t truth = healthy;
    truth.params.csj_Nm += EMA_R(0.004);
    truth.params.blk_mm += EMA_R(0.006);
    record_rows(&truth, EMA_TABLE_RECORD_ROWS);
    const ema_finding_t first = find(&healthy, 1000U);
    TEST_ASSERT_EQUAL_INT(EMA_FINDING_ADEQUATE, first.kind);
    EMA_ASSERT_CLOSE(0.004, (double)first.moved[0], 0.0008, 0.0);
    EMA_ASSERT_CLOSE(0.006, (double)first.moved[1], 0.0012, 0.0);
    const ema_finding_t second = find(&truth, 1000U);
    TEST_ASSERT_EQUAL_INT(EMA_FINDING_ADEQUATE, second.kind);
    EMA_ASSERT_CLOSE(0.0, (double)second.moved[0], 0.0005, 0.0);
    const double moved[2] = {0.004 * (double)rig.table.fault[0].length, 0.006 * (double)rig.table.fault[1].length};
    EMA_ASSERT_CLOSE(30.0 + (4.0e-4 * ((moved[0] * moved[0]) + (moved[1] * moved[1]))), (double)second.limit, 0.0,
                     1.0e-3);
}

static void outside_the_table_is_unknown(void)
{
    ema_actuator_t truth = healthy;
    truth.effects.sensor_offset.offset_mm = EMA_R(0.01);
    record_rows(&truth, EMA_TABLE_RECORD_ROWS);
    TEST_ASSERT_EQUAL_INT(EMA_FINDING_UNKNOWN, find(&healthy, 1000U).kind);
}

static void slices_and_copies(void)
{
    const ema_actuator_t truth = with_inertia(EMA_R(0.1));
    record_rows(&truth, EMA_TABLE_RECORD_ROWS);
    const ema_finding_t whole = find(&healthy, UINT32_MAX);
    const uint32_t slices[] = {1U, 7U, 1000U};
    for (size_t k = 0; k < (sizeof slices / sizeof slices[0]); ++k) {
        const ema_finding_t sliced = find(&healthy, slices[k]);
        EMA_ASSERT_SAME_BITS(&whole, &sliced, sizeof whole);
    }
    EMA_ASSERT_STATUS(EMA_OK, ema_onboard_start(&onboard, &rig.table, &healthy, &record, EMA_R(0.0)));
    (void)ema_onboard_run(&onboard, 777U);
    static ema_onboard_t copy;
    copy = onboard;
    (void)memset(&onboard, 0x5A, sizeof onboard);
    (void)ema_onboard_run(&copy, UINT32_MAX);
    ema_finding_t resumed;
    (void)memset(&resumed, 0, sizeof resumed);
    EMA_ASSERT_STATUS(EMA_OK, ema_onboard_result(&copy, &resumed));
    EMA_ASSERT_SAME_BITS(&whole, &resumed, sizeof whole);
}

/* A command that is a function of time is asked at every step. */
static void command_as_a_function(void)
{
    const ema_command_t command = ema_signature_command(&healthy);
    config.command = &command;
    EMA_ASSERT_STATUS(EMA_OK, ema_record_init(&record, &config));
    record_rows(&healthy, EMA_TABLE_RECORD_ROWS);
    TEST_ASSERT_EQUAL_INT(EMA_FINDING_ADEQUATE, find(&healthy, 33U).kind);
}

static void another_command_says_nothing(void)
{
    const ema_command_t command = ema_rig_chirp(EMA_R(3.9), EMA_R(2.0), healthy.params.step_s);
    ema_rig_record(&record, &config, &healthy, &command, EMA_TABLE_RECORD_ROWS);
    const ema_finding_t other = find(&healthy, 1000U);
    TEST_ASSERT_EQUAL_INT(EMA_FINDING_NONE, other.kind);
    TEST_ASSERT_EQUAL_INT(EMA_EFFECT_COUNT, other.effect);
    EMA_ASSERT_STATUS(EMA_OK, ema_record_init(&record, &config));
    record_rows(&healthy, EMA_TABLE_RECORD_ROWS - 1U);
    TEST_ASSERT_EQUAL_INT(EMA_FINDING_NONE, find(&healthy, 1000U).kind);
    /* what is no number is no finding */
    EMA_ASSERT_STATUS(EMA_OK, ema_record_init(&record, &config));
    record_rows(&healthy, EMA_TABLE_RECORD_ROWS);
    buffer[1] = (ema_real)NAN;
    TEST_ASSERT_EQUAL_INT(EMA_FINDING_NONE, find(&healthy, 1000U).kind);
}

/* Rows are recorded at every third step. */
static void rows_of_several_steps(void)
{
    healthy.options.record_every_steps = 3;
    rig.table.fingerprint = ema_onboard_fingerprint(&healthy);
    record_rows(&healthy, 10U);
    (void)find(&healthy, 4U);
    TEST_ASSERT_EQUAL_UINT32(30U, onboard.model.state.step);
    const ema_real held_A = onboard.model.state.current_A;
    ema_model_t holding = ema_rig_model(&healthy, EMA_R(0.0));
    for (uint32_t step = 0; step < 30U; ++step) {
        ema_sample_t sample;
        EMA_ASSERT_STATUS(EMA_OK, ema_record_read(&record, step / 3U, 3U, &sample));
        (void)ema_rig_step(&holding, sample.command_mm);
    }
    EMA_ASSERT_CLOSE((double)holding.state.current_A, (double)held_A, 0.0, 0.0);
    /* between rows a command that is a function goes on */
    const ema_command_t command = ema_signature_command(&healthy);
    record.command = &command;
    (void)find(&healthy, 4U);
    ema_model_t following = ema_rig_model(&healthy, EMA_R(0.0));
    for (uint32_t step = 0; step < 30U; ++step) {
        (void)ema_rig_step(&following, ema_command_at(&command, step));
    }
    const ema_real followed_A = onboard.model.state.current_A;
    EMA_ASSERT_CLOSE((double)following.state.current_A, (double)followed_A, 0.0, 0.0);
    TEST_ASSERT_TRUE(fabs((double)followed_A - (double)held_A) > 1.0e-3);
}

/* Ranking by products that are given: phases, signs, penalties, shapes, and what is too near to be told apart. */
static void ranking(void)
{
    const ema_pattern_t patterns[] = {
        {(uint8_t)EMA_EFFECT_ID_pitch_ripple, 0U, 2U, false, {EMA_R(0.1), EMA_R(0.0), EMA_R(0.2)}, EMA_R(1.0)},
        {(uint8_t)EMA_EFFECT_ID_pitch_ripple, 1U, 1U, false, {EMA_R(9.0), EMA_R(0.0), EMA_R(0.0)}, EMA_R(1.0)},
        {(uint8_t)EMA_EFFECT_ID_supply_sag, 2U, 1U, true, {EMA_R(1.0), EMA_R(0.0), EMA_R(0.0)}, EMA_R(0.0)},
        {(uint8_t)EMA_EFFECT_ID_jam_spot, 3U, 1U, true, {EMA_R(1.0), EMA_R(0.0), EMA_R(0.0)}, EMA_R(0.0)},
        {(uint8_t)EMA_EFFECT_ID_gain_drift, 4U, 1U, false, {EMA_R(1.0), EMA_R(0.0), EMA_R(0.0)}, EMA_R(0.0)},
    };
    record_rows(&healthy, EMA_TABLE_RECORD_ROWS);
    (void)find(&healthy, 1000U);
    rig.table.pattern = patterns;
    rig.table.patterns = 5U;
    rig.table.nuisances = 0U;
    const ema_real products[EMA_TABLE_ROWS] = {EMA_R(6.0), EMA_R(4.0),  -EMA_R(20.0),
                                               EMA_R(6.9), -EMA_R(5.0), EMA_R(0.0)};
    (void)memcpy(onboard.scores.product, products, sizeof products);
    ema_finding_t finding;
    EMA_ASSERT_STATUS(EMA_OK, ema_onboard_result(&onboard, &finding));
    TEST_ASSERT_EQUAL_INT(EMA_EFFECT_ID_pitch_ripple, finding.effect);
    EMA_ASSERT_CLOSE(51.0, (double)finding.score, 1.0e-4, 0.0);
    EMA_ASSERT_CLOSE(1.0, (double)finding.size, 1.0e-6, 0.0);
    TEST_ASSERT_EQUAL_INT(EMA_EFFECT_ID_jam_spot, finding.runner_up);
    EMA_ASSERT_CLOSE(47.61, (double)finding.runner_up_score, 1.0e-4, 0.0);
    TEST_ASSERT_TRUE(finding.alike
                     == (((ema_effect_set_t)1U << (uint32_t)EMA_EFFECT_ID_pitch_ripple)
                         | ((ema_effect_set_t)1U << (uint32_t)EMA_EFFECT_ID_jam_spot)));
    TEST_ASSERT_EQUAL_INT(EMA_FINDING_MISSING, finding.kind);
    /* nothing fits: every sign is wrong */
    const ema_real none[EMA_TABLE_ROWS] = {EMA_R(0.0)};
    (void)memcpy(onboard.scores.product, none, sizeof none);
    EMA_ASSERT_STATUS(EMA_OK, ema_onboard_result(&onboard, &finding));
    TEST_ASSERT_EQUAL_INT(EMA_EFFECT_COUNT, finding.effect);
    TEST_ASSERT_TRUE(finding.alike == 0U);
    TEST_ASSERT_EQUAL_INT(EMA_FINDING_ADEQUATE, finding.kind);
    /* much is left, with no effect and with one that explains little of it */
    onboard.scores.square = EMA_R(500.0);
    EMA_ASSERT_STATUS(EMA_OK, ema_onboard_result(&onboard, &finding));
    TEST_ASSERT_EQUAL_INT(EMA_FINDING_UNKNOWN, finding.kind);
    (void)memcpy(onboard.scores.product, products, sizeof products);
    EMA_ASSERT_STATUS(EMA_OK, ema_onboard_result(&onboard, &finding));
    TEST_ASSERT_EQUAL_INT(EMA_EFFECT_ID_pitch_ripple, finding.effect);
    TEST_ASSERT_EQUAL_INT(EMA_FINDING_UNKNOWN, finding.kind);
}

static void prints(void)
{
    const uint32_t fingerprint = ema_onboard_fingerprint(&healthy);
    ema_actuator_t other = healthy;
    other.params.csj_Nm *= EMA_R(2.0);
    other.params.blk_mm *= EMA_R(2.0);
    TEST_ASSERT_EQUAL_HEX32(fingerprint, ema_onboard_fingerprint(&other));
    other.params.kp_per_m *= EMA_R(1.000001);
    TEST_ASSERT_TRUE(fingerprint != ema_onboard_fingerprint(&other));
    other = healthy;
    other.effects.jam_spot.width_mm = EMA_R(0.31);
    TEST_ASSERT_TRUE(fingerprint != ema_onboard_fingerprint(&other));
    other = healthy;
    other.options.side = 1;
    TEST_ASSERT_TRUE(fingerprint != ema_onboard_fingerprint(&other));
}

static void refused(ema_status_t status)
{
    EMA_ASSERT_STATUS(status, ema_onboard_start(&onboard, &rig.table, &healthy, &record, EMA_R(0.0)));
    ema_signature_rig(&rig, &healthy);
}

static void refusals(void)
{
    ema_finding_t finding;
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_onboard_start(NULL, &rig.table, &healthy, &record, EMA_R(0.0)));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_onboard_start(&onboard, NULL, &healthy, &record, EMA_R(0.0)));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_onboard_start(&onboard, &rig.table, NULL, &record, EMA_R(0.0)));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_onboard_start(&onboard, &rig.table, &healthy, NULL, EMA_R(0.0)));
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_onboard_start(&onboard, &rig.table, &healthy, &record, EMA_R(1.0e6)));
    record_rows(&healthy, 50U);
    EMA_ASSERT_STATUS(EMA_OK, ema_onboard_start(&onboard, &rig.table, &healthy, &record, EMA_R(0.0)));
    EMA_ASSERT_STATUS(EMA_ERR_ORDER, ema_onboard_result(&onboard, &finding));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_onboard_result(&onboard, NULL));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_onboard_result(NULL, &finding));
    TEST_ASSERT_EQUAL_STRING("none", ema_effect_name(EMA_EFFECT_COUNT));

    rig.table.version = EMA_SIGNATURES_VERSION + 1U;
    refused(EMA_ERR_TABLE);
    rig.table.fingerprint ^= 1U;
    refused(EMA_ERR_TABLE);
    rig.table.pattern = NULL;
    refused(EMA_ERR_TABLE);
    rig.table.unit = NULL;
    refused(EMA_ERR_TABLE);
    rig.table.value = NULL;
    refused(EMA_ERR_TABLE);
    rig.table.channels = 0U;
    refused(EMA_ERR_TABLE);
    rig.table.channels = EMA_CHANNEL_COUNT + 1U;
    refused(EMA_ERR_TABLE);
    rig.table.channel[1] = (uint8_t)EMA_CHANNEL_COUNT;
    refused(EMA_ERR_TABLE);
    rig.table.faults = EMA_SIGNATURE_FAULTS_MAX + 1U;
    refused(EMA_ERR_TABLE);
    rig.table.rows = EMA_SIGNATURE_ROWS_MAX + 1U;
    refused(EMA_ERR_TABLE);
    rig.table.nuisances = EMA_TABLE_ROWS + 1U;
    refused(EMA_ERR_TABLE);
    rig.table.patterns = 0U;
    refused(EMA_ERR_TABLE);
    rig.table.patterns = EMA_SIGNATURE_ROWS_MAX + 1U;
    refused(EMA_ERR_TABLE);
    rig.table.bins = 0U;
    refused(EMA_ERR_TABLE);
    rig.table.bin_rows = 0U;
    refused(EMA_ERR_TABLE);
    rig.table.bins = EMA_TABLE_BINS + 1U;
    refused(EMA_ERR_TABLE);
    rig.pattern[0].effect = (uint8_t)EMA_EFFECT_COUNT;
    refused(EMA_ERR_TABLE);
    rig.pattern[1].rows = 0U;
    refused(EMA_ERR_TABLE);
    rig.pattern[1].rows = 3U;
    refused(EMA_ERR_TABLE);
    rig.pattern[1].first = (uint8_t)EMA_TABLE_ROWS;
    refused(EMA_ERR_TABLE);
    rig.table.fault[0].row = (uint8_t)EMA_TABLE_ROWS;
    refused(EMA_ERR_TABLE);
    rig.table.fault[1].id = (ema_value_id_t)EMA_VALUE_COUNT;
    refused(EMA_ERR_TABLE);
    config = ema_rig_real_record(buffer, sizeof buffer, false);
    EMA_ASSERT_STATUS(EMA_OK, ema_record_init(&record, &config));
    refused(EMA_ERR_RANGE);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(products_agree);
    RUN_TEST(names_and_sizes);
    RUN_TEST(healthy_is_adequate);
    RUN_TEST(faults_are_shifts);
    RUN_TEST(outside_the_table_is_unknown);
    RUN_TEST(slices_and_copies);
    RUN_TEST(command_as_a_function);
    RUN_TEST(another_command_says_nothing);
    RUN_TEST(rows_of_several_steps);
    RUN_TEST(ranking);
    RUN_TEST(prints);
    RUN_TEST(refusals);
    return UNITY_END();
}
