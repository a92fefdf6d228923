/* A bus voltage below its nominal value: current of a locked rotor. */
#include "ema_open_loop.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void test_locked_current_falls_with_the_bus_voltage(void)
{
    ema_actuator_t actuator = ema_open_loop_locked();
    actuator.effects.supply_sag.sag = EMA_R(0.1);
    const ema_model_t model = ema_open_loop_steady(&actuator, -0.5);
    EMA_ASSERT_CLOSE(-0.5 * 0.9 * 24.0 / 0.99, model.state.current_A, 0.0, EMA_CLOSED_FORM);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_locked_current_falls_with_the_bus_voltage);
    return UNITY_END();
}
