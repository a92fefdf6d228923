/* Scale error of the rod sensor: its reading over the motor position, without play. */
#include "ema_open_loop.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void test_reading_is_the_position_times_its_gain(void)
{
    ema_actuator_t actuator = ema_open_loop();
    actuator.params.blk_mm = EMA_R(0.0);
    actuator.effects.sensor_gain.error = EMA_R(-0.02);
    ema_model_t model = ema_open_loop_steady(&actuator, 0.4);
    const ema_output_t row = ema_rig_step(&model, EMA_R(0.0));
    TEST_ASSERT_TRUE(row.motor_position_mm > EMA_R(5.0));
    EMA_ASSERT_CLOSE(0.98, row.position_mm / row.motor_position_mm, 0.0, 4.0 * EMA_EPS);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_reading_is_the_position_times_its_gain);
    return UNITY_END();
}
