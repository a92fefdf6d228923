/* Optional effects: absent bit for bit at zero, felt when they are not, and each against a closed form of its own. */
#include <math.h>

#include "base/ema_math.h"
#include "effects/ema_effect_sums.h"
#include "ema_rig.h"

#define KT 0.0612
#define J_KGM2 6.0e-5
#define LEAD_MM (5.0 / (6.283185307179586 * 4.0))
#define TURN 6.283185307179586

static ema_actuator_t actuator;

void setUp(void)
{
    actuator = ema_rig_actuator();
    ema_rig_seed(9U);
}

void tearDown(void)
{
}

/* The rows of the list: where an effect's values are, its size first. */
typedef struct {
    const char* name;
    size_t first;
    size_t count;
} row_t;

static const row_t rows[] = {
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters)                            \
    {#name, EMA_PARAM_COUNT + (offsetof(ema_effects_t, name) / sizeof(ema_real)),                                      \
     sizeof(ema_effect_##name##_t) / sizeof(ema_real)},
#include "ema/ema_effects.def"
};

#define ROW_COUNT (sizeof(rows) / sizeof(rows[0]))

/* The shape parameters of a row at some other value than the nominal one. */
static void reshape(ema_actuator_t* changed, const row_t* row)
{
    for (size_t id = row->first + 1U; id < (row->first + row->count); ++id) {
        const ema_range_t* const range = ema_actuator_range(id);
        const ema_real share =
            (range->nominal == (range->lower + (EMA_R(0.3) * (range->upper - range->lower)))) ? EMA_R(0.4) : EMA_R(0.3);
        const ema_real value = range->lower + (share * (range->upper - range->lower));
        EMA_ASSERT_STATUS(EMA_OK, ema_actuator_set(changed, (ema_value_id_t)id, value));
    }
}

static void test_zero_is_nominal_for_every_size(void)
{
    for (size_t k = 0; k < ROW_COUNT; ++k) {
        TEST_ASSERT_TRUE(ema_actuator_range(rows[k].first)->nominal == EMA_R(0.0));
    }
}

static void test_every_effect_at_zero_is_absent_bit_for_bit(void)
{
    const ema_command_t command = ema_rig_chirp(EMA_R(6.0), EMA_R(2.0), EMA_R(1.0e-3));
    for (size_t k = 0; k < ROW_COUNT; ++k) {
        ema_actuator_t shaped = actuator;
        reshape(&shaped, &rows[k]);
        ema_model_t plain = ema_rig_model(&actuator, EMA_R(0.0));
        ema_model_t off = ema_rig_model(&shaped, EMA_R(0.0));
        for (uint32_t step = 0; step < 2000U; ++step) {
            const ema_output_t a = ema_rig_step(&plain, ema_command_at(&command, step));
            const ema_output_t b = ema_rig_step(&off, ema_command_at(&command, step));
            EMA_ASSERT_SAME_BITS(&a, &b, sizeof a);
            EMA_ASSERT_SAME_BITS(&plain.state, &off.state, sizeof plain.state);
        }
        /* what is prepared differs in the kept values alone */
        off.plant.effects = plain.plant.effects;
        EMA_ASSERT_SAME_BITS(&plain.plant.motor_circuit, &off.plant.motor_circuit, sizeof plain.plant.motor_circuit);
        EMA_ASSERT_SAME_BITS(&plain.plant.screw, &off.plant.screw, sizeof plain.plant.screw);
        TEST_ASSERT_FALSE(off.plant.active.any);
        TEST_ASSERT_EQUAL_UINT16(plain.plant.substeps, off.plant.substeps);
    }
}

/* A table without values changes nothing: its nodes, behind gain, axis, first and last, at a hundredth of their range.
 */
static void fill_table(ema_actuator_t* with, const row_t* row)
{
    for (size_t id = row->first + 4U; id < (row->first + row->count); ++id) {
        EMA_ASSERT_STATUS(EMA_OK,
                          ema_actuator_set(with, (ema_value_id_t)id, EMA_R(0.01) * ema_actuator_range(id)->upper));
    }
}

/* Largest change of current in A or of the rod's reading in mm by a row whose size is `share` of its upper bound. */
static double felt(const row_t* row, ema_real share)
{
    const ema_command_t command = ema_rig_chirp(EMA_R(6.0), EMA_R(2.0), EMA_R(1.0e-3));
    ema_actuator_t with = actuator;
    EMA_ASSERT_STATUS(
        EMA_OK, ema_actuator_set(&with, (ema_value_id_t)row->first, share * ema_actuator_range(row->first)->upper));
    if (ema_actuator_is_learned((ema_value_id_t)row->first)) {
        fill_table(&with, row);
    }
    ema_model_t plain = ema_rig_model(&actuator, EMA_R(0.0));
    ema_model_t on = ema_rig_model(&with, EMA_R(0.0));
    double largest = 0.0;
    for (uint32_t step = 0; step < 2000U; ++step) {
        const ema_output_t a = ema_rig_step(&plain, ema_command_at(&command, step));
        const ema_output_t b = ema_rig_step(&on, ema_command_at(&command, step));
        largest = fmax(largest, fmax(fabs((double)a.current_A - (double)b.current_A),
                                     fabs((double)a.position_mm - (double)b.position_mm)));
    }
    return largest;
}

static void test_every_effect_is_felt_when_it_is_not_zero(void)
{
    for (size_t k = 0; k < ROW_COUNT; ++k) {
        /* a limit is felt when it is low, everything else when it is high */
        TEST_ASSERT_TRUE_MESSAGE((felt(&rows[k], EMA_R(0.01)) > 1.0e-3) || (felt(&rows[k], EMA_R(0.001)) > 1.0e-3),
                                 rows[k].name);
    }
}

/* The sets that a plant gets from the actuator's effects. */
static ema_plant_t holding;

static ema_active_t active_now(void)
{
    ema_effects_hold(&holding, &actuator.effects);
    return holding.active;
}

static void test_effects_add_up_over_sites(void)
{
    actuator.effects.stribeck_friction.rise = EMA_R(0.1);
    actuator.effects.cogging_torque.amplitude_Nm = EMA_R(0.1);
    actuator.effects.constant_load.torque_Nm = EMA_R(0.1);
    actuator.effects.inverter_dead_time.drop_V = EMA_R(0.1);
    actuator.effects.spring_load.stiffness_Nm_per_mm = EMA_R(0.1);
    const ema_active_t active = active_now();
    TEST_ASSERT_TRUE(ema_acts(&holding, EMA_SITE_FRICTION) && ema_acts(&holding, EMA_SITE_TORQUE)
                     && ema_acts(&holding, EMA_SITE_VOLTAGE) && ema_acts(&holding, EMA_SITE_LOAD) && active.any);
    TEST_ASSERT_FALSE(ema_acts(&holding, EMA_SITE_TRANSMISSION));
    TEST_ASSERT_EQUAL_UINT8(8U, active.substeps);
    actuator = ema_rig_actuator();
    actuator.effects.constant_load.torque_Nm = EMA_R(0.1);
    TEST_ASSERT_FALSE(active_now().any);
    TEST_ASSERT_EQUAL_UINT8(1U, active_now().substeps);
}

/* An ideal drive that is asked for no current, and nothing that brakes. */
static void let_swing(void)
{
    actuator.options.mode = 1;
    actuator.params.kp_per_m = EMA_R(0.0);
    actuator.params.ki_per_m_s = EMA_R(0.0);
    actuator.params.csj_Nm = EMA_R(0.0);
    actuator.params.viscous_Nm_s_per_rad = EMA_R(0.0);
    actuator.params.blk_mm = EMA_R(0.0);
}

static ema_model_t moving_model(double speed_rad_s)
{
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    model.state.speed_rad_s = (ema_real)speed_rad_s;
    model.state.motion = (speed_rad_s > 0.0) ? (int32_t)EMA_MOTION_FORWARD : (int32_t)EMA_MOTION_BACKWARD;
    return model;
}

/* A model that runs into a steady state under a constant output. */
static ema_model_t steady_model(double output)
{
    actuator.params.travel_mm = EMA_R(1.0e4);
    actuator.params.output_limit = (ema_real)fabs(output);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    (void)ema_rig_hold(&model, (output > 0.0) ? EMA_R(9.0e3) : EMA_R(-9.0e3), 3000U);
    return model;
}

static void test_stribeck_level_falls_with_speed(void)
{
    for (uint32_t k = 0; k < 2000U; ++k) {
        const double rise = (double)ema_rig_uniform(EMA_R(0.01), EMA_R(3.0));
        const double scale = (double)ema_rig_uniform(EMA_R(0.5), EMA_R(200.0));
        const double shape =
            ((k % 3U) == 0U) ? 1.0 : (((k % 3U) == 1U) ? 2.0 : (double)ema_rig_uniform(EMA_R(0.5), EMA_R(4.0)));
        const double speed = (double)ema_rig_uniform(EMA_R(-300.0), EMA_R(300.0));
        const ema_effect_stribeck_friction_t effect = {(ema_real)rise, (ema_real)scale, (ema_real)shape};
        const ema_site_t site = {.speed_rad_s = (ema_real)speed};
        const double expected = 0.138 * rise * exp(-pow(fabs(speed) / scale, shape));
        EMA_ASSERT_CLOSE(expected, ema_effect_stribeck_friction(&effect, &site, EMA_R(0.138)),
                         EMA_BY_PRECISION(1.0e-6, 1.0e-14), 0.0);
    }
}

static void test_stribeck_rise_is_whole_at_rest(void)
{
    const double shapes[3] = {0.7, 1.0, 2.0};
    for (uint32_t k = 0; k < 3U; ++k) {
        const ema_effect_stribeck_friction_t effect = {EMA_R(0.5), EMA_R(10.0), (ema_real)shapes[k]};
        const ema_site_t site = {.speed_rad_s = EMA_R(0.0)};
        TEST_ASSERT_TRUE(ema_effect_stribeck_friction(&effect, &site, EMA_R(0.25)) == EMA_R(0.125));
    }
}

static void test_stribeck_raises_the_torque_that_breaks_away(void)
{
    actuator.params.kp_per_m = EMA_R(0.0);
    actuator.params.ki_per_m_s = EMA_R(0.0);
    actuator.effects.stribeck_friction.rise = EMA_R(0.5);
    actuator.params.load_torque_Nm = EMA_R(0.206);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    (void)ema_rig_hold(&model, EMA_R(0.0), 100U);
    TEST_ASSERT_EQUAL_INT32(EMA_MOTION_STUCK, model.state.motion);
    actuator.params.load_torque_Nm = EMA_R(0.208);
    model = ema_rig_model(&actuator, EMA_R(0.0));
    (void)ema_rig_hold(&model, EMA_R(0.0), 100U);
    TEST_ASSERT_EQUAL_INT32(EMA_MOTION_BACKWARD, model.state.motion);
}

static void test_stribeck_balances_the_steady_speed(void)
{
    actuator.effects.stribeck_friction.rise = EMA_R(0.8);
    actuator.effects.stribeck_friction.speed_rad_s = EMA_R(60.0);
    const ema_model_t model = steady_model(-0.25);
    const double speed = fabs((double)model.state.speed_rad_s);
    const double friction_Nm = 0.138 * (1.0 + (0.8 * exp(-speed / 60.0)));
    EMA_ASSERT_CLOSE(KT * fabs((double)model.state.current_A), friction_Nm + (1.0e-4 * speed), 0.0,
                     EMA_BY_PRECISION(1.0e-5, 1.0e-11));
    /* the exponential still matters at that speed */
    TEST_ASSERT_TRUE(friction_Nm > (1.05 * 0.138));
}

static void test_cogging_torque_is_periodic_in_the_angle(void)
{
    for (uint32_t k = 0; k < 2000U; ++k) {
        const double amplitude = (double)ema_rig_uniform(EMA_R(0.01), EMA_R(1.0));
        const double periods = (double)ema_floor(ema_rig_uniform(EMA_R(1.0), EMA_R(40.0)));
        const double phase = (double)ema_rig_uniform(EMA_R(-6.3), EMA_R(6.3));
        const double angle = (double)ema_rig_uniform(EMA_R(-120.0), EMA_R(120.0));
        const ema_effect_cogging_torque_t effect = {(ema_real)amplitude, (ema_real)periods, (ema_real)phase};
        const ema_site_t site = {.angle_rad = (ema_real)angle};
        EMA_ASSERT_CLOSE(amplitude * sin((periods * angle) + phase), ema_effect_cogging_torque(&effect, &site),
                         1.0e4 * EMA_EPS, 0.0);
    }
}

static void test_rotor_swings_in_cogging_with_its_period_and_keeps_its_energy(void)
{
    let_swing();
    actuator.options.substeps = 16;
    actuator.effects.cogging_torque.amplitude_Nm = EMA_R(0.03);
    actuator.effects.cogging_torque.periods = EMA_R(12.0);
    /* a torque that falls with the angle at zero: stable there */
    actuator.effects.cogging_torque.phase_rad = EMA_R(3.14159265358979);
    const double natural_rad_s = sqrt((0.03 * 12.0) / J_KGM2);
    ema_model_t model = moving_model(0.1);
    double crossed_s[3] = {0.0};
    uint32_t crossings = 0U;
    double last_rad = 0.0;
    for (uint32_t k = 1; (k < 1000U) && (crossings < 3U); ++k) {
        (void)ema_rig_step(&model, EMA_R(0.0));
        const double angle_rad = (double)model.state.angle_rad;
        const double speed = (double)model.state.speed_rad_s;
        const double energy = (0.5 * J_KGM2 * speed * speed) + ((0.03 / 12.0) * (1.0 - cos(12.0 * angle_rad)));
        EMA_ASSERT_CLOSE(0.5 * J_KGM2 * 0.01, energy, 0.0, EMA_BY_PRECISION(3.0e-3, 2.0e-3));
        if ((last_rad < 0.0) && (angle_rad >= 0.0)) {
            crossed_s[crossings] = 1.0e-3 * (k - (angle_rad / (angle_rad - last_rad)));
            ++crossings;
        }
        last_rad = angle_rad;
    }
    TEST_ASSERT_EQUAL_UINT32(3U, crossings);
    EMA_ASSERT_CLOSE(2.0 * TURN / natural_rad_s, crossed_s[2] - crossed_s[0], 0.0, 2.0e-3);
}

static void test_constant_load_is_the_load_parameter(void)
{
    const ema_command_t command = ema_rig_chirp(EMA_R(6.0), EMA_R(2.0), EMA_R(1.0e-3));
    ema_actuator_t other = actuator;
    actuator.effects.constant_load.torque_Nm = EMA_R(0.0625);
    other.params.load_torque_Nm = EMA_R(0.0625);
    ema_model_t a = ema_rig_model(&actuator, EMA_R(0.0));
    ema_model_t b = ema_rig_model(&other, EMA_R(0.0));
    for (uint32_t k = 0; k < 2000U; ++k) {
        (void)ema_rig_step(&a, ema_command_at(&command, k));
        (void)ema_rig_step(&b, ema_command_at(&command, k));
    }
    EMA_ASSERT_SAME_BITS(&a.state, &b.state, sizeof a.state);
}

static void test_constant_load_acts_against_extension(void)
{
    actuator.effects.constant_load.torque_Nm = EMA_R(0.1);
    const ema_model_t out = steady_model(0.5);
    const ema_model_t in = steady_model(-0.5);
    const double slope = 1.0e-4 + (KT * KT / 0.99);
    EMA_ASSERT_CLOSE(-2.0 * 0.1 / slope, (double)out.state.speed_rad_s + (double)in.state.speed_rad_s, 0.0,
                     EMA_BY_PRECISION(1.0e-4, 1.0e-11));
}

static void test_winding_heating_is_a_resistance(void)
{
    actuator.effects.winding_heating.rise_degC = EMA_R(100.0);
    TEST_ASSERT_FALSE(active_now().any);
    actuator.params.csj_Nm = EMA_R(100.0);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    (void)ema_rig_hold(&model, EMA_R(20.0), 50U);
    EMA_ASSERT_CLOSE(24.0 / (0.99 * 1.393), model.state.current_A, 0.0, EMA_BY_PRECISION(1.0e-6, 1.0e-13));
}

static void test_dead_time_takes_its_voltage_off_a_locked_rotor(void)
{
    actuator.params.csj_Nm = EMA_R(100.0);
    actuator.effects.inverter_dead_time.drop_V = EMA_R(0.8);
    actuator.effects.inverter_dead_time.width_A = EMA_R(0.5);
    const double outputs[4] = {1.0, 0.05, -0.05, -1.0};
    for (uint32_t k = 0; k < 4U; ++k) {
        const double output = outputs[k];
        ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
        model.plant.pid.output_limit = (ema_real)fabs(output);
        (void)ema_rig_hold(&model, (output > 0.0) ? EMA_R(20.0) : EMA_R(-20.0), 60U);
        const double current_A = (double)model.state.current_A;
        const double taken_V = 0.8 * current_A / sqrt((current_A * current_A) + 0.25);
        EMA_ASSERT_CLOSE(output * 24.0, (0.99 * current_A) + taken_V, EMA_BY_PRECISION(1.0e-5, 1.0e-9), 0.0);
        TEST_ASSERT_TRUE(fabs(taken_V) > 0.4);
    }
}

static void test_dead_time_is_odd_and_fades_near_zero(void)
{
    const ema_effect_inverter_dead_time_t effect = {EMA_R(0.75), EMA_R(0.2)};
    const ema_site_t none = {.current_A = EMA_R(0.0)};
    const ema_site_t plus = {.current_A = EMA_R(0.15)};
    const ema_site_t minus = {.current_A = EMA_R(-0.15)};
    TEST_ASSERT_TRUE(ema_effect_inverter_dead_time(&effect, &none) == EMA_R(0.0));
    EMA_ASSERT_CLOSE(-0.75 * 0.6, ema_effect_inverter_dead_time(&effect, &plus), 0.0, 4.0 * EMA_EPS);
    EMA_ASSERT_CLOSE(0.75 * 0.6, ema_effect_inverter_dead_time(&effect, &minus), 0.0, 4.0 * EMA_EPS);
}

static void test_rod_rings_on_its_spring_behind_a_locked_rotor(void)
{
    const double ratios[3] = {0.0, 0.2, 0.9};
    for (uint32_t trial = 0; trial < 3U; ++trial) {
        const double zeta = ratios[trial];
        actuator.params.csj_Nm = EMA_R(100.0);
        actuator.effects.transmission_compliance.period_s = EMA_R(0.05);
        actuator.effects.transmission_compliance.damping_ratio = (ema_real)zeta;
        ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
        /* the rod is released 0.1 mm behind the play */
        model.state.effect_memory[0] = EMA_R(0.1);
        model.state.rod_mm = EMA_R(-0.1);
        const double natural_rad_s = TURN / 0.05;
        const double damped_rad_s = natural_rad_s * sqrt(1.0 - (zeta * zeta));
        for (uint32_t k = 0; k < 200U; ++k) {
            const double t = 1.0e-3 * k;
            const double fade = exp(-zeta * natural_rad_s * t);
            const double phase = damped_rad_s * t;
            const double stretch = 0.1 * fade * (cos(phase) + ((zeta * natural_rad_s / damped_rad_s) * sin(phase)));
            const double speed = 0.1 * fade * (natural_rad_s * natural_rad_s / damped_rad_s) * sin(phase);
            const ema_output_t row = ema_rig_step(&model, EMA_R(0.0));
            EMA_ASSERT_CLOSE(-stretch, row.position_mm, EMA_BY_PRECISION(4.0e-6, 1.0e-12), 0.0);
            EMA_ASSERT_CLOSE(speed, row.speed_mm_s, EMA_BY_PRECISION(5.0e-4, 1.0e-9), 0.0);
        }
    }
}

static void test_critical_damping_stays_finite(void)
{
    actuator.effects.transmission_compliance.period_s = EMA_R(0.02);
    actuator.effects.transmission_compliance.damping_ratio = EMA_R(1.0);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    const ema_output_t row = ema_rig_hold(&model, EMA_R(1.0), 1000U);
    /* dry friction leaves up to 0.23 mm, as without the spring */
    EMA_ASSERT_CLOSE(1.0, row.position_mm, 0.23, 0.0);
}

static void test_rod_and_shaft_swing_with_the_frequency_of_two_masses_and_keep_their_momentum(void)
{
    let_swing();
    const double mass_kg = 200.0;
    const double reflected = mass_kg * LEAD_MM * LEAD_MM * 1.0e-6;
    actuator.options.substeps = 8;
    actuator.effects.transmission_compliance.period_s = EMA_R(0.05);
    actuator.effects.transmission_compliance.mass_kg = (ema_real)mass_kg;
    actuator.effects.transmission_compliance.damping_ratio = EMA_R(0.0);
    ema_model_t model = moving_model(10.0);
    const double shaft = J_KGM2 - reflected;
    const double swing_rad_s = (TURN / 0.05) * sqrt(1.0 + (reflected / shaft));
    const double momentum = shaft * 10.0;
    for (uint32_t k = 0; k < 100U; ++k) {
        const ema_output_t row = ema_rig_step(&model, EMA_R(0.0));
        const double speed = (double)model.state.speed_rad_s;
        const double rod = (double)model.state.effect_memory[1] / LEAD_MM;
        /* the shaft's speed swings about that of the common mass centre */
        const double expected = (momentum + (reflected * 10.0 * cos(swing_rad_s * 1.0e-3 * (k + 1U)))) / J_KGM2;
        EMA_ASSERT_CLOSE(expected, speed, 0.01, 0.0);
        EMA_ASSERT_CLOSE(momentum, (shaft * speed) + (reflected * rod), 0.0, 1.0e-3);
        TEST_ASSERT_TRUE(isfinite((double)row.position_mm));
    }
}

static void test_delay_effect_is_the_delay_parameter(void)
{
    const ema_command_t command = ema_rig_chirp(EMA_R(6.0), EMA_R(2.0), EMA_R(1.0e-3));
    ema_actuator_t other = actuator;
    actuator.effects.feedback_delay.delay_s = EMA_R(0.0025);
    other.params.delay_s = EMA_R(0.0025);
    ema_model_t a = ema_rig_model(&actuator, EMA_R(0.0));
    ema_model_t b = ema_rig_model(&other, EMA_R(0.0));
    for (uint32_t k = 0; k < 2000U; ++k) {
        (void)ema_rig_step(&a, ema_command_at(&command, k));
        (void)ema_rig_step(&b, ema_command_at(&command, k));
    }
    EMA_ASSERT_SAME_BITS(&a.state, &b.state, sizeof a.state);
}

static void test_spring_load_swings_a_free_rotor(void)
{
    let_swing();
    actuator.options.substeps = 16;
    actuator.effects.spring_load.stiffness_Nm_per_mm = EMA_R(1.0);
    const double natural_rad_s = sqrt(LEAD_MM / J_KGM2);
    ema_model_t model = moving_model(10.0);
    for (uint32_t k = 1; k <= 300U; ++k) {
        (void)ema_rig_step(&model, EMA_R(0.0));
        EMA_ASSERT_CLOSE(10.0 * cos(natural_rad_s * 1.0e-3 * k), model.state.speed_rad_s, 0.01, 0.0);
    }
}

static void test_spring_load_is_held_up_to_the_static_level(void)
{
    actuator.params.kp_per_m = EMA_R(0.0);
    actuator.params.ki_per_m_s = EMA_R(0.0);
    actuator.effects.spring_load.stiffness_Nm_per_mm = EMA_R(0.1);
    ema_model_t held = ema_rig_model(&actuator, EMA_R(1.37));
    (void)ema_rig_hold(&held, EMA_R(0.0), 100U);
    TEST_ASSERT_EQUAL_INT32(EMA_MOTION_STUCK, held.state.motion);
    ema_model_t released = ema_rig_model(&actuator, EMA_R(1.39));
    (void)ema_rig_hold(&released, EMA_R(0.0), 20U);
    TEST_ASSERT_TRUE(released.state.motor_mm < EMA_R(1.39));
}

static void test_load_loses_power_in_the_gears(void)
{
    /* held with efficiency 0.8: the level grows by a quarter of an opposing load, by a fifth of an aiding one */
    actuator.params.kp_per_m = EMA_R(0.0);
    actuator.params.ki_per_m_s = EMA_R(0.0);
    actuator.params.efficiency = EMA_R(0.8);
    actuator.effects.spring_load.stiffness_Nm_per_mm = EMA_R(0.1);
    /* the spring pulls back: 0.1 x > 0.138 + 0.2 * 0.1 x from x = 1.725 on */
    ema_model_t held = ema_rig_model(&actuator, EMA_R(1.72));
    (void)ema_rig_hold(&held, EMA_R(0.0), 100U);
    TEST_ASSERT_EQUAL_INT32(EMA_MOTION_STUCK, held.state.motion);
    ema_model_t released = ema_rig_model(&actuator, EMA_R(1.73));
    (void)ema_rig_hold(&released, EMA_R(0.0), 20U);
    TEST_ASSERT_TRUE(released.state.motor_mm < EMA_R(1.73));
}

/* A caller may ask any site, whether an effect acts there or not. */
static void test_a_site_without_active_effects_adds_nothing(void)
{
    const ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    const ema_plant_t* const plant = &model.plant;
    const ema_site_t site = {.plant = plant,
                             .speed_rad_s = EMA_R(20.0),
                             .angle_rad = EMA_R(0.7),
                             .position_mm = EMA_R(0.1),
                             .current_A = EMA_R(3.0),
                             .voltage_V = EMA_R(12.0)};
    TEST_ASSERT_TRUE(ema_site_friction(plant, &site, EMA_R(0.138)) == EMA_R(0.0));
    TEST_ASSERT_TRUE(ema_site_torque(plant, &site) == EMA_R(0.0));
    TEST_ASSERT_TRUE(ema_site_load(plant, &site) == EMA_R(0.0));
    TEST_ASSERT_TRUE(ema_site_voltage(plant, &site) == EMA_R(0.0));
    TEST_ASSERT_TRUE(ema_site_motor(plant, &site) == EMA_R(0.0));
    TEST_ASSERT_TRUE(ema_site_reading(plant, &site) == EMA_R(0.0));
    ema_real memory[EMA_EFFECT_MEMORY_LENGTH];
    for (uint32_t k = 0; k < (uint32_t)EMA_EFFECT_MEMORY_LENGTH; ++k) {
        memory[k] = EMA_R(0.25);
    }
    TEST_ASSERT_TRUE(ema_site_presliding(plant, memory, EMA_R(0.1)) == EMA_R(0.0));
    TEST_ASSERT_TRUE(ema_site_winding(plant, memory) == EMA_R(0.0));
    TEST_ASSERT_TRUE(ema_site_grease(plant, memory) == EMA_R(0.0));
    ema_site_presliding_keep(plant, memory, EMA_R(0.5));
    const ema_transmission_t step = {EMA_R(0.0), EMA_R(0.3), plant->substep_s, plant->gearbox.lead_mm_per_rad};
    ema_rod_t rod;
    ema_site_transmission(plant, &step, memory, &rod);
    TEST_ASSERT_TRUE(rod.rod_mm == EMA_R(0.3));
    TEST_ASSERT_TRUE(rod.rod_speed_mm_s == EMA_R(0.0));
    for (uint32_t k = 0; k < (uint32_t)EMA_EFFECT_MEMORY_LENGTH; ++k) {
        TEST_ASSERT_TRUE(memory[k] == EMA_R(0.25));
    }
}

/* With effects, steps are not exact: their error against much finer steps must stay small and fall with the substeps.
 */
static void test_effects_converge_with_substeps(void)
{
    const ema_command_t command = ema_rig_chirp(EMA_R(6.0), EMA_R(2.0), EMA_R(1.0e-3));
    const int32_t substeps[3] = {0, 16, 64};
    ema_model_t model[3];
    double worst_mm[2] = {0.0, 0.0};
    actuator.effects.stribeck_friction.rise = EMA_R(0.4);
    actuator.effects.cogging_torque.amplitude_Nm = EMA_R(0.03);
    actuator.effects.inverter_dead_time.drop_V = EMA_R(0.5);
    actuator.effects.spring_load.stiffness_Nm_per_mm = EMA_R(0.05);
    for (uint32_t k = 0; k < 3U; ++k) {
        actuator.options.substeps = substeps[k];
        model[k] = ema_rig_model(&actuator, EMA_R(0.0));
    }
    for (uint32_t k = 0; k < 2000U; ++k) {
        const ema_real command_mm = ema_command_at(&command, k);
        const double fine_mm = (double)ema_rig_step(&model[2], command_mm).position_mm;
        for (uint32_t m = 0; m < 2U; ++m) {
            worst_mm[m] = fmax(worst_mm[m], fabs((double)ema_rig_step(&model[m], command_mm).position_mm - fine_mm));
        }
    }
    TEST_ASSERT_TRUE(worst_mm[0] < 4.0e-4);
    TEST_ASSERT_TRUE(worst_mm[1] < 2.0e-4);
    TEST_ASSERT_TRUE(worst_mm[0] > 0.0);
}

/* Largest rod position error of steps that the model chooses against the finest. */
static double worst_of_own_steps_mm(void)
{
    const ema_command_t command = ema_rig_chirp(EMA_R(6.0), EMA_R(2.0), EMA_R(1.0e-3));
    double worst_mm = 0.0;
    actuator.options.substeps = 0;
    ema_model_t own = ema_rig_model(&actuator, EMA_R(0.0));
    actuator.options.substeps = 64;
    ema_model_t fine = ema_rig_model(&actuator, EMA_R(0.0));
    for (uint32_t k = 0; k < 2000U; ++k) {
        const ema_real command_mm = ema_command_at(&command, k);
        const double fine_mm = (double)ema_rig_step(&fine, command_mm).position_mm;
        worst_mm = fmax(worst_mm, fabs((double)ema_rig_step(&own, command_mm).position_mm - fine_mm));
    }
    return worst_mm;
}

/* A ripple that turns once in a step looks even at its ends and half way. */
static void test_own_steps_see_a_fast_ripple(void)
{
    actuator.effects.cogging_torque.amplitude_Nm = EMA_R(0.015);
    actuator.effects.cogging_torque.periods = EMA_R(72.0);
    TEST_ASSERT_TRUE(worst_of_own_steps_mm() < 2.0e-4);
}

/* A current that follows the voltage at once does not bend inside a step. */
static void test_own_steps_without_inductance(void)
{
    actuator.params.inductance_H = EMA_R(0.0);
    actuator.effects.cogging_torque.amplitude_Nm = EMA_R(0.015);
    TEST_ASSERT_TRUE(worst_of_own_steps_mm() < 2.0e-4);
}

/* An output that comes late splits the step, and what acts on the motion acts in both parts: forward, the asymmetry is
 * more viscous damping. */
static void test_effect_acts_in_both_parts_of_a_late_step(void)
{
    actuator.params.output_delay_s = EMA_R(4.0e-4);
    actuator.params.viscous_Nm_s_per_rad = EMA_R(2.0e-3);
    ema_actuator_t plain = actuator;
    actuator.effects.viscous_asymmetry.asymmetry = EMA_R(0.5);
    plain.params.viscous_Nm_s_per_rad = EMA_R(3.0e-3);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    ema_model_t same = ema_rig_model(&plain, EMA_R(0.0));
    for (uint32_t k = 0; k < 200U; ++k) {
        const ema_output_t row = ema_rig_step(&model, EMA_R(20.0));
        const ema_output_t expected = ema_rig_step(&same, EMA_R(20.0));
        EMA_ASSERT_CLOSE(expected.motor_position_mm, row.motor_position_mm, 2.0e-5, 1.0e-5);
        TEST_ASSERT_TRUE(model.state.speed_rad_s >= EMA_R(0.0));
    }
    TEST_ASSERT_TRUE(model.state.motor_mm > EMA_R(2.0));
}

/* A contact that is turned back inside a step keeps part of its stretch. */
static void test_own_steps_see_a_short_stretch(void)
{
    actuator.effects.presliding.stretch_rad = EMA_R(0.001);
    TEST_ASSERT_TRUE(worst_of_own_steps_mm() < 2.0e-4);
}

/* A rod that swings at 300 Hz. */
static void test_own_steps_see_a_stiff_transmission(void)
{
    actuator.effects.transmission_compliance.period_s = EMA_R(0.0033);
    TEST_ASSERT_TRUE(worst_of_own_steps_mm() < 2.0e-4);
}

static void test_effects_keep_limits_and_stops(void)
{
    const ema_command_t command = ema_rig_chirp(EMA_R(10.0), EMA_R(2.0), EMA_R(1.0e-3));
    actuator.params.travel_mm = EMA_R(1.0);
    actuator.params.current_limit_A = EMA_R(6.0);
    actuator.effects.stribeck_friction.rise = EMA_R(0.4);
    actuator.effects.cogging_torque.amplitude_Nm = EMA_R(0.03);
    actuator.effects.inverter_dead_time.drop_V = EMA_R(0.5);
    actuator.effects.transmission_compliance.period_s = EMA_R(0.02);
    ema_model_t model = ema_rig_model(&actuator, EMA_R(0.0));
    uint32_t at_limit = 0U;
    uint32_t at_stop = 0U;
    for (uint32_t k = 0; k < 2000U; ++k) {
        (void)ema_rig_step(&model, ema_command_at(&command, k));
        TEST_ASSERT_TRUE(fabs((double)model.state.current_A) <= 6.0);
        EMA_ASSERT_CLOSE(0.0, fmax(fabs((double)model.state.motor_mm) - 1.0, 0.0), 4.0 * EMA_EPS, 0.0);
        at_limit += (fabs((double)model.state.current_A) == 6.0) ? 1U : 0U;
        at_stop += (model.state.angle_rad == model.plant.screw.stop_upper_rad) ? 1U : 0U;
    }
    TEST_ASSERT_TRUE((at_limit > 20U) && (at_stop > 20U));
    TEST_ASSERT_EQUAL_UINT32(0U, model.state.unlocated_event_steps);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_zero_is_nominal_for_every_size);
    RUN_TEST(test_every_effect_at_zero_is_absent_bit_for_bit);
    RUN_TEST(test_every_effect_is_felt_when_it_is_not_zero);
    RUN_TEST(test_effects_add_up_over_sites);
    RUN_TEST(test_stribeck_level_falls_with_speed);
    RUN_TEST(test_stribeck_rise_is_whole_at_rest);
    RUN_TEST(test_stribeck_raises_the_torque_that_breaks_away);
    RUN_TEST(test_stribeck_balances_the_steady_speed);
    RUN_TEST(test_cogging_torque_is_periodic_in_the_angle);
    RUN_TEST(test_rotor_swings_in_cogging_with_its_period_and_keeps_its_energy);
    RUN_TEST(test_constant_load_is_the_load_parameter);
    RUN_TEST(test_constant_load_acts_against_extension);
    RUN_TEST(test_winding_heating_is_a_resistance);
    RUN_TEST(test_dead_time_takes_its_voltage_off_a_locked_rotor);
    RUN_TEST(test_dead_time_is_odd_and_fades_near_zero);
    RUN_TEST(test_rod_rings_on_its_spring_behind_a_locked_rotor);
    RUN_TEST(test_critical_damping_stays_finite);
    RUN_TEST(test_rod_and_shaft_swing_with_the_frequency_of_two_masses_and_keep_their_momentum);
    RUN_TEST(test_delay_effect_is_the_delay_parameter);
    RUN_TEST(test_spring_load_swings_a_free_rotor);
    RUN_TEST(test_spring_load_is_held_up_to_the_static_level);
    RUN_TEST(test_load_loses_power_in_the_gears);
    RUN_TEST(test_effects_converge_with_substeps);
    RUN_TEST(test_a_site_without_active_effects_adds_nothing);
    RUN_TEST(test_own_steps_see_a_fast_ripple);
    RUN_TEST(test_own_steps_without_inductance);
    RUN_TEST(test_effect_acts_in_both_parts_of_a_late_step);
    RUN_TEST(test_own_steps_see_a_short_stretch);
    RUN_TEST(test_own_steps_see_a_stiff_transmission);
    RUN_TEST(test_effects_keep_limits_and_stops);
    return UNITY_END();
}
