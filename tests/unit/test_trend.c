/* Trend and time to a limit: what the desk's reference says of the same readings (tolerances and why:
 * tests/vectors/manifest.json), slices, refusals, and what becomes of older readings. */
#include "ema/ema.h"

#include <math.h>

#include "ema_close.h"

/* The bits of an ema_real, as the tables hold them. */
#if EMA_REAL64
typedef uint64_t ema_vec_bits_t;
#else
typedef uint32_t ema_vec_bits_t;
#endif

#include "ema_vec_trend.inc"

#define ASSERT_STATUS(expected, actual) TEST_ASSERT_EQUAL_STRING(ema_trend_text(expected), ema_trend_text(actual))

static EMA_GUARDED(ema_trend_t) kept;
static EMA_GUARDED(ema_forecast_t) worked;
static ema_trend_config_t config;
static ema_outlook_t outlook;

void setUp(void)
{
    EMA_GUARD_SET(kept);
    EMA_GUARD_SET(worked);
    config = (ema_trend_config_t){EMA_R(50.0), EMA_R(0.01)};
    ASSERT_STATUS(EMA_TREND_OK, ema_trend_init(&kept.value, 7U));
}

void tearDown(void)
{
    EMA_ASSERT_GUARDS(kept);
    EMA_ASSERT_GUARDS(worked);
}

static ema_real number(ema_vec_bits_t bits)
{
    ema_real value;
    (void)memcpy(&value, &bits, sizeof value);
    return value;
}

static void take(ema_real day, ema_real value, ema_real std)
{
    const ema_reading_t reading = {day, value, std};
    ASSERT_STATUS(EMA_TREND_OK, ema_trend_update(&kept.value, &reading));
}

static void look(uint32_t slice)
{
    ASSERT_STATUS(EMA_TREND_OK, ema_forecast_start(&worked.value, &kept.value, &config));
    while (!ema_forecast_done(&worked.value)) {
        ASSERT_STATUS(EMA_TREND_OK, ema_forecast_run(&worked.value, slice));
    }
    (void)memset(&outlook, 0xA5, sizeof outlook);
    ASSERT_STATUS(EMA_TREND_OK, ema_forecast_result(&worked.value, &outlook));
}

static ema_real open_or(const ema_time_left_t* left)
{
    return left->open ? EMA_R(-1.0) : left->days;
}

static void assert_said(const ema_vec_bits_t* bits)
{
    const ema_real found[EMA_VEC_TREND_COLUMNS] = {outlook.odds_log,
                                                   outlook.now_percent,
                                                   outlook.now_std_percent,
                                                   outlook.by_percent,
                                                   outlook.rate_percent_per_day,
                                                   outlook.rate_std_percent_per_day,
                                                   open_or(&outlook.low),
                                                   open_or(&outlook.median),
                                                   open_or(&outlook.high),
                                                   outlook.reached_ratio,
                                                   outlook.drifts ? EMA_R(1.0) : EMA_R(0.0),
                                                   outlook.towards ? EMA_R(1.0) : EMA_R(0.0)};
    ema_real said[EMA_VEC_TREND_COLUMNS];
    for (uint32_t column = 0; column < EMA_VEC_TREND_COLUMNS; ++column) {
        said[column] = number(bits[column]);
    }
    EMA_ASSERT_CLOSE_ARRAY(said, found, EMA_VEC_TREND_COLUMNS, EMA_VEC_TREND_TOLERANCE, EMA_VEC_TREND_TOLERANCE);
}

#define VECTOR_TEST(case_name, CASE)                                                                                   \
    static void test_vector_##case_name(void)                                                                          \
    {                                                                                                                  \
        static const uint32_t looks[] = EMA_VEC_TREND_##CASE##_LOOKS;                                                  \
        uint32_t looked = 0;                                                                                           \
        config = (ema_trend_config_t){EMA_VEC_TREND_##CASE##_LIMIT, EMA_VEC_TREND_FALSE_ALARM};                        \
        for (uint32_t k = 0; k < EMA_VEC_TREND_##CASE##_READINGS; ++k) {                                               \
            const ema_vec_bits_t* const row = ema_vec_trend_##case_name##_readings[k];                                 \
            take(number(row[0]), number(row[1]), number(row[2]));                                                      \
            if ((looked < (sizeof looks / sizeof looks[0])) && (looks[looked] == (k + 1U))) {                          \
                look(100U);                                                                                            \
                assert_said(ema_vec_trend_##case_name##_said[looked]);                                                 \
                ++looked;                                                                                              \
            }                                                                                                          \
        }                                                                                                              \
        TEST_ASSERT_EQUAL_UINT32(sizeof looks / sizeof looks[0], looked);                                              \
    }
EMA_VEC_TREND_CASES(VECTOR_TEST)

/* 90 readings of a unit that wears by 0.03 % a day. */
static void wear(uint32_t count)
{
    for (uint32_t k = 0; k < count; ++k) {
        const ema_real day = EMA_R(7.0) * (ema_real)k;
        take(day, (EMA_R(0.03) * day) + (EMA_R(0.25) * (ema_real)(int32_t)(k * 7U % 5U)), EMA_R(0.5));
    }
}

static void test_slices_change_no_bit(void)
{
    wear(90U);
    look(EMA_FORECAST_LAWS);
    const ema_outlook_t whole = outlook;
    static const uint32_t slices[] = {1U, 3U, 97U, UINT32_MAX};
    for (size_t k = 0; k < sizeof slices / sizeof slices[0]; ++k) {
        look(slices[k]);
        TEST_ASSERT_EQUAL_MEMORY(&whole, &outlook, sizeof whole);
    }
    TEST_ASSERT_TRUE(whole.drifts && whole.towards && !whole.high.open);
    EMA_ASSERT_CLOSE(EMA_R(0.03), whole.rate_percent_per_day, 0.006, 0.0);
}

static void test_memory_is_bounded(void)
{
    TEST_ASSERT_TRUE((EMA_REAL64 != 0) || ((sizeof(ema_trend_t) <= 1024U) && (sizeof(ema_forecast_t) <= 1024U)));
    wear(500U);
    TEST_ASSERT_EQUAL_UINT32(500U, kept.value.readings);
    kept.value.readings = 0x7FFFFFFEU;
    take(EMA_R(3500.0), EMA_R(0.0), EMA_R(0.5));
    take(EMA_R(3507.0), EMA_R(0.0), EMA_R(0.5));
    TEST_ASSERT_EQUAL_UINT32(0x7FFFFFFFU, kept.value.readings);
    TEST_ASSERT_EQUAL_UINT32(EMA_TREND_KNOTS, kept.value.count);
    for (uint32_t k = 1; k < kept.value.count; ++k) {
        TEST_ASSERT_TRUE(kept.value.knot[k].time_days > kept.value.knot[k - 1U].time_days);
    }
}

static void test_a_reading_far_off_counts_less(void)
{
    wear(20U);
    const ema_trend_t before = kept.value;
    take(EMA_R(140.0), EMA_R(45.0), EMA_R(0.5));
    take(EMA_R(147.0), EMA_R(4.5), EMA_R(0.5));
    take(EMA_R(154.0), EMA_R(4.75), EMA_R(0.5));
    TEST_ASSERT_TRUE(kept.value.knot[20].std_percent > EMA_R(20.0));
    TEST_ASSERT_TRUE(kept.value.scatter_ratio < (EMA_R(3.0) * before.scatter_ratio));
    look(EMA_FORECAST_LAWS);
    TEST_ASSERT_TRUE(outlook.now_percent < EMA_R(7.0));
}

static void test_what_is_no_reading_is_refused(void)
{
    wear(8U);
    const ema_trend_t before = kept.value;
    const ema_real nan = (ema_real)NAN;
    const ema_real infinite = (ema_real)INFINITY;
    const struct {
        ema_trend_status_t status;
        ema_reading_t reading;
    } wrong[] = {
        {EMA_TREND_TIME, {nan, EMA_R(1.0), EMA_R(1.0)}},
        {EMA_TREND_TIME, {infinite, EMA_R(1.0), EMA_R(1.0)}},
        {EMA_TREND_TIME, {EMA_R(1.1) * EMA_TREND_DAYS_MAX, EMA_R(1.0), EMA_R(1.0)}},
        {EMA_TREND_VALUE, {EMA_R(99.0), nan, EMA_R(1.0)}},
        {EMA_TREND_VALUE, {EMA_R(99.0), -infinite, EMA_R(1.0)}},
        {EMA_TREND_STD, {EMA_R(99.0), EMA_R(1.0), nan}},
        {EMA_TREND_STD, {EMA_R(99.0), EMA_R(1.0), EMA_R(0.0)}},
        {EMA_TREND_STD, {EMA_R(99.0), EMA_R(1.0), EMA_R(-1.0)}},
        {EMA_TREND_STD, {EMA_R(99.0), EMA_R(1.0), infinite}},
        {EMA_TREND_TIME_BACK, {EMA_R(48.9), EMA_R(1.0), EMA_R(1.0)}},
    };
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; ++k) {
        ASSERT_STATUS(wrong[k].status, ema_trend_update(&kept.value, &wrong[k].reading));
        TEST_ASSERT_EQUAL_MEMORY(&before, &kept.value, sizeof before);
    }
    ASSERT_STATUS(EMA_TREND_NULL, ema_trend_update(NULL, &wrong[0].reading));
    ASSERT_STATUS(EMA_TREND_NULL, ema_trend_update(&kept.value, NULL));
    ASSERT_STATUS(EMA_TREND_NULL, ema_trend_init(NULL, 0U));
    TEST_ASSERT_EQUAL_STRING("unknown status", ema_trend_text((ema_trend_status_t)99));
}

static void test_a_structure_that_was_never_started_is_refused(void)
{
    const ema_reading_t reading = {EMA_R(0.0), EMA_R(0.0), EMA_R(1.0)};
    wear(8U);
    const ema_trend_t sound = kept.value;
    for (uint32_t kind = 0; kind < 4U; ++kind) {
        kept.value = sound;
        kept.value.mark = (kind == 0U) ? 0U : sound.mark;
        kept.value.count = (kind == 1U) ? (EMA_TREND_KNOTS + 1U) : sound.count;
        kept.value.readings = (kind == 2U) ? (sound.count - 1U) : ((kind == 3U) ? 0x80000000U : 100U);
        ASSERT_STATUS(EMA_TREND_STALE, ema_trend_update(&kept.value, &reading));
        ASSERT_STATUS(EMA_TREND_STALE, ema_forecast_start(&worked.value, &kept.value, &config));
    }
    (void)memset(&worked.value, 0, sizeof worked.value);
    ASSERT_STATUS(EMA_TREND_STALE, ema_forecast_run(&worked.value, 1U));
    ASSERT_STATUS(EMA_TREND_STALE, ema_forecast_result(&worked.value, &outlook));
    TEST_ASSERT_TRUE(ema_forecast_done(&worked.value));
    TEST_ASSERT_TRUE(ema_forecast_done(NULL));
}

static void assert_no_start(ema_trend_status_t expected, ema_real limit, ema_real false_alarm)
{
    const ema_trend_config_t wrong = {limit, false_alarm};
    ASSERT_STATUS(expected, ema_forecast_start(&worked.value, &kept.value, &wrong));
}

static void test_what_cannot_be_foretold_is_refused(void)
{
    wear(EMA_TREND_READINGS_MIN - 1U);
    assert_no_start(EMA_TREND_FEW, EMA_R(50.0), EMA_R(0.01));
    take(EMA_R(35.0), EMA_R(1.0), EMA_R(0.5));
    look(EMA_FORECAST_LAWS);
    assert_no_start(EMA_TREND_LIMIT, EMA_R(0.0), EMA_R(0.01));
    assert_no_start(EMA_TREND_LIMIT, (ema_real)NAN, EMA_R(0.01));
    assert_no_start(EMA_TREND_LIMIT, (ema_real)INFINITY, EMA_R(0.01));
    assert_no_start(EMA_TREND_FALSE_ALARM, EMA_R(50.0), EMA_R(0.0));
    assert_no_start(EMA_TREND_FALSE_ALARM, EMA_R(50.0), EMA_R(0.6));
    assert_no_start(EMA_TREND_FALSE_ALARM, EMA_R(50.0), (ema_real)NAN);
    ASSERT_STATUS(EMA_TREND_NULL, ema_forecast_start(NULL, &kept.value, &config));
    ASSERT_STATUS(EMA_TREND_NULL, ema_forecast_start(&worked.value, NULL, &config));
    ASSERT_STATUS(EMA_TREND_NULL, ema_forecast_start(&worked.value, &kept.value, NULL));
    ASSERT_STATUS(EMA_TREND_OK, ema_trend_init(&kept.value, 7U));
    for (uint32_t k = 0; k < 8U; ++k) {
        take(EMA_R(3.0), EMA_R(1.0), EMA_R(0.5));
    }
    assert_no_start(EMA_TREND_FEW, EMA_R(50.0), EMA_R(0.01));
}

static void test_a_forecast_is_of_the_readings_it_began_with(void)
{
    wear(10U);
    ASSERT_STATUS(EMA_TREND_OK, ema_forecast_start(&worked.value, &kept.value, &config));
    ASSERT_STATUS(EMA_TREND_OK, ema_forecast_run(&worked.value, 5U));
    ASSERT_STATUS(EMA_TREND_UNFINISHED, ema_forecast_result(&worked.value, &outlook));
    ASSERT_STATUS(EMA_TREND_NULL, ema_forecast_run(NULL, 5U));
    ASSERT_STATUS(EMA_TREND_NULL, ema_forecast_result(NULL, &outlook));
    ASSERT_STATUS(EMA_TREND_NULL, ema_forecast_result(&worked.value, NULL));
    take(EMA_R(90.0), EMA_R(2.0), EMA_R(0.5));
    ASSERT_STATUS(EMA_TREND_CHANGED, ema_forecast_run(&worked.value, 5U));
    kept.value.mark = 0U;
    ASSERT_STATUS(EMA_TREND_STALE, ema_forecast_run(&worked.value, 5U));
}

/* Numbers at the ends of what is allowed leave no number that is not finite. */
static void test_the_ends_of_the_ranges_are_numbers(void)
{
    static const ema_real stds[] = {EMA_TREND_STD_MIN_PERCENT, EMA_TREND_PERCENT_MAX};
    static const ema_real limits[] = {EMA_TREND_LIMIT_MIN_PERCENT, -EMA_TREND_PERCENT_MAX};
    for (uint32_t kind = 0; kind < 8U; ++kind) {
        ASSERT_STATUS(EMA_TREND_OK, ema_trend_init(&kept.value, 7U));
        config.limit_percent = limits[kind % 2U];
        for (uint32_t k = 0; k < 60U; ++k) {
            const ema_real size = ((kind / 4U) == 0U) ? EMA_R(0.0) : EMA_TREND_PERCENT_MAX;
            take(((ema_real)k - EMA_R(30.0)) * EMA_R(30000.0), ((k % 2U) == 0U) ? size : -size, stds[(kind / 2U) % 2U]);
        }
        look(EMA_FORECAST_LAWS);
        const ema_real told[] = {outlook.odds_log,     outlook.now_percent,          outlook.now_std_percent,
                                 outlook.by_percent,   outlook.rate_percent_per_day, outlook.rate_std_percent_per_day,
                                 outlook.low.days,     outlook.median.days,          outlook.high.days,
                                 outlook.reached_ratio};
        for (size_t k = 0; k < sizeof told / sizeof told[0]; ++k) {
            TEST_ASSERT_TRUE(isfinite(told[k]));
        }
        TEST_ASSERT_TRUE((outlook.reached_ratio >= EMA_R(0.0)) && (outlook.reached_ratio <= EMA_R(1.0)));
    }
}

int main(void)
{
    UNITY_BEGIN();
#define RUN_VECTOR(case_name, CASE) RUN_TEST(test_vector_##case_name);
    EMA_VEC_TREND_CASES(RUN_VECTOR)
    RUN_TEST(test_slices_change_no_bit);
    RUN_TEST(test_memory_is_bounded);
    RUN_TEST(test_a_reading_far_off_counts_less);
    RUN_TEST(test_what_is_no_reading_is_refused);
    RUN_TEST(test_a_structure_that_was_never_started_is_refused);
    RUN_TEST(test_what_cannot_be_foretold_is_refused);
    RUN_TEST(test_a_forecast_is_of_the_readings_it_began_with);
    RUN_TEST(test_the_ends_of_the_ranges_are_numbers);
    return UNITY_END();
}
