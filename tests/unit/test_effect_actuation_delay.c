/* The motor sees the output later: current of a locked rotor after a step, for whole and broken delays. */
#include <math.h>

#include "ema_open_loop.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void test_locked_current_rises_after_the_delay(void)
{
    static const double delays_s[] = {3.0e-3, 2.4e-3, 0.3e-3};
    for (uint32_t d = 0; d < 3U; ++d) {
        ema_actuator_t actuator = ema_open_loop_locked();
        actuator.effects.actuation_delay.delay_s = (ema_real)delays_s[d];
        ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
        for (uint32_t k = 0; k < 12U; ++k) {
            const ema_output_t row = ema_rig_step(&model, EMA_R(0.5) * EMA_FULL_OUTPUT_MM);
            const double since_s = fmax((1.0e-3 * k) - delays_s[d], 0.0);
            EMA_ASSERT_CLOSE((12.0 / 0.99) * -expm1(-since_s * 0.99 / 8.0e-4), row.current_A,
                             EMA_BY_PRECISION(3.0e-5, 1.0e-11), 0.0);
            EMA_ASSERT_CLOSE(12.0, row.voltage_V, 0.0, EMA_CLOSED_FORM);
        }
    }
}

static void test_current_without_inductance_is_recorded_as_applied_from_the_row_on(void)
{
    ema_actuator_t actuator = ema_open_loop_locked();
    actuator.params.inductance_H = EMA_R(0.0);
    actuator.effects.actuation_delay.delay_s = EMA_R(1.0e-3);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    TEST_ASSERT_TRUE(ema_rig_step(&model, EMA_R(0.5) * EMA_FULL_OUTPUT_MM).current_A == EMA_R(0.0));
    EMA_ASSERT_CLOSE(12.0 / 0.99, ema_rig_step(&model, EMA_R(0.0)).current_A, 0.0, EMA_CLOSED_FORM);
    EMA_ASSERT_CLOSE(0.0, ema_rig_step(&model, EMA_R(0.0)).current_A, 0.0, 0.0);
}

static void test_delay_beyond_the_kept_outputs_is_refused(void)
{
    ema_actuator_t actuator = ema_open_loop();
    ema_model_t model;
    actuator.params.output_delay_s = EMA_R(0.007);
    actuator.effects.actuation_delay.delay_s = EMA_R(0.006);
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_model_init(&model, &actuator, EMA_R(0.0)));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_locked_current_rises_after_the_delay);
    RUN_TEST(test_current_without_inductance_is_recorded_as_applied_from_the_row_on);
    RUN_TEST(test_delay_beyond_the_kept_outputs_is_refused);
    return UNITY_END();
}
