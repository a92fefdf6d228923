/* The model's contract: what its preparation refuses, what a step answers, and that its state is a plain value. */
#include <math.h>

#include "ema_rig.h"
#include "plant/ema_run.h"

static ema_actuator_t actuator;

void setUp(void)
{
    actuator = ema_rig_actuator();
    ema_rig_seed(8U);
}

void tearDown(void)
{
}

/* Plant and state of the one are those of the other; the memory that steps are worked out in means nothing. */
static void assert_same_model(const ema_model_t* expected, const ema_model_t* actual, unsigned line)
{
    ema_assert_same_bits(&expected->plant, &actual->plant, sizeof expected->plant, line);
    ema_assert_same_bits(&expected->state, &actual->state, sizeof expected->state, line);
}

/* A refused actuator must leave the model as it was. */
static void assert_refused(ema_status_t expected, ema_real start_mm, unsigned line)
{
    ema_model_t model;
    (void)memset(&model, 0x5A, sizeof model);
    const ema_model_t before = model;
    ema_assert_status(expected, ema_model_init(&model, &actuator, start_mm), line);
    assert_same_model(&before, &model, line);
}

#define ASSERT_REFUSED(expected, start_mm) assert_refused((expected), (start_mm), (unsigned)__LINE__)

static void test_init_needs_its_pointers(void)
{
    ema_model_t model;
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_model_init(NULL, &actuator, EMA_R(0.0)));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_model_init(&model, NULL, EMA_R(0.0)));
}

static void test_init_refuses_a_start_that_is_not_finite(void)
{
    ASSERT_REFUSED(EMA_ERR_NOT_FINITE, (ema_real)NAN);
    ASSERT_REFUSED(EMA_ERR_NOT_FINITE, (ema_real)INFINITY);
}

static void test_init_refuses_a_value_that_is_not_finite(void)
{
    actuator.params.kp_per_m = (ema_real)NAN;
    ASSERT_REFUSED(EMA_ERR_NOT_FINITE, EMA_R(0.0));
    actuator = ema_rig_actuator();
    actuator.effects.cogging_torque.phase_rad = (ema_real)INFINITY;
    ASSERT_REFUSED(EMA_ERR_NOT_FINITE, EMA_R(0.0));
}

static void test_init_refuses_a_value_outside_its_range(void)
{
    actuator.params.csj_Nm = EMA_R(-0.1);
    ASSERT_REFUSED(EMA_ERR_RANGE, EMA_R(0.0));
    actuator = ema_rig_actuator();
    actuator.options.mode = 2;
    ASSERT_REFUSED(EMA_ERR_RANGE, EMA_R(0.0));
}

static void test_init_refuses_a_start_outside_the_travel(void)
{
    ASSERT_REFUSED(EMA_ERR_RANGE, EMA_R(25.001));
    ASSERT_REFUSED(EMA_ERR_RANGE, EMA_R(-25.001));
    (void)ema_rig_model(&actuator, EMA_R(25.0));
    (void)ema_rig_model(&actuator, EMA_R(-25.0));
}

static void test_init_refuses_a_delay_beyond_twelve_steps(void)
{
    actuator.params.step_s = EMA_R(9.0e-4);
    actuator.params.delay_s = EMA_R(0.0109);
    ASSERT_REFUSED(EMA_ERR_RANGE, EMA_R(0.0));
    actuator.params.delay_s = EMA_R(0.0107);
    (void)ema_rig_model(&actuator, EMA_R(0.0));
}

static void test_init_counts_the_delay_effect_with_the_delay(void)
{
    actuator.params.delay_s = EMA_R(0.008);
    actuator.effects.feedback_delay.delay_s = EMA_R(0.005);
    ASSERT_REFUSED(EMA_ERR_RANGE, EMA_R(0.0));
    actuator.effects.feedback_delay.delay_s = EMA_R(0.003);
    (void)ema_rig_model(&actuator, EMA_R(0.0));
}

static void test_init_refuses_a_time_constant_far_below_the_step(void)
{
    actuator.params.inductance_H = EMA_R(5.0e-6);
    ASSERT_REFUSED(EMA_ERR_STIFF, EMA_R(0.0));
    /* without it, or with a shorter step, the same motor can be computed */
    actuator.params.inductance_H = EMA_R(0.0);
    (void)ema_rig_model(&actuator, EMA_R(0.0));
    actuator.params.inductance_H = EMA_R(5.0e-6);
    actuator.params.step_s = EMA_R(2.0e-4);
    (void)ema_rig_model(&actuator, EMA_R(0.0));
}

static void test_init_refuses_a_current_loop_far_below_the_step(void)
{
    actuator.options.mode = 1;
    actuator.params.current_loop_s = EMA_R(5.0e-6);
    ASSERT_REFUSED(EMA_ERR_STIFF, EMA_R(0.0));
    actuator.params.current_loop_s = EMA_R(0.0);
    (void)ema_rig_model(&actuator, EMA_R(0.0));
}

static void test_ideal_current_loop_does_not_care_for_the_inductance(void)
{
    actuator.options.mode = 1;
    actuator.params.inductance_H = EMA_R(1.0e-6);
    (void)ema_rig_model(&actuator, EMA_R(0.0));
}

static void test_init_refuses_more_mass_on_the_spring_than_the_inertia(void)
{
    /* 500 kg at 0.199 mm/rad are 2e-5 kg m2 */
    actuator.effects.transmission_compliance.period_s = EMA_R(0.02);
    actuator.effects.transmission_compliance.mass_kg = EMA_R(500.0);
    (void)ema_rig_model(&actuator, EMA_R(0.0));
    actuator.params.inertia_kgm2 = EMA_R(2.0e-5);
    ASSERT_REFUSED(EMA_ERR_INERTIA, EMA_R(0.0));
}

/* What a user's own effects may leave behind the check of the ranges, and what the project's cannot. */
static void test_plant_refuses_what_effects_must_not_leave(void)
{
    static const ema_value_id_t ids[3] = {EMA_VALUE_ID(supply_V), EMA_VALUE_ID(viscous_Nm_s_per_rad),
                                          EMA_VALUE_ID(resistance_ohm)};
    static const ema_real bad[3] = {EMA_R(0.0), EMA_R(-1.0e-6), EMA_R(0.0)};
    static ema_plant_t plant;
    static ema_plant_t before;
    static ema_step_scratch_t work;
    for (uint32_t k = 0; k < 3U; ++k) {
        ema_actuator_t left = actuator;
        EMA_ASSERT_STATUS(EMA_OK, ema_plant_prepare(&plant, &work, &left, EMA_R(0.0)));
        (void)memcpy(&before, &plant, sizeof before);
        EMA_ASSERT_STATUS(EMA_OK, ema_actuator_set(&left, ids[k], bad[k]));
        EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_plant_prepare(&plant, &work, &left, EMA_R(0.0)));
        EMA_ASSERT_SAME_BITS(&before, &plant, sizeof before);
    }
}

static void test_an_anti_windup_that_swings_up_is_refused(void)
{
    static ema_model_t windup;
    ema_actuator_t swinging = ema_rig_actuator();
    swinging.params.anti_windup_per_s = EMA_R(2000.0);
    TEST_ASSERT_EQUAL(EMA_ERR_RANGE, ema_model_init(&windup, &swinging, EMA_R(0.0)));
    swinging.params.anti_windup_per_s = EMA_R(1900.0);
    TEST_ASSERT_EQUAL(EMA_OK, ema_model_init(&windup, &swinging, EMA_R(0.0)));
    swinging.options.every_steps = 2;
    TEST_ASSERT_EQUAL(EMA_ERR_RANGE, ema_model_init(&windup, &swinging, EMA_R(0.0)));
}

static void test_substeps_follow_the_fastest_motion_or_the_option(void)
{
    TEST_ASSERT_EQUAL_UINT32(1U, ema_rig_model(&actuator, EMA_R(0.0)).plant.substeps);
    actuator.options.substeps = 5;
    TEST_ASSERT_EQUAL_UINT32(5U, ema_rig_model(&actuator, EMA_R(0.0)).plant.substeps);
    actuator.options.substeps = 1;
    actuator.params.inductance_H = EMA_R(1.0e-4);
    /* R/L = 9900 /s and more: six substeps at least, whatever the option says */
    TEST_ASSERT_TRUE(ema_rig_model(&actuator, EMA_R(0.0)).plant.substeps >= 6U);
    TEST_ASSERT_TRUE(ema_rig_model(&actuator, EMA_R(0.0)).plant.substeps <= 8U);
    /* R/L 1238 /s, the coupling's 279 /s and the drag's 2 /s: together 1.07 times what one step of 1.2 ms reaches, 0.98
     * times that of 1.1 ms */
    actuator = ema_rig_actuator();
    actuator.params.step_s = EMA_R(1.2e-3);
    TEST_ASSERT_EQUAL_UINT32(2U, ema_rig_model(&actuator, EMA_R(0.0)).plant.substeps);
    actuator.params.step_s = EMA_R(1.1e-3);
    TEST_ASSERT_EQUAL_UINT32(1U, ema_rig_model(&actuator, EMA_R(0.0)).plant.substeps);
    actuator = ema_rig_actuator();
    actuator.effects.stribeck_friction.rise = EMA_R(0.5);
    TEST_ASSERT_EQUAL_UINT32(8U, ema_rig_model(&actuator, EMA_R(0.0)).plant.substeps);
}

static void test_model_starts_at_rest_at_its_start(void)
{
    actuator.options.side = 1;
    actuator.params.rod_offset_mm = EMA_R(0.25);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(3.5));
    const ema_output_t row = ema_rig_step(&model, EMA_R(3.75));
    TEST_ASSERT_TRUE(row.position_mm == EMA_R(3.75));
    TEST_ASSERT_TRUE(row.motor_position_mm == EMA_R(3.5));
    TEST_ASSERT_TRUE(row.current_A == EMA_R(0.0));
    TEST_ASSERT_TRUE(row.voltage_V == EMA_R(0.0));
    TEST_ASSERT_TRUE(row.speed_mm_s == EMA_R(0.0));
}

static void test_asked_for_where_it_is_a_model_stays_there(void)
{
    ema_model_t model = ema_rig_model(&actuator, EMA_R(3.5));
    const ema_output_t row = ema_rig_hold(&model, EMA_R(3.5), 1000U);
    EMA_ASSERT_CLOSE(3.5, row.position_mm, 0.0, 2.0 * EMA_EPS);
    EMA_ASSERT_CLOSE(0.0, row.current_A, 1.0e3 * EMA_EPS, 0.0);
}

static void test_output_shows_the_start_of_the_step(void)
{
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    for (uint32_t k = 0; k < 200U; ++k) {
        const ema_state_t before = model.state;
        const ema_output_t row = ema_rig_step(&model, EMA_R(2.0));
        TEST_ASSERT_TRUE(row.position_mm == before.rod_mm);
        TEST_ASSERT_TRUE(row.motor_position_mm == before.motor_mm);
        TEST_ASSERT_TRUE(row.current_A == before.current_A);
        EMA_ASSERT_CLOSE(24.0 * (double)model.state.output, row.voltage_V, 0.0, 2.0 * EMA_EPS);
        TEST_ASSERT_EQUAL_UINT32(k + 1U, model.state.step);
    }
}

static void test_rod_speed_is_that_of_the_motor_in_contact_and_zero_in_the_play(void)
{
    actuator.params.blk_mm = EMA_R(0.3);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    const ema_command_t command = ema_rig_chirp(EMA_R(3.0), EMA_R(3.0), EMA_R(1.0e-3));
    uint32_t moving = 0U;
    uint32_t resting = 0U;
    for (uint32_t k = 0; k < 3000U; ++k) {
        const ema_state_t before = model.state;
        const ema_output_t row = ema_rig_step(&model, ema_command_at(&command, k));
        const double motor_mm_s = (double)model.plant.gearbox.lead_mm_per_rad * (double)before.speed_rad_s;
        const double gap_mm = (double)before.motor_mm - (double)before.play_mm;
        if (fabs(gap_mm) < 0.1499) {
            TEST_ASSERT_TRUE(row.speed_mm_s == EMA_R(0.0));
            resting += (motor_mm_s != 0.0) ? 1U : 0U;
        } else if ((gap_mm * motor_mm_s) > 0.0) {
            EMA_ASSERT_CLOSE(motor_mm_s, row.speed_mm_s, 0.0, 2.0 * EMA_EPS);
            ++moving;
        } else {
            TEST_ASSERT_TRUE(row.speed_mm_s == EMA_R(0.0));
        }
    }
    TEST_ASSERT_TRUE((moving > 1000U) && (resting > 50U));
}

static void test_output_is_optional(void)
{
    ema_model_t with = ema_rig_model(&actuator, EMA_R(0.0));
    ema_model_t without = ema_rig_model(&actuator, EMA_R(0.0));
    for (uint32_t k = 0; k < 50U; ++k) {
        (void)ema_rig_step(&with, EMA_R(1.0));
        EMA_ASSERT_STATUS(EMA_OK, ema_model_step(&without, EMA_R(1.0), NULL));
    }
    EMA_ASSERT_SAME_BITS(&with.state, &without.state, sizeof with.state);
}

static void test_step_needs_a_model(void)
{
    ema_output_t output;
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_model_step(NULL, EMA_R(0.0), &output));
}

static void test_command_that_is_not_finite_changes_nothing(void)
{
    const ema_real bad[3] = {(ema_real)NAN, (ema_real)INFINITY, (ema_real)-INFINITY};
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    (void)ema_rig_hold(&model, EMA_R(1.0), 20U);
    const ema_model_t before = model;
    for (uint32_t k = 0; k < 3U; ++k) {
        EMA_GUARDED(ema_output_t) box;
        EMA_GUARD_SET(box);
        const ema_output_t noise = box.value;
        EMA_ASSERT_STATUS(EMA_ERR_NOT_FINITE, ema_model_step(&model, bad[k], &box.value));
        EMA_ASSERT_SAME_BITS(&before, &model, sizeof before);
        EMA_ASSERT_SAME_BITS(&noise, &box.value, sizeof noise);
    }
}

static void test_state_that_is_not_finite_is_reported(void)
{
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    model.state.current_A = (ema_real)INFINITY;
    EMA_ASSERT_STATUS(EMA_ERR_DIVERGED, ema_model_step(&model, EMA_R(0.0), NULL));
    model = ema_rig_model(&actuator, EMA_R(0.0));
    model.state.speed_rad_s = (ema_real)NAN;
    model.state.motion = (int32_t)EMA_MOTION_FORWARD;
    EMA_ASSERT_STATUS(EMA_ERR_DIVERGED, ema_model_step(&model, EMA_R(0.0), NULL));
    model = ema_rig_model(&actuator, EMA_R(0.0));
    model.state.angle_rad = (ema_real)NAN;
    EMA_ASSERT_STATUS(EMA_ERR_DIVERGED, ema_model_step(&model, EMA_R(0.0), NULL));
    model = ema_rig_model(&actuator, EMA_R(0.0));
    model.state.integral = (ema_real)NAN;
    EMA_ASSERT_STATUS(EMA_ERR_DIVERGED, ema_model_step(&model, EMA_R(0.0), NULL));
}

/* Each alone, where nothing else follows from it: a shaft at rest does not look at its speed, and a loop over the motor
 * not at the rod. */
static void test_speed_or_rod_alone_that_is_not_finite_is_reported(void)
{
    actuator.options.side = 0;
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    model.state.speed_rad_s = (ema_real)NAN;
    EMA_ASSERT_STATUS(EMA_ERR_DIVERGED, ema_model_step(&model, EMA_R(0.0), NULL));
    TEST_ASSERT_TRUE(isfinite((double)model.state.current_A) && isfinite((double)model.state.motor_mm));
    model = ema_rig_model(&actuator, EMA_R(0.0));
    model.state.play_mm = (ema_real)NAN;
    EMA_ASSERT_STATUS(EMA_ERR_DIVERGED, ema_model_step(&model, EMA_R(0.0), NULL));
    TEST_ASSERT_TRUE(isfinite((double)model.state.motor_mm));
}

static void test_largest_command_does_not_break_the_state(void)
{
    const ema_real largest = EMA_BY_PRECISION(EMA_R(3.0e38), EMA_R(1.0e308));
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    for (uint32_t k = 0; k < 10U; ++k) {
        const ema_status_t status = ema_model_step(&model, ((k % 2U) == 0U) ? largest : -largest, NULL);
        const bool finite = isfinite((double)model.state.integral) && isfinite((double)model.state.rod_mm);
        TEST_ASSERT_EQUAL_INT(finite ? EMA_OK : EMA_ERR_DIVERGED, status);
    }
}

/* An actuator with every effect, delay, derivative and a cascade of all that keeps state. */
static void everything_on(void)
{
    actuator.params.kd_s_per_m = EMA_R(0.5);
    actuator.options.derivative = 1;
    actuator.options.average_speed = 1;
    actuator.options.every_steps = 2;
    actuator.params.delay_s = EMA_R(0.0015);
    actuator.params.resolution_mm = EMA_R(1.0e-4);
    actuator.params.dynamic_ratio = EMA_R(0.8);
    actuator.effects.stribeck_friction.rise = EMA_R(0.2);
    actuator.effects.cogging_torque.amplitude_Nm = EMA_R(0.02);
    actuator.effects.constant_load.torque_Nm = EMA_R(0.02);
    actuator.effects.winding_heating.rise_degC = EMA_R(20.0);
    actuator.effects.inverter_dead_time.drop_V = EMA_R(0.3);
    actuator.effects.transmission_compliance.period_s = EMA_R(0.02);
    actuator.effects.feedback_delay.delay_s = EMA_R(0.0007);
    actuator.effects.spring_load.stiffness_Nm_per_mm = EMA_R(0.01);
}

static void assert_copy_resumes(void)
{
    const ema_command_t command = ema_rig_chirp(EMA_R(5.0), EMA_R(2.0), EMA_R(1.0e-3));
    ema_model_t whole = ema_rig_model(&actuator, EMA_R(0.0));
    ema_model_t kept = whole;
    ema_model_t other = ema_rig_model(&actuator, EMA_R(-7.0));
    for (uint32_t k = 0; k < 2000U; ++k) {
        if (k == 777U) {
            kept = whole;
            other.state = whole.state;
        }
        (void)ema_rig_step(&whole, ema_command_at(&command, k));
    }
    for (uint32_t k = 777U; k < 2000U; ++k) {
        (void)ema_rig_step(&kept, ema_command_at(&command, k));
        (void)ema_rig_step(&other, ema_command_at(&command, k));
    }
    EMA_ASSERT_SAME_BITS(&whole.state, &kept.state, sizeof whole.state);
    EMA_ASSERT_SAME_BITS(&whole.state, &other.state, sizeof whole.state);
    TEST_ASSERT_TRUE(whole.state.rod_mm != EMA_R(0.0));
}

static void test_copy_is_a_checkpoint(void)
{
    assert_copy_resumes();
}

static void test_copy_is_a_checkpoint_with_everything_on(void)
{
    everything_on();
    assert_copy_resumes();
}

static void test_copy_is_a_checkpoint_in_cascade_and_current_mode(void)
{
    actuator.options.structure = 1;
    actuator.options.mode = 1;
    actuator.params.position_gain_per_s = EMA_R(30.0);
    actuator.params.speed_gain_s_per_m = EMA_R(10.0);
    actuator.params.speed_integral_per_m = EMA_R(200.0);
    actuator.params.current_scale_A = EMA_R(15.0);
    actuator.params.current_loop_s = EMA_R(1.0e-3);
    assert_copy_resumes();
}

static void test_restart_goes_back_to_the_start_bit_for_bit(void)
{
    everything_on();
    ema_model_t model = ema_rig_model(&actuator, EMA_R(1.25));
    const ema_model_t fresh = model;
    (void)ema_rig_hold(&model, EMA_R(-1.0), 500U);
    TEST_ASSERT_TRUE(ema_first_difference(&fresh.state, &model.state, sizeof fresh.state) < sizeof fresh.state);
    ema_model_restart(&model);
    assert_same_model(&fresh, &model, (unsigned)__LINE__);
}

static void test_stepping_changes_the_state_alone(void)
{
    everything_on();
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    const ema_model_t before = model;
    (void)ema_rig_hold(&model, EMA_R(2.0), 500U);
    EMA_ASSERT_SAME_BITS(&before.plant, &model.plant, sizeof before.plant);
}

static void test_actuator_is_copied(void)
{
    ema_model_t kept = ema_rig_model(&actuator, EMA_R(0.0));
    ema_model_t other = ema_rig_model(&actuator, EMA_R(0.0));
    (void)memset(&actuator, 0, sizeof actuator);
    (void)ema_rig_hold(&kept, EMA_R(2.0), 300U);
    actuator = ema_rig_actuator();
    (void)ema_rig_hold(&other, EMA_R(2.0), 300U);
    EMA_ASSERT_SAME_BITS(&kept.state, &other.state, sizeof kept.state);
}

static void test_faults_change_the_run(void)
{
    /* the published pair: objective between the healthy run and case A, 0.674 mm^2 s for the reference chirp */
    ema_model_t healthy = ema_rig_model(&actuator, EMA_R(0.0));
    actuator.params.csj_Nm = EMA_R(0.3);
    actuator.params.blk_mm = EMA_R(0.04125);
    ema_model_t faulty = ema_rig_model(&actuator, EMA_R(0.0));
    const ema_command_t command = ema_rig_chirp(EMA_R(4.0), EMA_R(10.0), EMA_R(1.0e-3));
    double sum = 0.0;
    for (uint32_t k = 0; k < 10000U; ++k) {
        const double difference = (double)ema_rig_step(&healthy, ema_command_at(&command, k)).position_mm
                                  - (double)ema_rig_step(&faulty, ema_command_at(&command, k)).position_mm;
        sum += difference * difference * 1.0e-3;
    }
    EMA_ASSERT_CLOSE(0.674, sum, 0.001, 0.0);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_init_needs_its_pointers);
    RUN_TEST(test_init_refuses_a_start_that_is_not_finite);
    RUN_TEST(test_init_refuses_a_value_that_is_not_finite);
    RUN_TEST(test_init_refuses_a_value_outside_its_range);
    RUN_TEST(test_init_refuses_a_start_outside_the_travel);
    RUN_TEST(test_init_refuses_a_delay_beyond_twelve_steps);
    RUN_TEST(test_init_counts_the_delay_effect_with_the_delay);
    RUN_TEST(test_init_refuses_a_time_constant_far_below_the_step);
    RUN_TEST(test_init_refuses_a_current_loop_far_below_the_step);
    RUN_TEST(test_ideal_current_loop_does_not_care_for_the_inductance);
    RUN_TEST(test_init_refuses_more_mass_on_the_spring_than_the_inertia);
    RUN_TEST(test_an_anti_windup_that_swings_up_is_refused);
    RUN_TEST(test_plant_refuses_what_effects_must_not_leave);
    RUN_TEST(test_substeps_follow_the_fastest_motion_or_the_option);
    RUN_TEST(test_model_starts_at_rest_at_its_start);
    RUN_TEST(test_asked_for_where_it_is_a_model_stays_there);
    RUN_TEST(test_output_shows_the_start_of_the_step);
    RUN_TEST(test_rod_speed_is_that_of_the_motor_in_contact_and_zero_in_the_play);
    RUN_TEST(test_output_is_optional);
    RUN_TEST(test_step_needs_a_model);
    RUN_TEST(test_command_that_is_not_finite_changes_nothing);
    RUN_TEST(test_state_that_is_not_finite_is_reported);
    RUN_TEST(test_speed_or_rod_alone_that_is_not_finite_is_reported);
    RUN_TEST(test_largest_command_does_not_break_the_state);
    RUN_TEST(test_copy_is_a_checkpoint);
    RUN_TEST(test_copy_is_a_checkpoint_with_everything_on);
    RUN_TEST(test_copy_is_a_checkpoint_in_cascade_and_current_mode);
    RUN_TEST(test_restart_goes_back_to_the_start_bit_for_bit);
    RUN_TEST(test_stepping_changes_the_state_alone);
    RUN_TEST(test_actuator_is_copied);
    RUN_TEST(test_faults_change_the_run);
    return UNITY_END();
}
