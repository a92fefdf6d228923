/* A trend as bytes: what is restored continues as if nothing had been; what is no trend is refused with its reason. */
#include "ema/ema.h"

#include "ema_close.h"
#include "ema_image_rig.h"

#define CRC 608U
#define IDENTITY 0x1234ABCDU

#define ASSERT_STATUS(expected, actual) TEST_ASSERT_EQUAL_STRING(ema_trend_text(expected), ema_trend_text(actual))

static uint8_t bytes[EMA_TREND_BYTES + 3U];
static ema_trend_t trend;
static ema_trend_t other;
static ema_trend_t before;

void setUp(void)
{
    (void)memset(bytes, 0xA5, sizeof bytes);
    (void)memset(&other, 0xA5, sizeof other);
    (void)memcpy(&before, &other, sizeof before);
    ASSERT_STATUS(EMA_TREND_OK, ema_trend_init(&trend, IDENTITY));
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_HEX8(0xA5U, bytes[EMA_TREND_BYTES]);
}

static void take(ema_trend_t* to, uint32_t k)
{
    const ema_reading_t reading = {EMA_R(7300.1) + (EMA_R(3.3) * (ema_real)k), EMA_R(0.1) * (ema_real)(k * 37U % 100U),
                                   EMA_R(0.7)};
    ASSERT_STATUS(EMA_TREND_OK, ema_trend_update(to, &reading));
}

/* Float32 continues bit for bit; float64 has been rounded to float32 on the way. */
static void test_what_is_restored_continues(void)
{
    for (uint32_t k = 0; k < 120U; ++k) {
        take(&trend, k);
        ASSERT_STATUS(EMA_TREND_OK, ema_trend_save(&trend, bytes));
        ASSERT_STATUS(EMA_TREND_OK, ema_trend_restore(&other, IDENTITY, bytes, EMA_TREND_BYTES));
#if !EMA_REAL64
        TEST_ASSERT_EQUAL_MEMORY(&trend, &other, offsetof(ema_trend_t, knot) + (trend.count * sizeof trend.knot[0]));
#endif
    }
    uint8_t again[EMA_TREND_BYTES];
    ASSERT_STATUS(EMA_TREND_OK, ema_trend_save(&other, again));
    TEST_ASSERT_EQUAL_MEMORY(bytes, again, sizeof again);
    take(&trend, 120U);
    take(&other, 120U);
    TEST_ASSERT_EQUAL_UINT32(trend.count, other.count);
    EMA_ASSERT_CLOSE(trend.scatter_ratio, other.scatter_ratio, EMA_REAL64 ? 1e-5 : 0.0, 0.0);
    EMA_ASSERT_CLOSE(trend.knot[3].value_percent, other.knot[3].value_percent, EMA_REAL64 ? 1e-5 : 0.0, 0.0);
}

static void test_an_empty_one_is_carried(void)
{
    ASSERT_STATUS(EMA_TREND_OK, ema_trend_save(&trend, bytes));
    ASSERT_STATUS(EMA_TREND_OK, ema_trend_restore(&other, IDENTITY, bytes, sizeof bytes));
    TEST_ASSERT_EQUAL_MEMORY(&trend, &other, sizeof trend);
}

static void test_bytes_are_where_the_page_says(void)
{
    take(&trend, 0U);
    take(&trend, 1U);
    ASSERT_STATUS(EMA_TREND_OK, ema_trend_save(&trend, bytes));
    TEST_ASSERT_EQUAL_MEMORY("EMAW\x01\x00\x64\x02", bytes, 8U);
    TEST_ASSERT_EQUAL_HEX32(IDENTITY, ema_image_rig_get(bytes, 8U));
    TEST_ASSERT_EQUAL_UINT32(2U, ema_image_rig_get(bytes, 12U));
    TEST_ASSERT_EQUAL_UINT32(2U, ema_image_rig_get(bytes, 16U));
    TEST_ASSERT_EQUAL_UINT32(0U, ema_image_rig_get(bytes, 32U));
    TEST_ASSERT_EQUAL_HEX32(ema_image_rig_crc(bytes, CRC), ema_image_rig_get(bytes, CRC));
}

static void assert_refused(ema_trend_status_t expected, size_t length)
{
    ASSERT_STATUS(expected, ema_trend_restore(&other, IDENTITY, bytes, length));
    TEST_ASSERT_EQUAL_MEMORY(&before, &other, sizeof before);
}

static void test_every_length_and_every_bit_that_is_another_is_refused(void)
{
    for (uint32_t k = 0; k < 60U; ++k) {
        take(&trend, k);
    }
    ASSERT_STATUS(EMA_TREND_OK, ema_trend_save(&trend, bytes));
    for (size_t length = 0; length < EMA_TREND_BYTES; ++length) {
        assert_refused(EMA_TREND_SHORT, length);
    }
    for (uint32_t bit = 0; bit < (8U * EMA_TREND_BYTES); ++bit) {
        static const ema_trend_status_t head[] = {EMA_TREND_MAGIC, EMA_TREND_MAGIC, EMA_TREND_UNKNOWN_VERSION,
                                                  EMA_TREND_LENGTH};
        bytes[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
        assert_refused((bit < 64U) ? head[bit / 16U] : EMA_TREND_CHECKSUM, EMA_TREND_BYTES);
        bytes[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
    }
    ASSERT_STATUS(EMA_TREND_IDENTITY, ema_trend_restore(&other, IDENTITY + 1U, bytes, sizeof bytes));
    ASSERT_STATUS(EMA_TREND_NULL, ema_trend_restore(NULL, IDENTITY, bytes, sizeof bytes));
    ASSERT_STATUS(EMA_TREND_NULL, ema_trend_restore(&other, IDENTITY, NULL, sizeof bytes));
    ASSERT_STATUS(EMA_TREND_NULL, ema_trend_save(NULL, bytes));
    ASSERT_STATUS(EMA_TREND_NULL, ema_trend_save(&trend, NULL));
    trend.mark = 0U;
    ASSERT_STATUS(EMA_TREND_STALE, ema_trend_save(&trend, bytes));
    ASSERT_STATUS(EMA_TREND_OK, ema_trend_restore(&other, IDENTITY, bytes, sizeof bytes));
}

/* Under a checksum that is right. */
static void test_numbers_that_mean_nothing_are_refused(void)
{
    static const uint32_t nan = 0x7FC00000U;
    static const uint32_t infinite = 0x7F800000U;
    static const uint32_t minus = 0xBF800000U; /* -1 */
    static const uint32_t large = 0x4E000000U; /* 5e8 */
    static const uint32_t early = 0xCE000000U; /* -5e8 */
    const struct {
        uint32_t place;
        uint32_t word;
    } wrong[] = {{16U, EMA_TREND_KNOTS + 1U},
                 {16U, 61U},
                 {12U, 3U},
                 {12U, 0x80000000U},
                 {20U, nan},
                 {20U, large},
                 {20U, early},
                 {24U, nan},
                 {24U, minus},
                 {24U, large},
                 {28U, nan},
                 {28U, minus},
                 {28U, infinite},
                 {32U, nan},
                 {32U, minus},
                 {44U, minus},
                 {32U, large},
                 {36U, nan},
                 {36U, large},
                 {40U, nan},
                 {40U, 0U},
                 {40U, large}};
    for (uint32_t k = 0; k < 20U; ++k) {
        take(&trend, k);
    }
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; ++k) {
        ASSERT_STATUS(EMA_TREND_OK, ema_trend_save(&trend, bytes));
        ema_image_rig_put(bytes, wrong[k].place, wrong[k].word);
        ema_image_rig_put(bytes, CRC, ema_image_rig_crc(bytes, CRC));
        assert_refused(EMA_TREND_LAYOUT, EMA_TREND_BYTES);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_what_is_restored_continues);
    RUN_TEST(test_an_empty_one_is_carried);
    RUN_TEST(test_bytes_are_where_the_page_says);
    RUN_TEST(test_every_length_and_every_bit_that_is_another_is_refused);
    RUN_TEST(test_numbers_that_mean_nothing_are_refused);
    return UNITY_END();
}
