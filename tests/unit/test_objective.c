/* The objective: equal to the direct sum, whatever the slices, and given up without changing what it says. */
#include <math.h>

#include "ema/ema.h"
#include "ema_rig.h"

#define ROWS 2000U

static ema_real memory[5U * ROWS];
static ema_actuator_t actuator; /* of the record */
static ema_actuator_t other;    /* of the model that is compared */
static ema_command_t command;
static ema_record_t record;
static const ema_real position_only[EMA_CHANNEL_COUNT] = {EMA_R(1.0), EMA_R(0.0), EMA_R(0.0), EMA_R(0.0)};
static const ema_real all_channels[EMA_CHANNEL_COUNT] = {EMA_R(1.0), EMA_R(0.5), EMA_R(0.01), EMA_R(0.002)};

void setUp(void)
{
    const ema_record_config_t config = ema_rig_real_record(memory, sizeof memory, true);
    actuator = ema_rig_actuator();
    command = ema_rig_chirp(EMA_R(4.0), EMA_R(2.0), EMA_R(1.0e-3));
    actuator.params.csj_Nm = EMA_R(0.3);
    actuator.params.blk_mm = EMA_R(0.04125);
    ema_rig_record(&record, &config, &actuator, &command, ROWS);
    other = ema_rig_actuator();
}

void tearDown(void)
{
}

static ema_objective_t started(const ema_real* weight, ema_real limit)
{
    ema_objective_t objective;
    EMA_ASSERT_STATUS(EMA_OK, ema_objective_start(&objective, &other, &record, weight, EMA_R(0.0), limit));
    return objective;
}

static ema_real value_of(const ema_real* weight)
{
    ema_objective_t objective = started(weight, EMA_COST_MAX);
    TEST_ASSERT_EQUAL_INT(EMA_OBJECTIVE_DONE, ema_objective_run(&objective, UINT32_MAX));
    return ema_objective_value(&objective);
}

/* The same sum in double, from a model of its own. */
static double direct(const ema_real* weight)
{
    ema_model_t model = ema_rig_model(&other, EMA_R(0.0));
    double sum = 0.0;
    for (uint32_t row = 0; row < record.count; ++row) {
        ema_sample_t sample;
        EMA_ASSERT_STATUS(EMA_OK, ema_record_read(&record, row, 1U, &sample));
        const ema_output_t out = ema_rig_step(&model, sample.command_mm);
        const ema_real simulated[EMA_CHANNEL_COUNT] = {out.position_mm, out.motor_position_mm, out.current_A,
                                                       out.voltage_V};
        for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
            const double error = (double)sample.channel[channel] - (double)simulated[channel];
            sum += (double)weight[channel] * error * error * 1.0e-3;
        }
    }
    return sum;
}

static void test_value_is_the_direct_sum(void)
{
    const double expected = direct(position_only);
    TEST_ASSERT_TRUE(expected > 0.01);
    EMA_ASSERT_CLOSE(expected, value_of(position_only), 0.0, EMA_BY_PRECISION(1.0e-6, 1.0e-14));
}

static void test_weighted_channels_are_the_direct_sum(void)
{
    EMA_ASSERT_CLOSE(direct(all_channels), value_of(all_channels), 0.0, EMA_BY_PRECISION(1.0e-6, 1.0e-14));
    TEST_ASSERT_TRUE(direct(all_channels) > (1.1 * direct(position_only)));
}

static void test_weights_scale_the_value(void)
{
    const ema_real twice[EMA_CHANNEL_COUNT] = {EMA_R(2.0), EMA_R(0.0), EMA_R(0.0), EMA_R(0.0)};
    const ema_real current[EMA_CHANNEL_COUNT] = {EMA_R(0.0), EMA_R(0.0), EMA_R(1.0), EMA_R(0.0)};
    TEST_ASSERT_TRUE(value_of(twice) == (EMA_R(2.0) * value_of(position_only)));
    EMA_ASSERT_CLOSE(direct(current), value_of(current), 0.0, EMA_BY_PRECISION(1.0e-6, 1.0e-14));
}

static void test_value_at_the_truth_is_zero(void)
{
    other = actuator;
    TEST_ASSERT_TRUE(value_of(all_channels) == EMA_R(0.0));
}

static void test_slices_change_no_bit(void)
{
    const uint32_t slices[4] = {1U, 7U, 1000U, UINT32_MAX};
    const ema_real expected = value_of(all_channels);
    ema_objective_t whole = started(all_channels, EMA_COST_MAX);
    (void)ema_objective_run(&whole, UINT32_MAX);
    for (uint32_t k = 0; k < 4U; ++k) {
        ema_objective_t sliced = started(all_channels, EMA_COST_MAX);
        uint32_t calls = 0U;
        while (ema_objective_run(&sliced, slices[k]) == EMA_OBJECTIVE_RUNNING) {
            ++calls;
        }
        /* steps in which something is located count as more */
        TEST_ASSERT_TRUE((calls >= ((ROWS - 1U) / slices[k])) && (calls < ROWS));
        TEST_ASSERT_TRUE((slices[k] > 1U) || (calls == (ROWS - 1U)));
        TEST_ASSERT_TRUE(ema_objective_value(&sliced) == expected);
        EMA_ASSERT_SAME_BITS(&whole.model.state, &sliced.model.state, sizeof whole.model.state);
    }
}

/* Model steps of the first slices of 200, and the most that one of a single step has counted, which its structure
 * bounds. */
static uint32_t first_slices(ema_real csj_Nm, ema_real stribeck_rise, uint32_t* dearest)
{
    other.params.csj_Nm = csj_Nm;
    EMA_ASSERT_STATUS(EMA_OK, ema_actuator_set(&other, EMA_EFFECT_VALUE_ID(stribeck_friction, rise), stribeck_rise));
    ema_objective_t objective = started(position_only, EMA_COST_MAX);
    const uint32_t most = EMA_STEP_WORK_MAX(objective.model.plant.substeps, objective.model.plant.forces_work);
    for (uint32_t slice = 0; slice < 4U; ++slice) {
        (void)ema_objective_run(&objective, 200U);
        TEST_ASSERT_TRUE(objective.model.work.spent >= 200U);
        TEST_ASSERT_TRUE(objective.model.work.spent < (200U + most));
    }
    const uint32_t made = objective.model.state.step;
    *dearest = 0U;
    while (ema_objective_run(&objective, 1U) == EMA_OBJECTIVE_RUNNING) {
        const uint32_t spent = objective.model.work.spent;
        TEST_ASSERT_TRUE(spent <= most);
        *dearest = (spent > *dearest) ? spent : *dearest;
    }
    return made;
}

/* A shaft that friction holds is the plain case; events and effects make a slice shorter, by no more than they count.
 */
static void test_work_of_a_slice_is_what_its_steps_take(void)
{
    uint32_t held = 0U;
    uint32_t unheld = 0U;
    uint32_t resisted = 0U;
    TEST_ASSERT_EQUAL_UINT32(800U, first_slices(EMA_R(8.0), EMA_R(0.0), &held));
    const uint32_t moving = first_slices(EMA_R(0.138), EMA_R(0.0), &unheld);
    TEST_ASSERT_TRUE((moving < 800U) && (moving > 700U));
    TEST_ASSERT_TRUE((held >= 1U) && (unheld > EMA_WORK_SERIES));
    const uint32_t slower = first_slices(EMA_R(0.138), EMA_R(0.1), &resisted);
    TEST_ASSERT_TRUE((slower < 300U) && (resisted > unheld));
}

static void test_slice_of_no_steps_does_nothing(void)
{
    ema_objective_t objective = started(position_only, EMA_COST_MAX);
    TEST_ASSERT_EQUAL_INT(EMA_OBJECTIVE_RUNNING, ema_objective_run(&objective, 0U));
    TEST_ASSERT_EQUAL_UINT32(0U, objective.model.state.step);
    TEST_ASSERT_TRUE(ema_objective_value(&objective) == EMA_R(0.0));
}

static void test_value_only_grows(void)
{
    ema_objective_t objective = started(position_only, EMA_COST_MAX);
    ema_real last = EMA_R(0.0);
    while (ema_objective_run(&objective, 50U) == EMA_OBJECTIVE_RUNNING) {
        TEST_ASSERT_TRUE(ema_objective_value(&objective) >= last);
        last = ema_objective_value(&objective);
    }
    TEST_ASSERT_TRUE(ema_objective_value(&objective) > last);
}

static void test_limit_gives_up_exactly_when_the_value_exceeds_it(void)
{
    const ema_real full = value_of(position_only);
    for (uint32_t k = 1; k <= 20U; ++k) {
        const ema_real limit = full * ((ema_real)k / EMA_R(16.0));
        ema_objective_t objective = started(position_only, limit);
        const ema_objective_state_t state = ema_objective_run(&objective, UINT32_MAX);
        if (limit < full) {
            TEST_ASSERT_EQUAL_INT(EMA_OBJECTIVE_EXCEEDED, state);
            TEST_ASSERT_TRUE(ema_objective_value(&objective) > limit);
            TEST_ASSERT_TRUE(ema_objective_value(&objective) <= full);
            TEST_ASSERT_TRUE(objective.model.state.step < ROWS);
        } else {
            TEST_ASSERT_EQUAL_INT(EMA_OBJECTIVE_DONE, state);
            TEST_ASSERT_TRUE(ema_objective_value(&objective) == full);
        }
    }
}

static void test_limit_is_not_exceeded_by_reaching_it(void)
{
    const ema_real full = value_of(position_only);
    ema_objective_t objective = started(position_only, full);
    TEST_ASSERT_EQUAL_INT(EMA_OBJECTIVE_DONE, ema_objective_run(&objective, UINT32_MAX));
}

static void test_run_exceeded_at_its_last_row_is_exceeded(void)
{
    const ema_real full = value_of(position_only);
    ema_objective_t objective = started(position_only, full * (EMA_R(1.0) - (EMA_R(2.0) * EMA_REAL_EPSILON)));
    TEST_ASSERT_EQUAL_INT(EMA_OBJECTIVE_EXCEEDED, ema_objective_run(&objective, UINT32_MAX));
}

static void test_calls_after_the_end_do_nothing(void)
{
    ema_objective_t objective = started(position_only, EMA_COST_MAX);
    (void)ema_objective_run(&objective, UINT32_MAX);
    const ema_objective_t before = objective;
    TEST_ASSERT_EQUAL_INT(EMA_OBJECTIVE_DONE, ema_objective_run(&objective, 100U));
    EMA_ASSERT_SAME_BITS(&before.model.state, &objective.model.state, sizeof before.model.state);
    TEST_ASSERT_TRUE(ema_objective_value(&before) == ema_objective_value(&objective));
}

static void test_model_that_leaves_the_finite_numbers_costs_the_most(void)
{
    ema_objective_t objective = started(position_only, EMA_COST_MAX);
    (void)ema_objective_run(&objective, 100U);
    objective.model.state.rod_mm = (ema_real)NAN;
    TEST_ASSERT_EQUAL_INT(EMA_OBJECTIVE_DIVERGED, ema_objective_run(&objective, UINT32_MAX));
    TEST_ASSERT_TRUE(ema_objective_value(&objective) == EMA_COST_MAX);
    TEST_ASSERT_TRUE(objective.model.state.step < 110U);
}

static void test_copy_is_a_checkpoint(void)
{
    ema_objective_t whole = started(all_channels, EMA_COST_MAX);
    (void)ema_objective_run(&whole, 789U);
    ema_objective_t copy = whole;
    (void)ema_objective_run(&whole, UINT32_MAX);
    (void)ema_objective_run(&copy, UINT32_MAX);
    TEST_ASSERT_TRUE(ema_objective_value(&whole) == ema_objective_value(&copy));
}

static void test_rows_apart_count_their_whole_period(void)
{
    /* recorded at every fourth step, the command held between the rows */
    const ema_record_config_t config = ema_rig_real_record(memory, sizeof memory, false);
    actuator.options.record_every_steps = 4;
    other.options.record_every_steps = 4;
    ema_rig_record(&record, &config, &actuator, &command, 500U);
    ema_model_t model = ema_rig_model(&other, EMA_R(0.0));
    double expected = 0.0;
    for (uint32_t row = 0; row < 500U; ++row) {
        ema_sample_t sample;
        EMA_ASSERT_STATUS(EMA_OK, ema_record_read(&record, row, 4U, &sample));
        const double error = (double)sample.channel[0] - (double)ema_rig_step(&model, sample.command_mm).position_mm;
        expected += error * error * 4.0e-3;
        (void)ema_rig_hold(&model, sample.command_mm, 3U);
    }
    EMA_ASSERT_CLOSE(expected, value_of(position_only), 0.0, EMA_BY_PRECISION(1.0e-6, 1.0e-14));
}

static void test_command_that_is_a_function_moves_between_rows(void)
{
    ema_record_config_t config = ema_rig_real_record(memory, sizeof memory, false);
    config.command = &command;
    actuator.options.record_every_steps = 4;
    other.options.record_every_steps = 4;
    ema_rig_record(&record, &config, &actuator, &command, 500U);
    ema_model_t model = ema_rig_model(&other, EMA_R(0.0));
    double expected = 0.0;
    for (uint32_t step = 0; step < 2000U; ++step) {
        const double position_mm = (double)ema_rig_step(&model, ema_command_at(&command, step)).position_mm;
        if ((step % 4U) == 0U) {
            ema_sample_t sample;
            EMA_ASSERT_STATUS(EMA_OK, ema_record_read(&record, step / 4U, 4U, &sample));
            expected += ((double)sample.channel[0] - position_mm) * ((double)sample.channel[0] - position_mm) * 4.0e-3;
        }
    }
    EMA_ASSERT_CLOSE(expected, value_of(position_only), 0.0, EMA_BY_PRECISION(1.0e-6, 1.0e-14));
    other = actuator;
    TEST_ASSERT_TRUE(value_of(position_only) == EMA_R(0.0));
}

static void test_start_needs_its_pointers(void)
{
    ema_objective_t objective;
    EMA_ASSERT_STATUS(EMA_ERR_NULL,
                      ema_objective_start(NULL, &other, &record, position_only, EMA_R(0.0), EMA_COST_MAX));
    EMA_ASSERT_STATUS(EMA_ERR_NULL,
                      ema_objective_start(&objective, NULL, &record, position_only, EMA_R(0.0), EMA_COST_MAX));
    EMA_ASSERT_STATUS(EMA_ERR_NULL,
                      ema_objective_start(&objective, &other, NULL, position_only, EMA_R(0.0), EMA_COST_MAX));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_objective_start(&objective, &other, &record, NULL, EMA_R(0.0), EMA_COST_MAX));
}

static void assert_refused(ema_status_t expected, const ema_real* weight, ema_real start_mm, unsigned line)
{
    ema_objective_t objective;
    (void)memset(&objective, 0x5A, sizeof objective);
    const ema_objective_t before = objective;
    ema_assert_status(expected, ema_objective_start(&objective, &other, &record, weight, start_mm, EMA_COST_MAX), line);
    /* what a model is worked out in means nothing */
    objective.model.work = before.model.work;
    ema_assert_same_bits(&before, &objective, sizeof before, line);
}

static void test_start_refuses_an_empty_record(void)
{
    const ema_record_config_t config = ema_rig_real_record(memory, sizeof memory, true);
    EMA_ASSERT_STATUS(EMA_OK, ema_record_init(&record, &config));
    assert_refused(EMA_ERR_SHORT, position_only, EMA_R(0.0), __LINE__);
}

static void test_start_refuses_a_weight_that_is_negative_or_no_number(void)
{
    for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
        ema_real weight[EMA_CHANNEL_COUNT] = {EMA_R(1.0), EMA_R(1.0), EMA_R(1.0), EMA_R(1.0)};
        weight[channel] = EMA_R(-0.5);
        assert_refused(EMA_ERR_RANGE, weight, EMA_R(0.0), __LINE__);
        weight[channel] = (ema_real)NAN;
        assert_refused(EMA_ERR_RANGE, weight, EMA_R(0.0), __LINE__);
    }
}

static void test_start_refuses_a_weight_on_a_channel_that_is_not_recorded(void)
{
    const ema_record_config_t config = ema_rig_real_record(memory, sizeof memory, false);
    ema_rig_record(&record, &config, &actuator, &command, 100U);
    assert_refused(EMA_ERR_RANGE, all_channels, EMA_R(0.0), __LINE__);
    (void)started(position_only, EMA_COST_MAX);
}

static void test_start_refuses_what_makes_no_model(void)
{
    assert_refused(EMA_ERR_RANGE, position_only, EMA_R(26.0), __LINE__);
    other.params.csj_Nm = (ema_real)NAN;
    assert_refused(EMA_ERR_NOT_FINITE, position_only, EMA_R(0.0), __LINE__);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_value_is_the_direct_sum);
    RUN_TEST(test_weighted_channels_are_the_direct_sum);
    RUN_TEST(test_weights_scale_the_value);
    RUN_TEST(test_value_at_the_truth_is_zero);
    RUN_TEST(test_slices_change_no_bit);
    RUN_TEST(test_work_of_a_slice_is_what_its_steps_take);
    RUN_TEST(test_slice_of_no_steps_does_nothing);
    RUN_TEST(test_value_only_grows);
    RUN_TEST(test_limit_gives_up_exactly_when_the_value_exceeds_it);
    RUN_TEST(test_limit_is_not_exceeded_by_reaching_it);
    RUN_TEST(test_run_exceeded_at_its_last_row_is_exceeded);
    RUN_TEST(test_calls_after_the_end_do_nothing);
    RUN_TEST(test_model_that_leaves_the_finite_numbers_costs_the_most);
    RUN_TEST(test_copy_is_a_checkpoint);
    RUN_TEST(test_rows_apart_count_their_whole_period);
    RUN_TEST(test_command_that_is_a_function_moves_between_rows);
    RUN_TEST(test_start_needs_its_pointers);
    RUN_TEST(test_start_refuses_an_empty_record);
    RUN_TEST(test_start_refuses_a_weight_that_is_negative_or_no_number);
    RUN_TEST(test_start_refuses_a_weight_on_a_channel_that_is_not_recorded);
    RUN_TEST(test_start_refuses_what_makes_no_model);
    return UNITY_END();
}
