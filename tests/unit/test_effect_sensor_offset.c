/* Zero shift of the rod sensor: its reading at rest, and where a loop closed over it comes to rest. */
#include "ema_open_loop.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void test_reading_at_rest_is_shifted(void)
{
    ema_actuator_t actuator = ema_rig_actuator();
    actuator.effects.sensor_offset.offset_mm = EMA_R(0.125);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(2.0));
    const ema_output_t row = ema_rig_step(&model, EMA_R(2.0));
    TEST_ASSERT_TRUE(row.position_mm == EMA_R(2.125));
    TEST_ASSERT_TRUE(row.motor_position_mm == EMA_R(2.0));
}

static void test_loop_over_the_rod_sensor_drives_the_reading_to_the_command(void)
{
    ema_actuator_t actuator = ema_rig_actuator();
    actuator.options.side = 1;
    actuator.params.csj_Nm = EMA_R(1.0e-4);
    actuator.params.blk_mm = EMA_R(0.0);
    actuator.effects.sensor_offset.offset_mm = EMA_R(0.125);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    const ema_output_t row = ema_rig_hold(&model, EMA_R(1.0), 6000U);
    EMA_ASSERT_CLOSE(0.875, row.motor_position_mm, 2.0e-3, 0.0);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_reading_at_rest_is_shifted);
    RUN_TEST(test_loop_over_the_rod_sensor_drives_the_reading_to_the_command);
    return UNITY_END();
}
