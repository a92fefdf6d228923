/* Added or removed mass: the time constant of running up; the total, of which a soft transmission takes its mass. */
#include <math.h>

#include "effects/ema_effect_sites.h"
#include "ema_open_loop.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void test_time_constant_grows_with_the_inertia(void)
{
    ema_actuator_t actuator = ema_open_loop();
    actuator.params.inductance_H = EMA_R(0.0);
    actuator.effects.inertia_change.change = EMA_R(0.3);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    (void)ema_rig_hold(&model, EMA_R(0.4) * EMA_FULL_OUTPUT_MM, 20U);
    const double rate_per_s = (1.0e-4 + (0.0612 * 0.0612 / 0.99)) / (6.0e-5 * 1.3);
    const double final_rad_s = ema_steady_speed_rad_s(9.6, 0.0612, 0.99, 0.138, 1.0e-4);
    EMA_ASSERT_CLOSE(final_rad_s * -expm1(-0.02 * rate_per_s), model.state.speed_rad_s, 0.0, EMA_CLOSED_FORM);
}

static void test_soft_transmission_takes_its_mass_off_the_changed_total(void)
{
    ema_actuator_t actuator = ema_rig_actuator();
    actuator.effects.inertia_change.change = EMA_R(0.5);
    actuator.effects.transmission_compliance.period_s = EMA_R(0.02);
    actuator.effects.transmission_compliance.mass_kg = EMA_R(200.0);
    ema_params_t params = actuator.params;
    ema_effects_adjust(&actuator.effects, &params);
    const double lead_m_per_rad = 5.0e-3 / (2.0 * 3.14159265358979323846 * 4.0);
    EMA_ASSERT_CLOSE((6.0e-5 * 1.5) - (200.0 * lead_m_per_rad * lead_m_per_rad), params.inertia_kgm2, 0.0,
                     64.0 * EMA_EPS);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_time_constant_grows_with_the_inertia);
    RUN_TEST(test_soft_transmission_takes_its_mass_off_the_changed_total);
    return UNITY_END();
}
