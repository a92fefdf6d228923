/* Grease and winding beside CSJ and BLK: a warm day is no fault, and a search without them is what it was. */
#include "ema/ema.h"

#include <math.h>

#include "ema_rig.h"

#define ROWS 10000U

static ema_real buffer[ROWS * 2U];
static ema_actuator_t healthy;
static ema_record_config_t record;
static ema_session_config_t config;
static ema_session_t session;
static ema_result_t result;

void setUp(void)
{
    healthy = ema_rig_actuator();
    healthy.options.day_values = 1;
    healthy.options.evaluation_budget = 800;
    record = ema_rig_real_record(buffer, sizeof buffer, false);
    EMA_ASSERT_STATUS(EMA_OK, ema_session_config_default(&config, &healthy, &record));
}

void tearDown(void)
{
}

/* The record of a chirp, as the rig's machine with these shares of its healthy values leaves it. */
static void identify(ema_real csj, ema_real blk, ema_real grease, ema_real winding)
{
    ema_actuator_t today = healthy;
    today.params.csj_Nm *= csj;
    today.params.blk_mm *= blk;
    today.params.viscous_Nm_s_per_rad *= grease;
    today.params.resistance_ohm *= winding;
    const ema_command_t chirp = ema_rig_chirp(EMA_R(4.0), EMA_R(10.0), healthy.params.step_s);
    ema_model_t model = ema_rig_model(&today, EMA_R(0.0));
    EMA_ASSERT_STATUS(EMA_OK, ema_session_init(&session, &config));
    for (uint32_t row = 0; row < ROWS; ++row) {
        const ema_real command_mm = ema_command_at(&chirp, row);
        const ema_output_t shown = ema_rig_step(&model, command_mm);
        const ema_sample_t sample = {command_mm, {shown.position_mm, EMA_R(0.0), EMA_R(0.0), EMA_R(0.0)}};
        EMA_ASSERT_STATUS(EMA_OK, ema_session_feed(&session, &sample));
    }
    while (ema_session_phase(&session) != EMA_PHASE_DONE) {
        EMA_ASSERT_STATUS(EMA_OK, ema_session_run(&session, 100000U));
    }
    EMA_ASSERT_STATUS(EMA_OK, ema_session_result(&session, &result));
}

/* A winding 20 degrees warmer in grease of half the viscosity. */
static void test_a_warm_day_is_healthy_where_it_is_searched_for_and_not_where_it_is_not(void)
{
    identify(EMA_R(1.0), EMA_R(1.0), EMA_R(0.5), EMA_R(1.08));
    TEST_ASSERT_NOT_EQUAL(EMA_VERDICT_HEALTHY, result.verdict);
    EMA_ASSERT_STATUS(EMA_OK, ema_session_config_day(&config));
    TEST_ASSERT_EQUAL_UINT32(4U, config.identified_count);
    identify(EMA_R(1.0), EMA_R(1.0), EMA_R(0.5), EMA_R(1.08));
    TEST_ASSERT_EQUAL(EMA_VERDICT_HEALTHY, result.verdict);
    TEST_ASSERT_FLOAT_WITHIN(2.0, -50.0, (float)result.identified[2].shift_percent);
    TEST_ASSERT_FLOAT_WITHIN(0.5, 8.0, (float)result.identified[3].shift_percent);
}

static void test_wear_on_a_cold_day_is_a_fault_of_its_true_size(void)
{
    EMA_ASSERT_STATUS(EMA_OK, ema_session_config_day(&config));
    identify(EMA_R(1.2), EMA_R(1.5), EMA_R(1.6), EMA_R(0.92));
    TEST_ASSERT_EQUAL(EMA_VERDICT_FAULT, result.verdict);
    TEST_ASSERT_FLOAT_WITHIN(0.5, 20.0, (float)result.identified[0].shift_percent);
    TEST_ASSERT_FLOAT_WITHIN(2.0, 50.0, (float)result.identified[1].shift_percent);
}

/* 16 degrees colder, of which copper loses 6.3 % and a grease gains 57 %; the friction of this machine gains 1 % a
 * degree. */
static void test_friction_of_a_cold_day_is_stated_as_at_the_temperature_of_the_healthy_runs(void)
{
    healthy.params.csj_per_degC_percent = EMA_R(-1.0);
    healthy.params.csj_per_degC_std_percent = EMA_R(0.1);
    healthy.params.csj_day_scatter_percent = EMA_R(0.5);
    healthy.params.day_winding_ratio = EMA_R(0.2);
    healthy.params.day_apart_degC = EMA_R(5.0);
    EMA_ASSERT_STATUS(EMA_OK, ema_session_config_day(&config));
    identify(EMA_R(1.16), EMA_R(1.0), EMA_R(1.565), EMA_R(0.937));
    TEST_ASSERT_EQUAL(EMA_VERDICT_HEALTHY, result.verdict);
    TEST_ASSERT_FLOAT_WITHIN(0.5, 0.0, (float)result.identified[0].shift_percent);
    TEST_ASSERT_FLOAT_WITHIN(0.001, 0.138, (float)result.identified[0].estimate);
    TEST_ASSERT_FLOAT_WITHIN(0.001, 1.16 * 0.138, (float)result.identified[0].today);
    TEST_ASSERT_FLOAT_WITHIN(0.1, sqrt((0.5 * 0.5) + (1.6 * 1.6)), (float)result.identified[0].scatter_percent);
    identify(EMA_R(1.508), EMA_R(1.0), EMA_R(1.565), EMA_R(0.937));
    TEST_ASSERT_EQUAL(EMA_VERDICT_FAULT, result.verdict);
    TEST_ASSERT_FLOAT_WITHIN(0.7, 30.0, (float)result.identified[0].shift_percent);
    /* aged grease at the temperature of the healthy runs */
    identify(EMA_R(1.16), EMA_R(1.0), EMA_R(1.565), EMA_R(1.0));
    TEST_ASSERT_FLOAT_WITHIN(0.5, 16.0, (float)result.identified[0].shift_percent);
    TEST_ASSERT_TRUE(result.identified[0].estimate == result.identified[0].today);
}

static void test_without_the_option_nothing_is_added(void)
{
    healthy.options.day_values = 0;
    const uint32_t stall = config.annealer.stall_evaluations;
    EMA_ASSERT_STATUS(EMA_OK, ema_session_config_day(&config));
    TEST_ASSERT_EQUAL_UINT32(2U, config.identified_count);
    TEST_ASSERT_EQUAL_UINT32(stall, config.annealer.stall_evaluations);
}

static void test_a_value_that_the_actuator_has_not_is_not_searched(void)
{
    healthy.params.viscous_Nm_s_per_rad = EMA_R(0.0);
    const uint32_t stall = config.annealer.stall_evaluations;
    EMA_ASSERT_STATUS(EMA_OK, ema_session_config_day(&config));
    TEST_ASSERT_EQUAL_UINT32(3U, config.identified_count);
    TEST_ASSERT_EQUAL_UINT32(EMA_VALUE_ID(resistance_ohm), config.identified[2].id);
    TEST_ASSERT_EQUAL_UINT32((stall / 2U) * 3U, config.annealer.stall_evaluations);
}

static void test_refusals_change_nothing(void)
{
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_session_config_day(NULL));
    EMA_ASSERT_STATUS(EMA_OK, ema_session_config_day(&config));
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_session_config_day(&config));
    TEST_ASSERT_EQUAL_UINT32(4U, config.identified_count);
    config.identified_count = 0U;
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_session_config_day(&config));
    config.actuator = NULL;
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_session_config_day(&config));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_warm_day_is_healthy_where_it_is_searched_for_and_not_where_it_is_not);
    RUN_TEST(test_wear_on_a_cold_day_is_a_fault_of_its_true_size);
    RUN_TEST(test_friction_of_a_cold_day_is_stated_as_at_the_temperature_of_the_healthy_runs);
    RUN_TEST(test_without_the_option_nothing_is_added);
    RUN_TEST(test_a_value_that_the_actuator_has_not_is_not_searched);
    RUN_TEST(test_refusals_change_nothing);
    return UNITY_END();
}
