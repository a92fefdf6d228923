/* Models with values at the ends of their ranges and states at the ends of what fits: after a step the state is made of
 * finite numbers, or the step says that it is not.
 *
 * Whatever ema_actuator_check and ema_model_init let through is tried; which that is decide they alone. docs/PROOF.md
 * says what is shown for all states and what by such samples. */
#include "base/ema_effect_rows.h"
#include "base/ema_math.h"
#include "ema_rig.h"
#include "unity.h"

#include <stdio.h>

#define MODELS 1500U
#define STARTS 4U
#define STEPS 4U

void setUp(void)
{
    ema_rig_seed(20U);
}

void tearDown(void)
{
}

static bool chance(ema_real share)
{
    return ema_rig_uniform(EMA_R(0.0), EMA_R(1.0)) < share;
}

/* A value of a range: mostly its nominal, else an end, the smallest number above zero, or anything between the ends,
 * evenly or by its size. */
static ema_real drawn(const ema_range_t* range, ema_real share)
{
    ema_real value = range->nominal;
    if (chance(share)) {
        const ema_real kind = ema_rig_uniform(EMA_R(0.0), EMA_R(5.0));
        const ema_real tiny = EMA_R(1.2e-38);
        value = ema_rig_uniform(range->lower, range->upper);
        if (kind < EMA_R(1.0)) {
            value = range->lower;
        } else if (kind < EMA_R(2.0)) {
            value = range->upper;
        } else if (kind < EMA_R(2.5)) {
            value = ema_clamp(tiny, range->lower, range->upper);
        } else if (kind < EMA_R(4.0)) {
            value = ema_clamp(value * ema_exp(ema_rig_uniform(EMA_R(-15.0), EMA_R(0.0))), range->lower, range->upper);
        } else {
            /* as drawn */
        }
    }
    return value;
}

/* An actuator with about that share of its values away from nominal, and a few effects. */
static ema_actuator_t any_actuator(ema_real share)
{
    ema_actuator_t actuator = ema_rig_actuator();
    for (size_t id = 0; id < EMA_PARAM_COUNT; ++id) {
        TEST_ASSERT_EQUAL(EMA_OK,
                          ema_actuator_set(&actuator, (ema_value_id_t)id, drawn(ema_actuator_range(id), share)));
    }
    int32_t* const option = (int32_t*)(void*)&actuator.options;
    for (size_t k = 0; k < EMA_OPTION_COUNT; ++k) {
        const ema_real value = drawn(ema_actuator_range(EMA_VALUE_COUNT + k), share);
        /* the largest whole number of 32 bits rounds up in float */
        option[k] = (value < EMA_R(2147483520.0)) ? (int32_t)value : INT32_MAX;
    }
    size_t id = EMA_PARAM_COUNT;
    for (uint32_t k = 0; k < (uint32_t)EMA_EFFECT_COUNT; ++k) {
        const bool acts = chance(EMA_R(0.1));
        const size_t last = id + ema_effect_rows[k].values;
        for (; id < last; ++id) {
            TEST_ASSERT_EQUAL(EMA_OK, ema_actuator_set(&actuator, (ema_value_id_t)id,
                                                       drawn(ema_actuator_range(id), acts ? EMA_R(0.6) : EMA_R(0.0))));
        }
    }
    return actuator;
}

/* Of that size, of either sign, or nothing. */
static ema_real sized(ema_real size)
{
    return chance(EMA_R(0.2)) ? EMA_R(0.0) : (size * ema_rig_uniform(EMA_R(-1.0), EMA_R(1.0)));
}

static void any_state(const ema_model_t* model, ema_state_t* state)
{
    const ema_plant_t* const plant = &model->plant;
    const ema_real size = ema_exp(ema_rig_uniform(EMA_R(-5.0), EMA_R(16.0)));
    const ema_real travel_mm = plant->screw.stop_upper_rad * plant->gearbox.lead_mm_per_rad;
    state->current_A = sized(size);
    state->speed_rad_s = sized(size);
    state->angle_rad = sized(plant->screw.stop_upper_rad);
    state->motor_mm = state->angle_rad * plant->gearbox.lead_mm_per_rad;
    state->play_mm = state->motor_mm + sized(plant->screw.half_play_mm);
    state->rod_mm = state->play_mm;
    state->integral = sized(size);
    state->previous_error_m = sized(travel_mm * EMA_R(1.0e-3));
    state->previous_feedback_mm = sized(travel_mm);
    state->previous_measure_mm = sized(travel_mm);
    state->motion = (state->motion == (int32_t)EMA_MOTION_ELASTIC) ? state->motion
                                                                   : (int32_t)ema_rig_uniform(EMA_R(-1.9), EMA_R(1.9));
    if (state->motion == (int32_t)EMA_MOTION_STUCK) {
        state->speed_rad_s = EMA_R(0.0);
    } else if (state->motion != (int32_t)EMA_MOTION_ELASTIC) {
        state->speed_rad_s = (ema_real)state->motion * ema_abs(state->speed_rad_s);
    } else {
        /* either way */
    }
    state->step = chance(EMA_R(0.5)) ? 7U : UINT32_MAX;
}

/* Whether every number of the state is finite. */
static bool finite_state(const ema_state_t* state)
{
    bool finite = ema_is_finite(state->current_A) && ema_is_finite(state->speed_rad_s)
                  && ema_is_finite(state->angle_rad) && ema_is_finite(state->angle_low_rad)
                  && ema_is_finite(state->motor_mm) && ema_is_finite(state->play_mm) && ema_is_finite(state->rod_mm)
                  && ema_is_finite(state->rod_speed_mm_s) && ema_is_finite(state->integral)
                  && ema_is_finite(state->previous_error_m) && ema_is_finite(state->previous_feedback_mm)
                  && ema_is_finite(state->previous_measure_mm) && ema_is_finite(state->output)
                  && ema_is_finite(state->outside_ratio);
    for (uint32_t k = 0; k < EMA_DELAY_SAMPLES; ++k) {
        finite = finite && ema_is_finite(state->delay_mm[k]) && ema_is_finite(state->delay_output[k]);
    }
    for (uint32_t k = 0; k < (uint32_t)EMA_EFFECT_MEMORY_COUNT; ++k) {
        finite = finite && ema_is_finite(state->effect_memory[k]);
    }
    return finite;
}

static void test_a_step_gives_a_finite_state_or_says_that_it_does_not(void)
{
    static ema_model_t model;
    uint32_t models = 0U;
    uint32_t steps = 0U;
    uint32_t diverged = 0U;
    for (uint32_t k = 0; k < MODELS; ++k) {
        const ema_actuator_t actuator = any_actuator(EMA_R(0.02) * (ema_real)(k % 8U));
        if (ema_model_init(&model, &actuator, EMA_R(0.0)) != EMA_OK) {
            continue;
        }
        ++models;
        for (uint32_t start = 0; start < STARTS; ++start) {
            ema_model_restart(&model);
            any_state(&model, &model.state);
            ema_status_t status = EMA_OK;
            for (uint32_t step = 0; (step < STEPS) && (status == EMA_OK); ++step) {
                ema_output_t output;
                status = ema_model_step(&model, sized(actuator.params.travel_mm), &output);
                ++steps;
                const bool finite =
                    finite_state(&model.state) && ema_is_finite(output.position_mm) && ema_is_finite(output.voltage_V);
                TEST_ASSERT_TRUE((status == EMA_OK) || (status == EMA_ERR_DIVERGED));
                if (finite != (status == EMA_OK)) {
                    const ema_state_t* const state = &model.state;
                    (void)printf("model %lu, start %lu, step %lu: status %d, current %g, speed %g, angle %g, play %g, "
                                 "rod %g, integral %g, output %g, memory %g %g %g, voltage %g\n",
                                 (unsigned long)k, (unsigned long)start, (unsigned long)step, (int)status,
                                 (double)state->current_A, (double)state->speed_rad_s, (double)state->angle_rad,
                                 (double)state->play_mm, (double)state->rod_mm, (double)state->integral,
                                 (double)state->output, (double)state->effect_memory[0],
                                 (double)state->effect_memory[1], (double)state->effect_memory[2],
                                 (double)output.voltage_V);
                }
                diverged += (status == EMA_OK) ? 0U : 1U;
                TEST_ASSERT_EQUAL_MESSAGE(
                    finite, status == EMA_OK,
                    "a state that is not finite goes by the name of one that is, or the other way round");
            }
        }
    }
    (void)printf("models %lu steps %lu diverged %lu\n", (unsigned long)models, (unsigned long)steps,
                 (unsigned long)diverged);
    TEST_ASSERT_GREATER_THAN_UINT32(MODELS / 4U, models);
    TEST_ASSERT_GREATER_THAN_UINT32(models, steps);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_step_gives_a_finite_state_or_says_that_it_does_not);
    return UNITY_END();
}
