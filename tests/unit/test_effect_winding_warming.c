/* A winding that warms: the current of a locked shaft against its heat balance, solved apart in small steps. */
#include "ema_open_loop.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void test_current_falls_as_the_heat_balance_says(void)
{
    ema_actuator_t actuator = ema_open_loop_locked();
    actuator.effects.winding_warming.rise_degC_per_W = EMA_R(1.5);
    actuator.effects.winding_warming.time_s = EMA_R(0.4);
    const ema_model_t model = ema_open_loop_steady(&actuator, 0.4);
    double warmer_degC = 0.0;
    for (int32_t k = 0; k < 50000; ++k) {
        const double loss_W = (9.6 * 9.6) / (0.99 * (1.0 + (0.00393 * warmer_degC)));
        warmer_degC += (1.0e-5 / 0.4) * ((1.5 * loss_W) - warmer_degC);
    }
    TEST_ASSERT_TRUE(warmer_degC > 50.0);
    /* the current comes to its level within milliseconds, in which the winding hardly warms */
    EMA_ASSERT_CLOSE(9.6 / (0.99 * (1.0 + (0.00393 * warmer_degC))), model.state.current_A, 0.0, 2.0e-3);
}

static void test_without_current_nothing_warms(void)
{
    ema_actuator_t actuator = ema_open_loop_locked();
    actuator.effects.winding_warming.rise_degC_per_W = EMA_R(50.0);
    const ema_model_t model = ema_open_loop_steady(&actuator, 0.0);
    EMA_ASSERT_CLOSE(0.0, model.state.current_A, 0.0, 1.0e-12);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_current_falls_as_the_heat_balance_says);
    RUN_TEST(test_without_current_nothing_warms);
    return UNITY_END();
}
