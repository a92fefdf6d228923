/* What the day's temperature makes of CSJ, against the laws of copper, grease and friction in float64. */
#include "session/ema_temperature_correction.h"

#include <math.h>

#include "ema_rig.h"

/* Of a machine whose friction falls by half a percent a degree. */
#define PER_DEGC (-0.005)
#define WINDING_RATIO 0.18

/* A rise over the mean is a logarithm within this share of CSJ up to 12 degC. */
#define LAW_APART 0.001

static ema_actuator_t healthy;
static ema_session_config_t config;
static ema_result_t result;

void setUp(void)
{
    static ema_real buffer[4];
    healthy = ema_rig_actuator();
    healthy.options.day_values = 1;
    healthy.params.csj_scatter_percent = EMA_R(5.0);
    healthy.params.blk_scatter_percent = EMA_R(2.0);
    healthy.params.csj_day_scatter_percent = EMA_R(3.0);
    healthy.params.csj_per_degC_percent = (ema_real)(100.0 * PER_DEGC);
    healthy.params.csj_per_degC_std_percent = EMA_R(0.4);
    healthy.params.day_winding_ratio = (ema_real)WINDING_RATIO;
    healthy.params.day_apart_degC = EMA_R(6.0);
    const ema_record_config_t record = ema_rig_real_record(buffer, sizeof buffer, false);
    EMA_ASSERT_STATUS(EMA_OK, ema_session_config_default(&config, &healthy, &record));
    EMA_ASSERT_STATUS(EMA_OK, ema_session_config_day(&config));
}

void tearDown(void)
{
}

/* Readings on a day on which winding and grease are so warm, of a CSJ that is so many times the healthy one. */
static void read_day(double winding_degC, double grease_degC, double csj)
{
    const ema_result_t fresh = {.identified_count = config.identified_count};
    result = fresh;
    for (uint32_t i = 0; i < config.identified_count; ++i) {
        ema_real value = EMA_R(0.0);
        EMA_ASSERT_STATUS(EMA_OK, ema_actuator_get(&healthy, config.identified[i].id, &value));
        double times = 1.0;
        if (config.identified[i].id == EMA_VALUE_ID(csj_Nm)) {
            times = csj;
        } else if (config.identified[i].id == EMA_VALUE_ID(resistance_ohm)) {
            times = 1.0 + (0.00393 * winding_degC);
        } else if (config.identified[i].id == EMA_VALUE_ID(viscous_Nm_s_per_rad)) {
            times = exp(-0.028 * grease_degC);
        } else {
            /* the play is healthy */
        }
        result.identified[i].estimate = value * (ema_real)times;
        result.identified[i].today = result.identified[i].estimate;
        result.identified[i].shift_percent = (ema_real)(100.0 * (times - 1.0));
    }
    ema_temperature_correction(&config, &result);
}

static void test_friction_of_a_sound_machine_is_the_healthy_one_on_any_day(void)
{
    for (int warmer = -12; warmer <= 12; warmer += 4) {
        read_day((double)warmer, (double)warmer, 1.0 + (PER_DEGC * (double)warmer));
        EMA_ASSERT_CLOSE(0.0, result.identified[0].shift_percent, 100.0 * LAW_APART, 0.0);
        EMA_ASSERT_CLOSE(healthy.params.csj_Nm, result.identified[0].estimate, LAW_APART * 0.138, 0.0);
        const double scatter = hypot(3.0, 0.4 * (double)warmer);
        EMA_ASSERT_CLOSE(scatter, result.identified[0].scatter_percent, 0.1, 0.0);
    }
}

static void test_wear_on_a_warm_day_is_of_its_true_size(void)
{
    read_day(10.0, 10.0, 1.4 * (1.0 + (PER_DEGC * 10.0)));
    EMA_ASSERT_CLOSE(40.0, result.identified[0].shift_percent, 140.0 * LAW_APART, 0.0);
    EMA_ASSERT_CLOSE(1.4 * 0.138, result.identified[0].estimate, LAW_APART * 1.4 * 0.138, 0.0);
    EMA_ASSERT_CLOSE(1.33 * 0.138, result.identified[0].today, 0.0, 1.0e-6);
}

/* Each tells the temperature by its own share. */
static void test_temperature_is_what_both_tell(void)
{
    read_day(4.0, 0.0, 1.0);
    const double by_winding = 1.0 / (1.0 + (PER_DEGC * WINDING_RATIO * 4.0));
    EMA_ASSERT_CLOSE(100.0 * (by_winding - 1.0), result.identified[0].shift_percent, 0.01, 0.0);
    read_day(0.0, 4.0, 1.0);
    const double by_grease = 1.0 / (1.0 + (PER_DEGC * (1.0 - WINDING_RATIO) * 4.0));
    EMA_ASSERT_CLOSE(100.0 * (by_grease - 1.0), result.identified[0].shift_percent, 0.01, 0.0);
}

static void assert_as_read(double shift_percent)
{
    EMA_ASSERT_CLOSE(shift_percent, result.identified[0].shift_percent, 0.0, 1.0e-6);
    TEST_ASSERT_TRUE(result.identified[0].scatter_percent == EMA_R(5.0));
}

/* Aged grease, or a winding of another motor: nothing is known of the day. */
static void test_thermometers_that_contradict_each_other_tell_nothing(void)
{
    read_day(0.0, -10.0, 1.07);
    assert_as_read(7.0);
    read_day(10.0, -1.0, 1.07);
    assert_as_read(7.0);
    read_day(-4.0, 1.0, 1.07);
    TEST_ASSERT_TRUE(result.identified[0].scatter_percent < EMA_R(5.0));
}

/* A cold day whose grease thickens by less than usual: it is as cold as both allow, and friction, of which a degree
 * makes -0.5 % and that is known to 0.4 %, may be another by all of that. */
static void test_a_temperature_that_both_allow_leaves_friction_open(void)
{
    const double each_degC[4][2] = {{-20.0, -12.0}, {-12.0, -20.0}, {20.0, 12.0}, {12.0, 20.0}};
    for (size_t k = 0; k < 4U; ++k) {
        read_day(each_degC[k][0], each_degC[k][1], 1.07);
        EMA_ASSERT_CLOSE(7.0, result.identified[0].shift_percent, 0.0, 1.0e-6);
        EMA_ASSERT_CLOSE(1.07 * 0.138, result.identified[0].estimate, 0.0, 1.0e-6);
        /* the logarithm of copper's rise, which is linear, is 2 % off at 12 degC */
        const double scatter = hypot(5.0, 12.0 * hypot(0.4, 100.0 * PER_DEGC));
        EMA_ASSERT_CLOSE(scatter, result.identified[0].scatter_percent, 0.2, 0.0);
    }
}

static void test_one_thermometer_tells_nothing(void)
{
    config.identified_count = 3U;
    read_day(2.0, 2.0, 1.07);
    assert_as_read(7.0);
    config.identified_count = 2U;
    read_day(2.0, 2.0, 1.07);
    assert_as_read(7.0);
}

static void test_an_actuator_that_says_nothing_of_the_day_is_read_as_it_is(void)
{
    healthy.params.day_apart_degC = EMA_R(0.0);
    read_day(2.0, 2.0, 1.07);
    assert_as_read(7.0);
    read_day(0.0, 0.0, 1.07);
    assert_as_read(7.0);
}

static void test_play_and_what_the_day_changes_keep_their_readings(void)
{
    read_day(10.0, 10.0, 1.0);
    TEST_ASSERT_TRUE(result.identified[1].shift_percent == EMA_R(0.0));
    TEST_ASSERT_TRUE(result.identified[1].scatter_percent == EMA_R(2.0));
    for (uint32_t i = 2; i < 4U; ++i) {
        TEST_ASSERT_TRUE(result.identified[i].shift_percent != EMA_R(0.0));
        TEST_ASSERT_TRUE(result.identified[i].scatter_percent == EMA_R(0.0));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_friction_of_a_sound_machine_is_the_healthy_one_on_any_day);
    RUN_TEST(test_wear_on_a_warm_day_is_of_its_true_size);
    RUN_TEST(test_temperature_is_what_both_tell);
    RUN_TEST(test_thermometers_that_contradict_each_other_tell_nothing);
    RUN_TEST(test_a_temperature_that_both_allow_leaves_friction_open);
    RUN_TEST(test_one_thermometer_tells_nothing);
    RUN_TEST(test_an_actuator_that_says_nothing_of_the_day_is_read_as_it_is);
    RUN_TEST(test_play_and_what_the_day_changes_keep_their_readings);
    return UNITY_END();
}
