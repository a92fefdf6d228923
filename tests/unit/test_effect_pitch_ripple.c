/* Dry friction that varies once per lead: break-away where it is highest and lowest, nothing over a whole lead. */
#include "effects/ema_effect_sites.h"
#include "ema_open_loop.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void test_breaks_away_later_on_the_crest_than_in_the_trough(void)
{
    ema_actuator_t actuator = ema_open_loop();
    actuator.effects.pitch_ripple.ratio = EMA_R(0.25);
    EMA_ASSERT_CLOSE(0.138 * 1.25, ema_open_loop_break_away_Nm(&actuator, 1.25), 0.0, 1.0e-3);
    EMA_ASSERT_CLOSE(0.138 * 0.75, ema_open_loop_break_away_Nm(&actuator, -1.25), 0.0, 1.0e-3);
    actuator.effects.pitch_ripple.phase_rad = EMA_R(1.5707963267948966);
    EMA_ASSERT_CLOSE(0.138 * 0.75, ema_open_loop_break_away_Nm(&actuator, 2.5), 0.0, 1.0e-3);
}

static void test_sums_to_nothing_over_a_lead(void)
{
    const ema_effect_pitch_ripple_t effect = {EMA_R(0.25), EMA_R(0.7)};
    ema_actuator_t actuator = ema_open_loop();
    const ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    double sum_Nm = 0.0;
    for (uint32_t k = 0; k < 16U; ++k) {
        const ema_site_t site = {.plant = &model.plant,
                                 .position_mm = EMA_R(3.0) + ((EMA_R(5.0) / EMA_R(16.0)) * (ema_real)k)};
        sum_Nm += (double)ema_effect_pitch_ripple(&effect, &site, EMA_R(0.138));
    }
    EMA_ASSERT_CLOSE(0.0, sum_Nm, 16.0 * EMA_EPS, 0.0);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_breaks_away_later_on_the_crest_than_in_the_trough);
    RUN_TEST(test_sums_to_nothing_over_a_lead);
    return UNITY_END();
}
