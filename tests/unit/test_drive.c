/* Drive electronics: what is applied in voltage mode, in current mode inside the bus voltage, and beyond it. */
#include "blocks/ema_drive.h"
#include "blocks/ema_mechanics.h"
#include "ema_rig.h"

#define TOLERANCE (8.0 * EMA_EPS)

static ema_actuator_t actuator;

void setUp(void)
{
    actuator = ema_rig_actuator();
    actuator.params.supply_V = EMA_R(24.0);
    actuator.params.resistance_ohm = EMA_R(0.5);
    actuator.params.inductance_H = EMA_R(1.0e-3);
    actuator.params.back_emf_V_s_per_rad = EMA_R(0.0625);
    actuator.params.current_scale_A = EMA_R(16.0);
}

void tearDown(void)
{
}

static ema_drive_output_t applied(double output, double current_A, double speed_rad_s)
{
    ema_drive_t drive;
    ema_motor_t motor;
    ema_drive_prepare(&drive, &actuator.params, &actuator.options);
    ema_motor_prepare(&motor, &actuator.params);
    ema_drive_output_t found;
    ema_drive_step(&drive, &motor, (ema_real)output, (ema_real)current_A, (ema_real)speed_rad_s, &found);
    return found;
}

static void assert_applied(ema_drive_output_t actual, double input, double voltage_V, bool current_loop, unsigned line)
{
    ema_assert_close(input, (double)actual.input, TOLERANCE, TOLERANCE, line);
    ema_assert_close(voltage_V, (double)actual.voltage_V, TOLERANCE, TOLERANCE, line);
    UNITY_TEST_ASSERT(actual.current_loop == current_loop, line, "wrong circuit");
}

#define ASSERT_APPLIED(actual, input, voltage_V, current_loop)                                                         \
    assert_applied((actual), (input), (voltage_V), (current_loop), (unsigned)__LINE__)

static void test_voltage_mode_applies_a_share_of_the_bus(void)
{
    ASSERT_APPLIED(applied(0.75, 3.0, 100.0), 18.0, 18.0, false);
    ASSERT_APPLIED(applied(-1.0, 3.0, 100.0), -24.0, -24.0, false);
    ASSERT_APPLIED(applied(0.0, 3.0, 100.0), 0.0, 0.0, false);
}

static void test_ideal_current_loop_asks_its_reference_at_once(void)
{
    actuator.options.mode = 1;
    /* recorded: the terminal voltage R i + ke w */
    ASSERT_APPLIED(applied(0.5, 0.0, 0.0), 8.0, 4.0, true);
    ASSERT_APPLIED(applied(-0.5, 0.0, 32.0), -8.0, -4.0 + 2.0, true);
}

static void test_ideal_current_loop_knows_no_bus_voltage(void)
{
    actuator.options.mode = 1;
    ASSERT_APPLIED(applied(0.5, 0.0, 1600.0), 8.0, 4.0 + 100.0, true);
}

static void test_current_loop_applies_what_its_time_constant_needs(void)
{
    actuator.options.mode = 1;
    actuator.params.current_loop_s = EMA_R(1.0e-3);
    /* R i + L (i_ref - i) / tau + ke w */
    ASSERT_APPLIED(applied(0.5, 2.0, 32.0), 8.0, (0.5 * 2.0) + (8.0 - 2.0) + 2.0, true);
    ASSERT_APPLIED(applied(-0.5, 2.0, 0.0), -8.0, (0.5 * 2.0) + (-8.0 - 2.0), true);
}

static void test_current_loop_beyond_the_bus_applies_the_bus(void)
{
    actuator.options.mode = 1;
    actuator.params.current_loop_s = EMA_R(2.5e-4);
    /* 1e-3 * 8 / 2.5e-4 = 32 V are needed */
    ASSERT_APPLIED(applied(0.5, 0.0, 0.0), 24.0, 24.0, false);
    ASSERT_APPLIED(applied(-0.5, 0.0, 0.0), -24.0, -24.0, false);
}

static void test_current_loop_at_the_bus_voltage_still_follows(void)
{
    actuator.options.mode = 1;
    actuator.params.current_loop_s = EMA_R(2.5e-4);
    actuator.params.inductance_H = EMA_R(7.5e-4);
    ASSERT_APPLIED(applied(0.5, 0.0, 0.0), 8.0, 24.0, true);
}

static void test_current_reference_stays_inside_the_limit(void)
{
    actuator.options.mode = 1;
    actuator.params.current_limit_A = EMA_R(5.0);
    ASSERT_APPLIED(applied(1.0, 0.0, 0.0), 5.0, 2.5, true);
    ASSERT_APPLIED(applied(-1.0, 0.0, 0.0), -5.0, -2.5, true);
    ASSERT_APPLIED(applied(0.25, 0.0, 0.0), 4.0, 2.0, true);
}

static void test_command_scale_records_the_command(void)
{
    actuator.options.mode = 1;
    actuator.params.command_scale_V = EMA_R(10.0);
    ASSERT_APPLIED(applied(0.5, 0.0, 0.0), 8.0, 5.0, true);
    actuator.params.current_loop_s = EMA_R(1.0e-4);
    ASSERT_APPLIED(applied(0.5, 0.0, 0.0), 24.0, 5.0, false);
}

static void test_command_scale_has_no_say_in_voltage_mode(void)
{
    actuator.params.command_scale_V = EMA_R(10.0);
    ASSERT_APPLIED(applied(0.5, 0.0, 0.0), 12.0, 12.0, false);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_voltage_mode_applies_a_share_of_the_bus);
    RUN_TEST(test_ideal_current_loop_asks_its_reference_at_once);
    RUN_TEST(test_ideal_current_loop_knows_no_bus_voltage);
    RUN_TEST(test_current_loop_applies_what_its_time_constant_needs);
    RUN_TEST(test_current_loop_beyond_the_bus_applies_the_bus);
    RUN_TEST(test_current_loop_at_the_bus_voltage_still_follows);
    RUN_TEST(test_current_reference_stays_inside_the_limit);
    RUN_TEST(test_command_scale_records_the_command);
    RUN_TEST(test_command_scale_has_no_say_in_voltage_mode);
    return UNITY_END();
}
