/* Results packed and read again: all of them, bit for bit; what is no packet is refused with its reason. */
#include "ema/ema.h"

#include <math.h>

#include "ema_image_rig.h"
#include "ema_rig.h"

#define CRC 236U

static uint8_t packet[EMA_TELEMETRY_BYTES + 3U];
static ema_actuator_t actuator;
static ema_session_config_t config;
static ema_result_t result;
static ema_finding_t finding;
static ema_telemetry_t read;
static ema_telemetry_t before;
static ema_real buffer[8];

#define ASSERT_STATUS(expected, actual) TEST_ASSERT_EQUAL_STRING(ema_image_text(expected), ema_image_text(actual))

/* A number of which float32 loses nothing. */
static ema_real odd(uint32_t k)
{
    return (ema_real)((float)(k + 1U) / 3.0f);
}

void setUp(void)
{
    const ema_record_config_t record = ema_rig_real_record(buffer, sizeof buffer, false);
    actuator = ema_rig_actuator();
    actuator.options.day_values = 1;
    EMA_ASSERT_STATUS(EMA_OK, ema_session_config_default(&config, &actuator, &record));
    EMA_ASSERT_STATUS(EMA_OK, ema_session_config_day(&config));
    (void)memset(&result, 0, sizeof result);
    result.identified_count = config.identified_count;
    for (uint32_t k = 0; k < result.identified_count; ++k) {
        result.identified[k].estimate = odd(10U * k);
        result.identified[k].std = odd((10U * k) + 1U);
        result.identified[k].bias = odd((10U * k) + 2U);
        result.identified[k].shift_percent = -odd((10U * k) + 3U);
        result.identified[k].at_bound = (k % 2U) == 1U;
    }
    result.objective_before = odd(100U);
    result.objective_after = odd(101U);
    result.residual_rms_mm = odd(102U);
    result.residual_correlation = odd(103U);
    result.outside_ratio = odd(104U);
    result.evaluations = 0x12345678U;
    result.model_steps = UINT64_C(0x123456789ABCDEF0);
    result.search = (ema_annealer_info_t){1U, 2U, 3U, 4U, 5U, UINT32_MAX};
    result.random.state = UINT64_C(0xFEDCBA9876543210);
    result.random.increment = UINT64_C(0x8000000000000001);
    result.outcome = EMA_OUTCOME_BUDGET;
    result.verdict = EMA_VERDICT_UNDECIDED;
    result.adequate = true;
    result.reasons = (uint32_t)EMA_REASON_EFFECT | (uint32_t)EMA_REASON_NOT_CONVERGED;
    (void)memset(&finding, 0, sizeof finding);
    finding.kind = EMA_FINDING_MISSING;
    finding.effect = EMA_EFFECT_ID_spring_load;
    finding.runner_up = EMA_EFFECT_COUNT;
    finding.alike = UINT64_C(0x8000000000000005);
    finding.score = odd(200U);
    finding.runner_up_score = odd(201U);
    finding.limit = odd(202U);
    finding.size = -odd(203U);
    finding.energy = odd(204U);
    finding.moved[0] = odd(205U);
    finding.moved[1] = -odd(206U);
    (void)memset(packet, 0xA5, sizeof packet);
    (void)memset(&read, 0xA5, sizeof read);
    (void)memcpy(&before, &read, sizeof read);
}

void tearDown(void)
{
}

static void pack(const ema_finding_t* told)
{
    EMA_ASSERT_STATUS(EMA_OK, ema_result_pack(&config, &result, told, packet));
    ASSERT_STATUS(EMA_IMAGE_OK, ema_result_unpack(packet, EMA_TELEMETRY_BYTES, &read));
}

static void test_what_is_packed_is_read(void)
{
    pack(&finding);
    TEST_ASSERT_EQUAL_HEX32(EMA_VERSION, read.software);
    TEST_ASSERT_EQUAL_HEX32(EMA_CONFIG_SCHEMA, read.schema);
    TEST_ASSERT_EQUAL_HEX32(ema_actuator_identity(&actuator), read.identity);
    TEST_ASSERT_EQUAL_MEMORY(&result, &read.result, sizeof result);
    TEST_ASSERT_TRUE(read.has_finding);
    TEST_ASSERT_EQUAL_MEMORY(&finding, &read.finding, sizeof finding);
    for (uint32_t k = 0; k < EMA_IDENTIFIED_MAX; ++k) {
        ema_real half_95 = EMA_R(0.0);
        EMA_ASSERT_STATUS(EMA_OK, ema_session_half_95(&config, &result, k, &half_95));
        TEST_ASSERT_TRUE((half_95 > EMA_R(0.0)) && (read.half_95[k] == (ema_real)(float)half_95));
        TEST_ASSERT_EQUAL_UINT16(config.identified[k].id, read.id[k]);
    }
    TEST_ASSERT_EQUAL_HEX8(0xA5U, packet[EMA_TELEMETRY_BYTES]);
}

static void test_fewer_values_and_no_finding(void)
{
    config.identified_count = 1U;
    result.identified_count = 1U;
    result.adequate = false;
    (void)memset(&result.identified[1], 0, 3U * sizeof result.identified[1]);
    pack(NULL);
    TEST_ASSERT_EQUAL_MEMORY(&result, &read.result, sizeof result);
    TEST_ASSERT_FALSE(read.has_finding);
    TEST_ASSERT_EQUAL_UINT16(0U, read.id[1]);
    TEST_ASSERT_TRUE(read.half_95[1] == EMA_R(0.0));
}

static void test_numbers_that_are_not_finite_are_carried(void)
{
    result.identified[0].std = (ema_real)NAN;
    result.identified[1].std = (ema_real)INFINITY;
    pack(&finding);
    TEST_ASSERT_TRUE(isnan(read.result.identified[0].std));
    TEST_ASSERT_TRUE(isinf(read.result.identified[1].std));
}

static void test_bytes_are_where_the_page_says(void)
{
    pack(&finding);
    TEST_ASSERT_EQUAL_MEMORY("EMAT\x01\x00\xF0\x00", packet, 8U);
    TEST_ASSERT_EQUAL_HEX32(EMA_VERSION, ema_image_rig_get(packet, 8U));
    TEST_ASSERT_EQUAL_HEX32(ema_actuator_identity(&actuator), ema_image_rig_get(packet, 16U));
    TEST_ASSERT_EQUAL_HEX32(result.reasons, ema_image_rig_get(packet, 20U));
    TEST_ASSERT_EQUAL_HEX8(EMA_VERDICT_UNDECIDED, packet[24]);
    TEST_ASSERT_EQUAL_HEX8(255U, packet[102]); /* no runner-up */
    const float first = (float)result.identified[0].estimate;
    uint32_t word = 0U;
    (void)memcpy(&word, &first, sizeof word);
    TEST_ASSERT_EQUAL_HEX32(word, ema_image_rig_get(packet, 144U));
    TEST_ASSERT_EQUAL_HEX32(ema_image_rig_crc(packet, CRC), ema_image_rig_get(packet, CRC));
}

static void test_what_cannot_be_packed_is_refused(void)
{
    uint8_t kept[EMA_TELEMETRY_BYTES];
    (void)memcpy(kept, packet, sizeof kept);
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_result_pack(NULL, &result, &finding, packet));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_result_pack(&config, NULL, &finding, packet));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_result_pack(&config, &result, &finding, NULL));
    result.identified_count = 2U;
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_result_pack(&config, &result, &finding, packet));
    result.identified_count = EMA_IDENTIFIED_MAX + 1U;
    config.identified_count = EMA_IDENTIFIED_MAX + 1U;
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_result_pack(&config, &result, &finding, packet));
    config.actuator = NULL;
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_result_pack(&config, &result, &finding, packet));
    TEST_ASSERT_EQUAL_MEMORY(kept, packet, sizeof kept);
}

static void assert_refused(ema_image_status_t expected, size_t length)
{
    ASSERT_STATUS(expected, ema_result_unpack(packet, length, &read));
    TEST_ASSERT_EQUAL_MEMORY(&before, &read, sizeof before);
}

static void test_every_length_and_every_bit_that_is_another_is_refused(void)
{
    EMA_ASSERT_STATUS(EMA_OK, ema_result_pack(&config, &result, &finding, packet));
    for (size_t length = 0; length < EMA_TELEMETRY_BYTES; ++length) {
        assert_refused(EMA_IMAGE_SHORT, length);
    }
    for (uint32_t bit = 0; bit < (8U * EMA_TELEMETRY_BYTES); ++bit) {
        static const ema_image_status_t head[] = {EMA_IMAGE_MAGIC, EMA_IMAGE_MAGIC, EMA_IMAGE_UNKNOWN_VERSION,
                                                  EMA_IMAGE_LENGTH};
        packet[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
        assert_refused((bit < 64U) ? head[bit / 16U] : EMA_IMAGE_CHECKSUM, EMA_TELEMETRY_BYTES);
        packet[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
    }
    ASSERT_STATUS(EMA_IMAGE_OK, ema_result_unpack(packet, sizeof packet, &read));
    ASSERT_STATUS(EMA_IMAGE_NULL, ema_result_unpack(NULL, sizeof packet, &read));
    ASSERT_STATUS(EMA_IMAGE_NULL, ema_result_unpack(packet, sizeof packet, NULL));
}

/* Under a checksum that is right. */
static void test_numbers_that_mean_nothing_are_refused(void)
{
    static const uint8_t places[] = {24U, 25U, 27U, 100U};
    for (size_t k = 0; k < sizeof places; ++k) {
        EMA_ASSERT_STATUS(EMA_OK, ema_result_pack(&config, &result, &finding, packet));
        packet[places[k]] = 5U;
        ema_image_rig_put(packet, CRC, ema_image_rig_crc(packet, CRC));
        assert_refused(EMA_IMAGE_LAYOUT, EMA_TELEMETRY_BYTES);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_what_is_packed_is_read);
    RUN_TEST(test_fewer_values_and_no_finding);
    RUN_TEST(test_numbers_that_are_not_finite_are_carried);
    RUN_TEST(test_bytes_are_where_the_page_says);
    RUN_TEST(test_what_cannot_be_packed_is_refused);
    RUN_TEST(test_every_length_and_every_bit_that_is_another_is_refused);
    RUN_TEST(test_numbers_that_mean_nothing_are_refused);
    return UNITY_END();
}
