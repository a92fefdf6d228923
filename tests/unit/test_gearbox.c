/* Gearbox: ratio, and the dry friction that a load adds in either direction. */
#include <math.h>

#include "blocks/ema_mechanics.h"
#include "ema_rig.h"

#define TURN 6.283185307179586

static ema_actuator_t actuator;

void setUp(void)
{
    actuator = ema_rig_actuator();
}

void tearDown(void)
{
}

static ema_gearbox_t prepared(void)
{
    ema_gearbox_t gearbox;
    ema_gearbox_prepare(&gearbox, &actuator.params);
    return gearbox;
}

static void test_lead_per_motor_angle(void)
{
    EMA_ASSERT_CLOSE(5.0 / (TURN * 4.0), prepared().lead_mm_per_rad, 0.0, 3.0 * EMA_EPS);
}

static void test_no_loss_without_loss_of_power(void)
{
    const ema_gearbox_t gearbox = prepared();
    TEST_ASSERT_TRUE(ema_gearbox_loss(&gearbox, EMA_R(3.0), EMA_R(1.0)) == EMA_R(0.0));
    TEST_ASSERT_TRUE(ema_gearbox_loss(&gearbox, EMA_R(3.0), EMA_R(-1.0)) == EMA_R(0.0));
}

static void test_opposing_load_adds_its_share_over_efficiency(void)
{
    actuator.params.efficiency = EMA_R(0.8);
    const ema_gearbox_t gearbox = prepared();
    EMA_ASSERT_CLOSE(0.25 * 2.0, ema_gearbox_loss(&gearbox, EMA_R(2.0), EMA_R(1.0)), 0.0, 8.0 * EMA_EPS);
    EMA_ASSERT_CLOSE(0.25 * 2.0, ema_gearbox_loss(&gearbox, EMA_R(-2.0), EMA_R(-1.0)), 0.0, 8.0 * EMA_EPS);
}

static void test_aiding_load_adds_the_share_that_is_lost(void)
{
    actuator.params.efficiency = EMA_R(0.8);
    const ema_gearbox_t gearbox = prepared();
    EMA_ASSERT_CLOSE(0.2 * 2.0, ema_gearbox_loss(&gearbox, EMA_R(2.0), EMA_R(-1.0)), 0.0, 8.0 * EMA_EPS);
    EMA_ASSERT_CLOSE(0.2 * 2.0, ema_gearbox_loss(&gearbox, EMA_R(-2.0), EMA_R(1.0)), 0.0, 8.0 * EMA_EPS);
}

/* Steady speed under full voltage u against a load: kt (V - ke w) / R = D w + T_l + (F + loss) sgn(w). */
static double steady_rad_s(double output, double against_Nm)
{
    actuator.params.travel_mm = EMA_R(1.0e4);
    actuator.params.output_limit = (ema_real)fabs(output);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    (void)ema_rig_hold(&model, (output > 0.0) ? EMA_R(9.0e3) : EMA_R(-9.0e3), 3000U);
    const double kt = 0.0612;
    const double expected = (((kt * output * 24.0) / 0.99) - against_Nm) / (1.0e-4 + ((kt * kt) / 0.99));
    EMA_ASSERT_CLOSE(expected, model.state.speed_rad_s, 0.0, EMA_BY_PRECISION(2.0e-5, 1.0e-12));
    return (double)model.state.speed_rad_s;
}

static void test_steady_speed_against_an_opposing_load(void)
{
    actuator.params.efficiency = EMA_R(0.8);
    actuator.params.load_torque_Nm = EMA_R(0.25);
    TEST_ASSERT_TRUE(steady_rad_s(0.75, 0.25 + 0.138 + (0.25 * 0.25)) > 0.0);
}

static void test_steady_speed_with_an_aiding_load(void)
{
    actuator.params.efficiency = EMA_R(0.8);
    actuator.params.load_torque_Nm = EMA_R(0.25);
    TEST_ASSERT_TRUE(steady_rad_s(-0.75, 0.25 - 0.138 - (0.2 * 0.25)) < 0.0);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_lead_per_motor_angle);
    RUN_TEST(test_no_loss_without_loss_of_power);
    RUN_TEST(test_opposing_load_adds_its_share_over_efficiency);
    RUN_TEST(test_aiding_load_adds_the_share_that_is_lost);
    RUN_TEST(test_steady_speed_against_an_opposing_load);
    RUN_TEST(test_steady_speed_with_an_aiding_load);
    return UNITY_END();
}
