/* The warnings of a search's settings: each rule from both sides, the session's own numbers, and the texts. */
#include <math.h>

#include "ema/ema.h"
#include "ema_rig.h"

/* 5 um rms at 1 kHz. */
#define RESOLUTION EMA_R(2.5e-8)

static ema_annealer_config_t config;

void setUp(void)
{
    const ema_annealer_config_t shipped = {.dimension = 2U,
                                           .start = {EMA_R(0.1), EMA_R(0.3)},
                                           .first_step = EMA_R(0.2),
                                           .initial_temperature = EMA_R(0.05),
                                           .cooling = EMA_R(0.87),
                                           .function_tolerance = EMA_R(1.0e-13),
                                           .stall_evaluations = 40U,
                                           .reanneal_interval = 60U,
                                           .evaluation_budget = 400U,
                                           .seed = 1U};
    config = shipped;
}

void tearDown(void)
{
}

static void expect(uint32_t warnings, unsigned line)
{
    UNITY_TEST_ASSERT_EQUAL_HEX32(warnings, ema_annealer_check(&config, RESOLUTION), line, "warnings");
    setUp();
}

static void test_shipped_settings_have_no_warning(void)
{
    expect(0U, __LINE__);
    TEST_ASSERT_EQUAL_HEX32(0U, ema_annealer_check(NULL, RESOLUTION));
}

static void test_start_outside_the_box(void)
{
    const ema_real outside[3] = {EMA_R(-0.001), EMA_R(1.001), (ema_real)NAN};
    for (uint32_t k = 0; k < 3U; ++k) {
        config.start[1] = outside[k];
        expect((uint32_t)EMA_WARNING_START, __LINE__);
    }
    config.start[0] = EMA_R(0.0);
    config.start[1] = EMA_R(1.0);
    config.start[2] = (ema_real)NAN; /* beyond the dimension */
    expect(0U, __LINE__);
}

static void test_thirty_evaluations_for_each_dimension(void)
{
    config.cooling = EMA_R(0.7);
    config.evaluation_budget = 60U;
    expect(0U, __LINE__);
    config.cooling = EMA_R(0.7);
    config.evaluation_budget = 59U;
    expect((uint32_t)EMA_WARNING_FEW, __LINE__);
    config.dimension = 3U;
    config.cooling = EMA_R(0.7);
    config.evaluation_budget = 89U;
    expect((uint32_t)EMA_WARNING_FEW, __LINE__);
}

/* From 0.05 to thirty times the resolution: ln(6.7e4) / -ln(cooling) evaluations. */
static void test_evaluations_that_end_while_it_is_hot(void)
{
    const double fall = log(0.05 / 7.5e-7);
    config.cooling = (ema_real)exp(-fall / 395.0);
    expect(0U, __LINE__);
    config.cooling = (ema_real)exp(-fall / 405.0);
    expect((uint32_t)EMA_WARNING_HOT, __LINE__);
    config.initial_temperature = EMA_R(1.0e6);
    config.cooling = EMA_R(0.94);
    expect((uint32_t)EMA_WARNING_HOT, __LINE__);
    config.initial_temperature = EMA_R(7.0e-7); /* cold from the beginning */
    config.cooling = EMA_R(0.9999);
    expect(0U, __LINE__);
}

static void test_temperature_far_below_the_tolerance(void)
{
    config.function_tolerance = EMA_R(1.0e-8);
    config.initial_temperature = EMA_R(1.1e-11);
    expect(0U, __LINE__);
    config.function_tolerance = EMA_R(1.0e-8);
    config.initial_temperature = EMA_R(0.9e-11);
    expect((uint32_t)EMA_WARNING_COLD, __LINE__);
}

static void test_tolerance_that_ends_too_soon(void)
{
    config.function_tolerance = EMA_R(2.4e-6);
    expect(0U, __LINE__);
    config.function_tolerance = EMA_R(2.6e-6);
    expect((uint32_t)EMA_WARNING_TOLERANCE, __LINE__);
}

static void test_reannealing_that_never_lets_it_cool(void)
{
    config.reanneal_interval = 10U;
    expect(0U, __LINE__);
    config.reanneal_interval = 9U;
    expect((uint32_t)EMA_WARNING_REANNEALED, __LINE__);
    config.reanneal_interval = 0U; /* never reanneals */
    expect(0U, __LINE__);
}

static void test_without_a_resolution_the_tolerance_takes_its_place(void)
{
    const ema_real unknown[4] = {EMA_R(0.0), EMA_R(-1.0), (ema_real)NAN, (ema_real)INFINITY};
    for (uint32_t k = 0; k < 4U; ++k) {
        TEST_ASSERT_EQUAL_HEX32(0U, ema_annealer_check(&config, unknown[k]));
        config.function_tolerance = EMA_R(2.6e-6);
        TEST_ASSERT_EQUAL_HEX32(0U, ema_annealer_check(&config, unknown[k]));
        config.cooling = EMA_R(0.985);
        TEST_ASSERT_EQUAL_HEX32(EMA_WARNING_HOT, ema_annealer_check(&config, unknown[k]));
        config.function_tolerance = EMA_R(0.0); /* nothing is known of what matters */
        TEST_ASSERT_EQUAL_HEX32(0U, ema_annealer_check(&config, unknown[k]));
        setUp();
    }
}

/* What ema_annealer_init refuses is not judged, and read no farther than it goes. */
static void test_settings_that_mean_nothing(void)
{
    const ema_real cooling[3] = {EMA_R(0.0), EMA_R(1.0), (ema_real)NAN};
    for (uint32_t k = 0; k < 3U; ++k) {
        config.cooling = cooling[k];
        expect(0U, __LINE__);
    }
    config.initial_temperature = (ema_real)INFINITY;
    expect(0U, __LINE__);
    config.dimension = 1000000U;
    expect((uint32_t)EMA_WARNING_FEW, __LINE__);
}

static void test_several_warnings_at_once(void)
{
    config.evaluation_budget = 20U;
    config.reanneal_interval = 1U;
    expect((uint32_t)EMA_WARNING_FEW | (uint32_t)EMA_WARNING_REANNEALED | (uint32_t)EMA_WARNING_HOT, __LINE__);
}

static void test_session_knows_its_start_and_its_sensor(void)
{
    static ema_real buffer[200];
    ema_actuator_t actuator = ema_rig_actuator();
    const ema_record_config_t record = ema_rig_real_record(buffer, sizeof buffer, false);
    ema_session_config_t session;
    EMA_ASSERT_STATUS(EMA_OK, ema_session_config_default(&session, &actuator, &record));
    TEST_ASSERT_EQUAL_HEX32(0U, ema_session_check(&session));
    /* for a sensor of 0.5 nm the search ends too hot, and by a tolerance that is too large */
    session.annealer.evaluation_budget = 59U;
    session.annealer.cooling = EMA_R(0.8);
    TEST_ASSERT_EQUAL_HEX32(EMA_WARNING_FEW, ema_session_check(&session));
    actuator.params.position_noise_mm = EMA_R(5.0e-7);
    TEST_ASSERT_EQUAL_HEX32((uint32_t)EMA_WARNING_FEW | (uint32_t)EMA_WARNING_HOT | (uint32_t)EMA_WARNING_TOLERANCE,
                            ema_session_check(&session));
    /* with another signal in the objective its noise is not known */
    session.weight[EMA_CHANNEL_CURRENT] = EMA_R(1.0);
    session.annealer.evaluation_budget = 400U;
    TEST_ASSERT_EQUAL_HEX32(0U, ema_session_check(&session));
    session.identified[0].lower = EMA_R(0.2);
    TEST_ASSERT_EQUAL_HEX32(EMA_WARNING_START, ema_session_check(&session));
    session.start_at_healthy = false;
    session.annealer.start[0] = EMA_R(0.5);
    TEST_ASSERT_EQUAL_HEX32(0U, ema_session_check(&session));
    session.identified_count = 1000000U;
    TEST_ASSERT_EQUAL_HEX32(0U, ema_session_check(&session));
    session.weight[EMA_CHANNEL_POSITION] = EMA_R(0.0);
    session.annealer.evaluation_budget = 40U;
    session.identified_count = 1U;
    TEST_ASSERT_EQUAL_HEX32(EMA_WARNING_HOT, ema_session_check(&session));
    session.actuator = NULL;
    TEST_ASSERT_EQUAL_HEX32(0U, ema_session_check(&session));
    TEST_ASSERT_EQUAL_HEX32(0U, ema_session_check(NULL));
}

static void test_every_warning_has_its_own_bit_and_text(void)
{
    static const struct {
        uint32_t bit;
        const char* text;
    } warnings[] = {
#define ROW(name, bit, text) {(uint32_t)(name), text},
        EMA_ANNEALER_WARNING_LIST(ROW)
#undef ROW
    };
    const size_t count = sizeof warnings / sizeof warnings[0];
    uint32_t seen = 0U;
    for (size_t k = 0; k < count; ++k) {
        TEST_ASSERT_EQUAL_HEX32((uint32_t)1U << k, warnings[k].bit);
        TEST_ASSERT_EQUAL_STRING(warnings[k].text, ema_annealer_warning_text(warnings[k].bit));
        seen |= warnings[k].bit;
    }
    TEST_ASSERT_EQUAL_STRING("unknown warning", ema_annealer_warning_text(0U));
    TEST_ASSERT_EQUAL_STRING("unknown warning", ema_annealer_warning_text(seen));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_shipped_settings_have_no_warning);
    RUN_TEST(test_start_outside_the_box);
    RUN_TEST(test_thirty_evaluations_for_each_dimension);
    RUN_TEST(test_evaluations_that_end_while_it_is_hot);
    RUN_TEST(test_temperature_far_below_the_tolerance);
    RUN_TEST(test_tolerance_that_ends_too_soon);
    RUN_TEST(test_reannealing_that_never_lets_it_cool);
    RUN_TEST(test_without_a_resolution_the_tolerance_takes_its_place);
    RUN_TEST(test_settings_that_mean_nothing);
    RUN_TEST(test_several_warnings_at_once);
    RUN_TEST(test_session_knows_its_start_and_its_sensor);
    RUN_TEST(test_every_warning_has_its_own_bit_and_text);
    return UNITY_END();
}
