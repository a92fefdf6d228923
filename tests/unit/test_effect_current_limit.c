/* Current limit of the drive: a locked rotor stays at it; of two limits the lower counts. */
#include "effects/ema_effect_sites.h"
#include "ema_open_loop.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void test_locked_current_stays_at_the_limit(void)
{
    ema_actuator_t actuator = ema_open_loop_locked();
    actuator.effects.current_limit.limit_A = EMA_R(5.0);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    for (uint32_t k = 0; k < 50U; ++k) {
        TEST_ASSERT_TRUE(ema_rig_step(&model, EMA_FULL_OUTPUT_MM).current_A <= EMA_R(5.0));
    }
    TEST_ASSERT_TRUE(model.state.current_A == EMA_R(5.0));
}

static void test_lower_of_two_limits_counts(void)
{
    const ema_effect_current_limit_t effect = {EMA_R(5.0)};
    ema_actuator_t actuator = ema_rig_actuator();
    actuator.params.current_limit_A = EMA_R(4.0);
    ema_effect_current_limit_adjust(&effect, &actuator.params);
    TEST_ASSERT_TRUE(actuator.params.current_limit_A == EMA_R(4.0));
    actuator.params.current_limit_A = EMA_R(6.0);
    ema_effect_current_limit_adjust(&effect, &actuator.params);
    TEST_ASSERT_TRUE(actuator.params.current_limit_A == EMA_R(5.0));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_locked_current_stays_at_the_limit);
    RUN_TEST(test_lower_of_two_limits_counts);
    return UNITY_END();
}
