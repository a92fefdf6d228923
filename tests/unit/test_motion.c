/* Motion of the shaft against closed forms: steady speed, coast-down, saturations, stops, break-away, balances. */
#include <math.h>

#include "ema_rig.h"

#define KT 0.0612
#define R_OHM 0.99
#define L_H 8.0e-4
#define J_KGM2 6.0e-5
#define D_NMS 1.0e-4
#define LEAD_MM (5.0 / (6.283185307179586 * 4.0))

static ema_actuator_t actuator;

void setUp(void)
{
    actuator = ema_rig_actuator();
    ema_rig_seed(6U);
}

void tearDown(void)
{
}

/* An ideal drive that is asked for no current: the shaft coasts. */
static void let_coast(void)
{
    actuator.options.mode = 1;
    actuator.params.kp_per_m = EMA_R(0.0);
    actuator.params.ki_per_m_s = EMA_R(0.0);
    actuator.params.travel_mm = EMA_R(1.0e4);
}

static ema_model_t sliding_model(double speed_rad_s)
{
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    model.state.speed_rad_s = (ema_real)speed_rad_s;
    model.state.motion = (speed_rad_s > 0.0) ? (int32_t)EMA_MOTION_FORWARD : (int32_t)EMA_MOTION_BACKWARD;
    return model;
}

/* An ideal drive that gives a constant current for a command far away. */
static void push_with(double current_A)
{
    actuator.options.mode = 1;
    actuator.params.current_scale_A = (ema_real)current_A;
    actuator.params.travel_mm = EMA_R(1.0e4);
}

static void test_steady_speed_is_voltage_over_back_emf_without_losses(void)
{
    actuator.params.csj_Nm = EMA_R(0.0);
    actuator.params.viscous_Nm_s_per_rad = EMA_R(0.0);
    actuator.params.travel_mm = EMA_R(1.0e4);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    (void)ema_rig_hold(&model, EMA_R(9.0e3), 3000U);
    EMA_ASSERT_CLOSE(24.0 / KT, model.state.speed_rad_s, 0.0, EMA_BY_PRECISION(1.0e-5, 1.0e-12));
}

static void test_steady_speed_balances_torque_with_losses(void)
{
    actuator.params.travel_mm = EMA_R(1.0e4);
    const double share[2] = {1.0, 0.25};
    for (uint32_t k = 0; k < 2U; ++k) {
        actuator.params.output_limit = (ema_real)share[k];
        ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
        (void)ema_rig_hold(&model, EMA_R(-9.0e3), 3000U);
        const double expected = ((KT * share[k] * 24.0 / R_OHM) - 0.138) / (D_NMS + (KT * KT / R_OHM));
        EMA_ASSERT_CLOSE(-expected, model.state.speed_rad_s, 0.0, EMA_BY_PRECISION(1.0e-5, 1.0e-12));
        EMA_ASSERT_CLOSE(-(0.138 + (D_NMS * expected)) / KT, model.state.current_A, 0.0,
                         EMA_BY_PRECISION(2.0e-5, 1.0e-12));
    }
}

static void test_coast_down_takes_its_closed_form_time_and_angle(void)
{
    let_coast();
    actuator.params.viscous_Nm_s_per_rad = EMA_R(2.0e-3);
    const double damping = 2.0e-3;
    for (uint32_t trial = 0; trial < 200U; ++trial) {
        const double start_rad_s =
            (double)ema_rig_uniform(EMA_R(5.0), EMA_R(300.0)) * (((trial % 2U) == 0U) ? 1.0 : -1.0);
        const double size = fabs(start_rad_s);
        const double friction = 0.138 / damping; /* as a speed */
        const double stop_s = (J_KGM2 / damping) * log1p(size / friction);
        ema_model_t model = sliding_model(start_rad_s);
        uint32_t k = 0U;
        while ((model.state.motion != (int32_t)EMA_MOTION_STUCK) && (k < 1000U)) {
            const double t = 1.0e-3 * k;
            const double speed = ((size + friction) * exp(-(damping / J_KGM2) * t)) - friction;
            EMA_ASSERT_CLOSE(speed, fabs((double)model.state.speed_rad_s), EMA_BY_PRECISION(1.0e-3, 1.0e-10), 0.0);
            (void)ema_rig_step(&model, EMA_R(0.0));
            ++k;
        }
        /* it comes to rest in the very step that holds the closed form's instant */
        TEST_ASSERT_TRUE(fabs((1.0e-3 * k) - 0.5e-3 - stop_s) <= (0.5e-3 + EMA_BY_PRECISION(1.0e-6, 1.0e-12)));
        TEST_ASSERT_TRUE(model.state.speed_rad_s == EMA_R(0.0));
        const double angle =
            ((J_KGM2 / damping) * (size + friction) * -expm1(-(damping / J_KGM2) * stop_s)) - (friction * stop_s);
        EMA_ASSERT_CLOSE(copysign(angle, start_rad_s), model.state.angle_rad, EMA_BY_PRECISION(1.0e-5, 1.0e-11),
                         EMA_BY_PRECISION(2.0e-6, 1.0e-11));
        const ema_real rest_rad = model.state.angle_rad;
        (void)ema_rig_hold(&model, EMA_R(0.0), 20U);
        TEST_ASSERT_TRUE(model.state.angle_rad == rest_rad);
    }
}

static void test_dynamic_level_is_what_slides(void)
{
    let_coast();
    actuator.params.viscous_Nm_s_per_rad = EMA_R(0.0);
    actuator.params.dynamic_ratio = EMA_R(0.5);
    ema_model_t model = sliding_model(100.0);
    (void)ema_rig_hold(&model, EMA_R(0.0), 20U);
    EMA_ASSERT_CLOSE(100.0 - ((0.069 / J_KGM2) * 0.02), model.state.speed_rad_s, 0.0,
                     EMA_BY_PRECISION(1.0e-5, 1.0e-12));
}

static void test_shaft_without_losses_coasts_forever(void)
{
    let_coast();
    actuator.params.csj_Nm = EMA_R(0.0);
    actuator.params.viscous_Nm_s_per_rad = EMA_R(0.0);
    ema_model_t model = sliding_model(-20.0);
    (void)ema_rig_hold(&model, EMA_R(0.0), 5000U);
    TEST_ASSERT_TRUE(model.state.speed_rad_s == EMA_R(-20.0));
    EMA_ASSERT_CLOSE(-100.0, model.state.angle_rad, 0.0, EMA_BY_PRECISION(2.0e-6, 1.0e-12));
}

static void test_small_increments_of_a_large_angle_are_not_lost(void)
{
    let_coast();
    actuator.params.csj_Nm = EMA_R(0.0);
    actuator.params.viscous_Nm_s_per_rad = EMA_R(0.0);
    ema_model_t model = sliding_model(1.0e-3);
    model.state.angle_rad = EMA_R(100.0);
    (void)ema_rig_hold(&model, EMA_R(0.0), 10000U);
    /* 1e-6 rad a step is an eighth of what a float32 near 100 resolves */
    EMA_ASSERT_CLOSE(0.01, ((double)model.state.angle_rad - 100.0) + (double)model.state.angle_low_rad, 0.0,
                     EMA_BY_PRECISION(1.0e-3, 1.0e-9));
}

static void test_torque_saturates_under_a_large_current(void)
{
    push_with(10.0);
    actuator.params.torque_limit_Nm = EMA_R(0.3);
    actuator.params.viscous_Nm_s_per_rad = EMA_R(0.0);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    const ema_output_t row = ema_rig_hold(&model, EMA_R(9.0e3), 21U);
    EMA_ASSERT_CLOSE(10.0, row.current_A, 0.0, 4.0 * EMA_EPS);
    EMA_ASSERT_CLOSE(((0.3 - 0.138) / J_KGM2) * 0.021, model.state.speed_rad_s, 0.0, EMA_BY_PRECISION(1.0e-5, 1.0e-12));
}

static void test_torque_below_its_limit_is_not_saturated(void)
{
    push_with(4.0);
    actuator.params.torque_limit_Nm = EMA_R(0.3);
    actuator.params.viscous_Nm_s_per_rad = EMA_R(0.0);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    (void)ema_rig_hold(&model, EMA_R(-9.0e3), 20U);
    EMA_ASSERT_CLOSE(-(((KT * 4.0) - 0.138) / J_KGM2) * 0.02, model.state.speed_rad_s, 0.0,
                     EMA_BY_PRECISION(1.0e-5, 1.0e-12));
}

static void test_torque_saturation_is_located_while_the_current_rises(void)
{
    /* a rotor that nothing holds: the torque follows the current until it saturates at t1, then stays */
    actuator.params.csj_Nm = EMA_R(0.0);
    actuator.params.viscous_Nm_s_per_rad = EMA_R(0.0);
    actuator.params.back_emf_V_s_per_rad = EMA_R(0.0);
    actuator.params.torque_limit_Nm = EMA_R(0.5);
    actuator.params.travel_mm = EMA_R(1.0e4);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    const double rate = R_OHM / L_H;
    const double stall_Nm = KT * 24.0 / R_OHM;
    /* breaking away from nothing at all is located to 2^-14 of the step, which is what is left in float64 */
    const double t1 = -log1p(-0.5 / stall_Nm) / rate;
    TEST_ASSERT_TRUE(t1 < 1.0e-3);
    const double speed_t1 = (stall_Nm / J_KGM2) * (t1 + (expm1(-rate * t1) / rate));
    for (uint32_t k = 1; k <= 5U; ++k) {
        (void)ema_rig_step(&model, EMA_R(9.0e3));
        EMA_ASSERT_CLOSE(speed_t1 + ((0.5 / J_KGM2) * ((1.0e-3 * k) - t1)), model.state.speed_rad_s, 0.0,
                         EMA_BY_PRECISION(1.0e-5, 1.0e-7));
    }
}

static void test_current_limit_is_held(void)
{
    actuator.params.current_limit_A = EMA_R(5.0);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    const ema_command_t command = ema_rig_chirp(EMA_R(20.0), EMA_R(4.0), EMA_R(1.0e-3));
    uint32_t at_limit = 0U;
    for (uint32_t k = 0; k < 4000U; ++k) {
        (void)ema_rig_step(&model, ema_command_at(&command, k));
        TEST_ASSERT_TRUE(fabs((double)model.state.current_A) <= 5.0);
        at_limit += (fabs((double)model.state.current_A) == 5.0) ? 1U : 0U;
    }
    TEST_ASSERT_TRUE(at_limit > 100U);
    TEST_ASSERT_EQUAL_UINT32(0U, model.state.unlocated_event_steps);
}

static void test_current_goes_from_one_limit_to_the_other_in_one_step(void)
{
    actuator.params.current_limit_A = EMA_R(5.0);
    actuator.params.inductance_H = EMA_R(3.0e-4);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    for (uint32_t k = 0; k < 10U; ++k) {
        const ema_real side = ((k % 2U) == 0U) ? EMA_R(-1.0) : EMA_R(1.0);
        (void)ema_rig_hold(&model, side * EMA_R(20.0), 1U);
        TEST_ASSERT_TRUE(model.state.current_A == (side * EMA_R(5.0)));
    }
}

static void test_speed_under_a_held_current_is_its_closed_form(void)
{
    actuator.params.inductance_H = EMA_R(0.0);
    actuator.params.current_limit_A = EMA_R(5.0);
    actuator.params.travel_mm = EMA_R(1.0e4);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    const double steady = ((KT * 5.0) - 0.138) / D_NMS;
    for (uint32_t k = 1; k <= 80U; ++k) {
        (void)ema_rig_step(&model, EMA_R(9.0e3));
        const double speed = steady * -expm1(-(D_NMS / J_KGM2) * 1.0e-3 * k);
        /* the bus holds 5 A up to (24 - 0.99 * 5) / ke */
        TEST_ASSERT_TRUE(speed < 311.0);
        EMA_ASSERT_CLOSE(speed, model.state.speed_rad_s, 0.0, EMA_BY_PRECISION(2.0e-5, 1.0e-11));
    }
}

static void test_held_current_is_released_when_the_bus_no_longer_drives_it(void)
{
    /* with inductance: held at 5 A until the back-EMF leaves less than R I, then the current falls freely */
    actuator.params.current_limit_A = EMA_R(5.0);
    actuator.params.travel_mm = EMA_R(1.0e4);
    actuator.options.substeps = 1;
    ema_model_t coarse = ema_rig_model(&actuator, EMA_R(0.0));
    actuator.options.substeps = 64;
    ema_model_t fine = ema_rig_model(&actuator, EMA_R(0.0));
    double released_A = 5.0;
    for (uint32_t k = 0; k < 400U; ++k) {
        (void)ema_rig_step(&coarse, EMA_R(9.0e3));
        (void)ema_rig_step(&fine, EMA_R(9.0e3));
        EMA_ASSERT_CLOSE(fine.state.current_A, coarse.state.current_A, EMA_BY_PRECISION(1.0e-3, 1.0e-10), 0.0);
        EMA_ASSERT_CLOSE(fine.state.speed_rad_s, coarse.state.speed_rad_s, 0.0, EMA_BY_PRECISION(1.0e-4, 1.0e-11));
        released_A = (double)coarse.state.current_A;
    }
    TEST_ASSERT_TRUE(released_A < 4.0);
}

static void test_shaft_breaks_away_when_the_torque_passes_the_static_level(void)
{
    actuator.params.kp_per_m = EMA_R(0.0);
    actuator.params.ki_per_m_s = EMA_R(0.0);
    actuator.params.load_torque_Nm = EMA_R(0.1379);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    (void)ema_rig_hold(&model, EMA_R(0.0), 100U);
    TEST_ASSERT_EQUAL_INT32(EMA_MOTION_STUCK, model.state.motion);
    actuator.params.load_torque_Nm = EMA_R(0.1381);
    model = ema_rig_model(&actuator, EMA_R(0.0));
    (void)ema_rig_hold(&model, EMA_R(0.0), 100U);
    TEST_ASSERT_EQUAL_INT32(EMA_MOTION_BACKWARD, model.state.motion);
}

static void test_break_away_is_located_inside_the_step(void)
{
    /* the current rises as V/R (1 - exp(-R t / L)); at t1 the torque passes the static level, from there on the dynamic
     * level slides, and without back-EMF the speed has a closed form */
    actuator.params.back_emf_V_s_per_rad = EMA_R(0.0);
    actuator.params.viscous_Nm_s_per_rad = EMA_R(0.0);
    actuator.params.torque_limit_Nm = EMA_R(0.0);
    actuator.params.travel_mm = EMA_R(1.0e4);
    actuator.params.dynamic_ratio = EMA_R(0.6);
    const double rate = R_OHM / L_H;
    const double stall_Nm = KT * 24.0 / R_OHM;
    const double levels[3] = {0.2, 0.9, 1.3};
    for (uint32_t trial = 0; trial < 3U; ++trial) {
        actuator.params.csj_Nm = (ema_real)levels[trial];
        ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
        const double t1 = -log1p(-levels[trial] / stall_Nm) / rate;
        for (uint32_t k = 1; k <= 6U; ++k) {
            (void)ema_rig_step(&model, EMA_R(-9.0e3));
            const double t = 1.0e-3 * k;
            double speed = 0.0;
            if (t > t1) {
                const double faded = (exp(-rate * t1) - exp(-rate * t)) / rate;
                speed = ((stall_Nm * ((t - t1) - faded)) - (0.6 * levels[trial] * (t - t1))) / J_KGM2;
            }
            EMA_ASSERT_CLOSE(-speed, model.state.speed_rad_s, EMA_BY_PRECISION(2.0e-4, 1.0e-9),
                             EMA_BY_PRECISION(2.0e-5, 1.0e-11));
        }
    }
}

static void test_reversal_at_zero_speed_goes_on_when_nothing_holds(void)
{
    /* thrown against a constant torque without friction: a parabola through its turning point */
    let_coast();
    actuator.params.csj_Nm = EMA_R(0.0);
    actuator.params.viscous_Nm_s_per_rad = EMA_R(0.0);
    actuator.params.load_torque_Nm = EMA_R(0.06);
    actuator.params.blk_mm = EMA_R(0.0);
    ema_model_t model = sliding_model(33.3);
    const double acceleration = 0.06 / J_KGM2;
    for (uint32_t k = 1; k <= 100U; ++k) {
        (void)ema_rig_step(&model, EMA_R(0.0));
        const double t = 1.0e-3 * k;
        EMA_ASSERT_CLOSE(33.3 - (acceleration * t), model.state.speed_rad_s, EMA_BY_PRECISION(2.0e-4, 1.0e-10), 0.0);
        EMA_ASSERT_CLOSE((33.3 * t) - (0.5 * acceleration * t * t), model.state.angle_rad,
                         EMA_BY_PRECISION(1.0e-5, 1.0e-11), 0.0);
    }
}

static void test_play_sees_the_turning_point_inside_a_step(void)
{
    let_coast();
    actuator.params.csj_Nm = EMA_R(0.0);
    actuator.params.viscous_Nm_s_per_rad = EMA_R(0.0);
    actuator.params.load_torque_Nm = EMA_R(0.06);
    actuator.params.blk_mm = EMA_R(0.02);
    ema_model_t model = sliding_model(33.3);
    (void)ema_rig_hold(&model, EMA_R(0.0), 36U);
    /* highest point w^2 J / (2 T), at 33.3 ms, and the rod stays half the play below it */
    const double highest_mm = LEAD_MM * 33.3 * 33.3 * J_KGM2 / (2.0 * 0.06);
    EMA_ASSERT_CLOSE(highest_mm - 0.01, model.state.rod_mm, EMA_BY_PRECISION(1.0e-6, 1.0e-12), 0.0);
}

static void test_end_of_travel_is_inelastic(void)
{
    ema_model_t model = ema_rig_model(&actuator, EMA_R(20.0));
    bool reached = false;
    for (uint32_t k = 0; k < 1000U; ++k) {
        const ema_output_t row = ema_rig_step(&model, EMA_R(40.0));
        EMA_ASSERT_CLOSE(0.0, fmax((double)row.motor_position_mm - 25.0, 0.0), 25.0 * 4.0 * EMA_EPS, 0.0);
        if (reached) {
            TEST_ASSERT_TRUE(model.state.speed_rad_s == EMA_R(0.0));
            EMA_ASSERT_CLOSE(25.0, row.motor_position_mm, 0.0, 4.0 * EMA_EPS);
        }
        reached = reached || (model.state.angle_rad == model.plant.screw.stop_upper_rad);
    }
    TEST_ASSERT_TRUE(reached);
    /* pushed against the stop: the stall current */
    EMA_ASSERT_CLOSE(24.0 / R_OHM, model.state.current_A, 0.0, EMA_BY_PRECISION(1.0e-5, 1.0e-12));
    EMA_ASSERT_CLOSE(25.0 - 0.0165, model.state.rod_mm, 0.0, 8.0 * EMA_EPS);
    (void)ema_rig_hold(&model, EMA_R(20.0), 200U);
    TEST_ASSERT_TRUE(model.state.motor_mm < EMA_R(24.0));
}

/* A shaft that came beyond an end of travel and turns there: it stands at the end, and the play has seen no farther. */
static void test_turning_point_beyond_an_end_is_the_end(void)
{
    let_coast();
    actuator.params.travel_mm = EMA_R(25.0);
    for (int32_t side = -1; side <= 1; side += 2) {
        ema_model_t model = ema_rig_model(&actuator, (ema_real)side * EMA_R(24.9));
        const ema_real end_rad = (side > 0) ? model.plant.screw.stop_upper_rad : model.plant.screw.stop_lower_rad;
        model.state.angle_rad = end_rad + ((ema_real)side * EMA_R(1.0e-3));
        /* friction of 0.138 Nm stops it after 0.6 ms and 0.4 mrad */
        model.state.speed_rad_s = (ema_real)side * EMA_R(-1.4);
        model.state.motion = -side;
        (void)ema_rig_step(&model, EMA_R(0.0));
        TEST_ASSERT_TRUE(model.state.angle_rad == end_rad);
        TEST_ASSERT_TRUE(model.state.angle_low_rad == EMA_R(0.0));
        TEST_ASSERT_TRUE(model.state.speed_rad_s == EMA_R(0.0));
        TEST_ASSERT_EQUAL_INT32(EMA_MOTION_STUCK, model.state.motion);
        EMA_ASSERT_CLOSE((double)side * (25.0 - 0.0165), model.state.rod_mm, 0.0, 4.0 * EMA_EPS);
    }
}

static void test_lower_end_of_travel_mirrors_the_upper(void)
{
    /* fast enough for a current that brakes at the impact: the shaft leaves the stop for a moment and is pushed back */
    ema_model_t upper = ema_rig_model(&actuator, EMA_R(20.0));
    ema_model_t lower = ema_rig_model(&actuator, EMA_R(-20.0));
    for (uint32_t k = 0; k < 600U; ++k) {
        const ema_real command_mm = (k < 300U) ? EMA_R(40.0) : EMA_R(10.0);
        const ema_output_t up = ema_rig_step(&upper, command_mm);
        const ema_output_t down = ema_rig_step(&lower, -command_mm);
        TEST_ASSERT_TRUE(up.position_mm == -down.position_mm);
        TEST_ASSERT_TRUE(up.current_A == -down.current_A);
        TEST_ASSERT_TRUE(up.speed_mm_s == -down.speed_mm_s);
    }
    TEST_ASSERT_TRUE(upper.state.motor_mm < EMA_R(20.0));
}

static void test_stop_holds_the_shaft_until_the_torque_pulls_inward(void)
{
    actuator.params.csj_Nm = EMA_R(0.5);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(25.0));
    /* 0.4 Nm outward, 0.4 Nm inward: both held; 0.7 Nm inward: leaves */
    model.state.integral = EMA_R(0.0);
    const double held_mm = 0.4 * R_OHM / (KT * 24.0 * 0.4);
    (void)ema_rig_hold(&model, (ema_real)(25.0 + held_mm), 20U);
    TEST_ASSERT_TRUE(model.state.angle_rad == model.plant.screw.stop_upper_rad);
    (void)ema_rig_hold(&model, (ema_real)(25.0 - held_mm), 20U);
    TEST_ASSERT_TRUE(model.state.angle_rad == model.plant.screw.stop_upper_rad);
    (void)ema_rig_hold(&model, (ema_real)(25.0 - (2.0 * held_mm)), 20U);
    TEST_ASSERT_TRUE(model.state.angle_rad < model.plant.screw.stop_upper_rad);
}

static void test_momentum_balances_in_every_step(void)
{
    /* charge of a step from the electrical law, momentum from the mechanical: no integration error is left over */
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    const ema_command_t command = ema_rig_chirp(EMA_R(10.0), EMA_R(4.0), EMA_R(1.0e-3));
    uint32_t checked = 0U;
    for (uint32_t k = 0; k < 4000U; ++k) {
        const ema_state_t before = model.state;
        const ema_output_t row = ema_rig_step(&model, ema_command_at(&command, k));
        const ema_state_t after = model.state;
        if ((before.motion != 0) && (before.motion == after.motion)) {
            const double turn = ((double)after.angle_rad - (double)before.angle_rad)
                                + ((double)after.angle_low_rad - (double)before.angle_low_rad);
            const double charge = (((double)row.voltage_V * 1.0e-3)
                                   - (L_H * ((double)after.current_A - (double)before.current_A)) - (KT * turn))
                                  / R_OHM;
            const double momentum = (KT * charge) - (D_NMS * turn) - (0.138e-3 * before.motion);
            EMA_ASSERT_CLOSE(J_KGM2 * ((double)after.speed_rad_s - (double)before.speed_rad_s), momentum,
                             EMA_BY_PRECISION(4.0e-9, 1.0e-16), 0.0);
            ++checked;
        }
    }
    TEST_ASSERT_TRUE(checked > 3500U);
}

static void test_energy_balances_over_a_chirp(void)
{
    actuator.params.step_s = EMA_R(5.0e-5);
    actuator.options.every_steps = 20;
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    const ema_command_t command = ema_rig_chirp(EMA_R(10.0), EMA_R(4.0), EMA_R(5.0e-5));
    const double h = 5.0e-5;
    double put_in = 0.0;
    double copper = 0.0;
    double viscous = 0.0;
    double friction = 0.0;
    for (uint32_t k = 0; k < 80000U; ++k) {
        const ema_state_t before = model.state;
        const ema_output_t row = ema_rig_step(&model, ema_command_at(&command, k));
        const double i0 = (double)before.current_A;
        const double i1 = (double)model.state.current_A;
        const double w0 = (double)before.speed_rad_s;
        const double w1 = (double)model.state.speed_rad_s;
        const double turn = ((double)model.state.angle_rad - (double)before.angle_rad)
                            + ((double)model.state.angle_low_rad - (double)before.angle_low_rad);
        put_in += (double)row.voltage_V * 0.5 * h * (i0 + i1);
        copper += R_OHM * h * ((i0 * i0) + (i0 * i1) + (i1 * i1)) / 3.0;
        viscous += D_NMS * h * ((w0 * w0) + (w0 * w1) + (w1 * w1)) / 3.0;
        friction += 0.138 * fabs(turn);
    }
    const double speed = (double)model.state.speed_rad_s;
    const double current = (double)model.state.current_A;
    const double stored = (0.5 * J_KGM2 * speed * speed) + (0.5 * L_H * current * current);
    EMA_ASSERT_CLOSE(put_in, copper + viscous + friction + stored, 0.0, 5.0e-4);
    /* each share is there to be balanced */
    TEST_ASSERT_TRUE(copper > (0.05 * put_in));
    TEST_ASSERT_TRUE(friction > (0.2 * put_in));
    TEST_ASSERT_TRUE(viscous > (0.01 * put_in));
}

/* Largest difference of rod position and current between the model's own steps and much finer ones. */
static void assert_independent_of_substeps(double position_mm, double current_A)
{
    const ema_command_t command = ema_rig_chirp(EMA_R(8.0), EMA_R(3.0), actuator.params.step_s);
    actuator.options.substeps = 0;
    ema_model_t coarse = ema_rig_model(&actuator, EMA_R(0.0));
    actuator.options.substeps = 32;
    ema_model_t fine = ema_rig_model(&actuator, EMA_R(0.0));
    double worst_mm = 0.0;
    double worst_A = 0.0;
    double most_A = 0.0;
    for (uint32_t k = 0; k < 3000U; ++k) {
        const ema_real command_mm = ema_command_at(&command, k);
        const ema_output_t a = ema_rig_step(&coarse, command_mm);
        const ema_output_t b = ema_rig_step(&fine, command_mm);
        worst_mm = fmax(worst_mm, fabs((double)a.position_mm - (double)b.position_mm));
        worst_A = fmax(worst_A, fabs((double)a.current_A - (double)b.current_A));
        most_A = fmax(most_A, fabs((double)b.current_A));
    }
    TEST_ASSERT_TRUE(most_A > 1.0);
    EMA_ASSERT_CLOSE(0.0, worst_mm, position_mm, 0.0);
    EMA_ASSERT_CLOSE(0.0, worst_A, current_A, 0.0);
}

static void test_steps_are_exact_in_voltage_mode(void)
{
    assert_independent_of_substeps(EMA_BY_PRECISION(5.0e-5, 1.0e-11), EMA_BY_PRECISION(1.0e-3, 1.0e-9));
}

static void test_steps_are_exact_with_static_above_dynamic_friction(void)
{
    actuator.params.dynamic_ratio = EMA_R(0.6);
    assert_independent_of_substeps(EMA_BY_PRECISION(5.0e-5, 1.0e-10), EMA_BY_PRECISION(1.0e-3, 1.0e-8));
}

static void test_steps_are_exact_without_inductance(void)
{
    actuator.params.inductance_H = EMA_R(0.0);
    assert_independent_of_substeps(EMA_BY_PRECISION(5.0e-5, 1.0e-10), EMA_BY_PRECISION(2.0e-3, 1.0e-8));
}

static void test_steps_are_exact_with_a_current_loop(void)
{
    actuator.options.mode = 1;
    actuator.params.current_scale_A = EMA_R(10.0);
    actuator.params.current_loop_s = EMA_R(1.0e-3);
    actuator.params.kd_s_per_m = EMA_R(6.0);
    assert_independent_of_substeps(EMA_BY_PRECISION(2.0e-4, 1.0e-10), EMA_BY_PRECISION(5.0e-3, 1.0e-8));
}

static void test_steps_are_exact_with_a_current_limit(void)
{
    actuator.params.current_limit_A = EMA_R(5.0);
    /* left: an excursion beyond the limit that begins and ends within one step */
    assert_independent_of_substeps(EMA_BY_PRECISION(1.0e-4, 1.0e-7), EMA_BY_PRECISION(1.0e-3, 2.0e-5));
}

static void test_steps_are_exact_with_a_torque_limit(void)
{
    actuator.params.torque_limit_Nm = EMA_R(0.3);
    assert_independent_of_substeps(EMA_BY_PRECISION(5.0e-5, 1.0e-7), EMA_BY_PRECISION(1.0e-3, 2.0e-5));
}

static void test_steps_are_exact_at_the_ends_of_travel(void)
{
    actuator.params.travel_mm = EMA_R(1.0);
    /* left: a shaft that moves off a stop and comes to rest again at once is not followed */
    assert_independent_of_substeps(EMA_BY_PRECISION(5.0e-5, 1.0e-7), EMA_BY_PRECISION(1.0e-2, 2.0e-6));
}

static void test_step_with_unlocated_events_is_counted(void)
{
    /* a rotor of next to no inertia in steep cogging reverses more often in a step than is located */
    actuator.params.inertia_kgm2 = EMA_R(1.0e-7);
    actuator.params.csj_Nm = EMA_R(0.0);
    actuator.effects.cogging_torque.amplitude_Nm = EMA_R(10.0);
    actuator.effects.cogging_torque.periods = EMA_R(200.0);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    (void)ema_rig_hold(&model, EMA_R(0.5), 300U);
    TEST_ASSERT_TRUE(model.state.unlocated_event_steps > 0U);
}

static void test_broken_state_is_reported_and_does_not_hang(void)
{
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    model.state.current_A = (ema_real)NAN;
    model.state.motion = (int32_t)EMA_MOTION_FORWARD;
    EMA_ASSERT_STATUS(EMA_ERR_DIVERGED, ema_model_step(&model, EMA_R(0.0), NULL));
    EMA_ASSERT_STATUS(EMA_ERR_DIVERGED, ema_model_step(&model, EMA_R(0.0), NULL));
}

/* Any value of the list between its bounds, where a model can be made of it. */
static void random_actuator(void)
{
    actuator = ema_rig_actuator();
    actuator.params.csj_Nm = ema_rig_uniform(EMA_R(0.0), EMA_R(0.6));
    actuator.params.dynamic_ratio = ema_rig_uniform(EMA_R(0.3), EMA_R(1.0));
    actuator.params.blk_mm = ema_rig_uniform(EMA_R(0.0), EMA_R(0.3));
    actuator.params.load_torque_Nm = ema_rig_uniform(EMA_R(-0.3), EMA_R(0.3));
    actuator.params.efficiency = ema_rig_uniform(EMA_R(0.5), EMA_R(1.0));
    actuator.params.travel_mm = ema_rig_uniform(EMA_R(0.5), EMA_R(3.0));
    actuator.params.inertia_kgm2 = ema_rig_uniform(EMA_R(2.0e-5), EMA_R(3.0e-4));
    actuator.params.viscous_Nm_s_per_rad = ema_rig_uniform(EMA_R(0.0), EMA_R(2.0e-3));
    actuator.params.current_limit_A =
        (ema_rig_uniform(EMA_R(0.0), EMA_R(1.0)) < EMA_R(0.5)) ? EMA_R(0.0) : ema_rig_uniform(EMA_R(2.0), EMA_R(20.0));
    actuator.params.torque_limit_Nm =
        (ema_rig_uniform(EMA_R(0.0), EMA_R(1.0)) < EMA_R(0.5)) ? EMA_R(0.0) : ema_rig_uniform(EMA_R(0.1), EMA_R(1.0));
    actuator.params.inductance_H = (ema_rig_uniform(EMA_R(0.0), EMA_R(1.0)) < EMA_R(0.3))
                                       ? EMA_R(0.0)
                                       : ema_rig_uniform(EMA_R(5.0e-4), EMA_R(5.0e-3));
    actuator.params.kp_per_m = ema_rig_uniform(EMA_R(50.0), EMA_R(3000.0));
    actuator.params.kd_s_per_m =
        (ema_rig_uniform(EMA_R(0.0), EMA_R(1.0)) < EMA_R(0.5)) ? EMA_R(0.0) : ema_rig_uniform(EMA_R(0.0), EMA_R(20.0));
    actuator.options.side = (int32_t)ema_rig_uniform(EMA_R(0.0), EMA_R(2.0));
    actuator.options.mode = (int32_t)ema_rig_uniform(EMA_R(0.0), EMA_R(2.0));
    actuator.params.current_scale_A = ema_rig_uniform(EMA_R(1.0), EMA_R(20.0));
    actuator.params.current_loop_s = (ema_rig_uniform(EMA_R(0.0), EMA_R(1.0)) < EMA_R(0.3))
                                         ? EMA_R(0.0)
                                         : ema_rig_uniform(EMA_R(5.0e-4), EMA_R(3.0e-3));
}

static void test_random_actuators_keep_their_limits(void)
{
    uint32_t made = 0U;
    uint32_t stopped = 0U;
    uint32_t unlocated_event_steps = 0U;
    for (uint32_t trial = 0; trial < 300U; ++trial) {
        random_actuator();
        ema_model_t model;
        const ema_status_t status = ema_model_init(&model, &actuator, EMA_R(0.0));
        if (status == EMA_ERR_STIFF) {
            continue;
        }
        EMA_ASSERT_STATUS(EMA_OK, status);
        ++made;
        const double slack = 8.0 * EMA_EPS;
        const double half_mm = 0.5 * (double)actuator.params.blk_mm;
        const double limit_A =
            (actuator.params.current_limit_A > EMA_R(0.0)) ? (double)actuator.params.current_limit_A : 1.0e30;
        const double travel_mm = (double)actuator.params.travel_mm;
        const ema_command_t command = ema_rig_chirp(EMA_R(15.0), EMA_R(1.5), EMA_R(1.0e-3));
        for (uint32_t k = 0; k < 1500U; ++k) {
            const ema_output_t row = ema_rig_step(&model, ema_command_at(&command, k));
            EMA_ASSERT_CLOSE(0.0, fmax(fabs((double)model.state.motor_mm) - travel_mm, 0.0), travel_mm * slack, 0.0);
            EMA_ASSERT_CLOSE(0.0, fmax(fabs((double)model.state.motor_mm - (double)model.state.play_mm) - half_mm, 0.0),
                             travel_mm * slack, 0.0);
            EMA_ASSERT_CLOSE(0.0, fmax(fabs((double)model.state.current_A) - limit_A, 0.0), 0.0, 0.0);
            TEST_ASSERT_TRUE((actuator.options.mode == 1) || (fabs((double)row.voltage_V) <= 24.0));
            stopped += (fabs((double)model.state.angle_rad) == (double)model.plant.screw.stop_upper_rad) ? 1U : 0U;
        }
        unlocated_event_steps += model.state.unlocated_event_steps;
    }
    TEST_ASSERT_TRUE(made > 250U);
    TEST_ASSERT_TRUE(stopped > 1000U);
    TEST_ASSERT_EQUAL_UINT32(0U, unlocated_event_steps);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_steady_speed_is_voltage_over_back_emf_without_losses);
    RUN_TEST(test_steady_speed_balances_torque_with_losses);
    RUN_TEST(test_coast_down_takes_its_closed_form_time_and_angle);
    RUN_TEST(test_dynamic_level_is_what_slides);
    RUN_TEST(test_shaft_without_losses_coasts_forever);
    RUN_TEST(test_small_increments_of_a_large_angle_are_not_lost);
    RUN_TEST(test_torque_saturates_under_a_large_current);
    RUN_TEST(test_torque_below_its_limit_is_not_saturated);
    RUN_TEST(test_torque_saturation_is_located_while_the_current_rises);
    RUN_TEST(test_current_limit_is_held);
    RUN_TEST(test_current_goes_from_one_limit_to_the_other_in_one_step);
    RUN_TEST(test_speed_under_a_held_current_is_its_closed_form);
    RUN_TEST(test_held_current_is_released_when_the_bus_no_longer_drives_it);
    RUN_TEST(test_shaft_breaks_away_when_the_torque_passes_the_static_level);
    RUN_TEST(test_break_away_is_located_inside_the_step);
    RUN_TEST(test_reversal_at_zero_speed_goes_on_when_nothing_holds);
    RUN_TEST(test_play_sees_the_turning_point_inside_a_step);
    RUN_TEST(test_end_of_travel_is_inelastic);
    RUN_TEST(test_turning_point_beyond_an_end_is_the_end);
    RUN_TEST(test_lower_end_of_travel_mirrors_the_upper);
    RUN_TEST(test_stop_holds_the_shaft_until_the_torque_pulls_inward);
    RUN_TEST(test_momentum_balances_in_every_step);
    RUN_TEST(test_energy_balances_over_a_chirp);
    RUN_TEST(test_steps_are_exact_in_voltage_mode);
    RUN_TEST(test_steps_are_exact_with_static_above_dynamic_friction);
    RUN_TEST(test_steps_are_exact_without_inductance);
    RUN_TEST(test_steps_are_exact_with_a_current_loop);
    RUN_TEST(test_steps_are_exact_with_a_current_limit);
    RUN_TEST(test_steps_are_exact_with_a_torque_limit);
    RUN_TEST(test_steps_are_exact_at_the_ends_of_travel);
    RUN_TEST(test_step_with_unlocated_events_is_counted);
    RUN_TEST(test_broken_state_is_reported_and_does_not_hang);
    RUN_TEST(test_random_actuators_keep_their_limits);
    return UNITY_END();
}
