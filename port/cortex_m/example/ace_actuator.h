/* reference actuator: written by ema export. To change it, change the actuator's TOML file and export again. */
#ifndef EMA_EXPORTED_ACTUATOR_H
#define EMA_EXPORTED_ACTUATOR_H

#include "ema/ema.h"

#if EMA_CONFIG_SCHEMA != 0x54d1750eU
#error "EMA_ACTUATOR: made for other lists of values than those of this module: export it again: ema export ACTUATOR -o FILE.h"
#endif

static const ema_actuator_t EMA_ACTUATOR = {
    .params = {
        .kp_per_m = EMA_R(400.0), /* 400 1/m */
        .ki_per_m_s = EMA_R(400.0), /* 400 1/(m s) */
        .kd_s_per_m = EMA_R(0.0), /* 0 s/m */
        .anti_windup_per_s = EMA_R(50.0), /* 50 1/s */
        .output_limit = EMA_R(1.0), /* 1 */
        .position_gain_per_s = EMA_R(0.0), /* 0 1/s */
        .speed_gain_s_per_m = EMA_R(0.0), /* 0 s/m */
        .speed_integral_per_m = EMA_R(0.0), /* 0 1/m */
        .speed_limit_m_s = EMA_R(0.0), /* 0 m/s */
        .supply_V = EMA_R(24.0), /* 24 V */
        .current_limit_A = EMA_R(0.0), /* 0 A */
        .current_scale_A = EMA_R(1.0), /* 1 A */
        .current_loop_s = EMA_R(0.0), /* 0 s */
        .output_delay_s = EMA_R(0.0), /* 0 s */
        .command_scale_V = EMA_R(0.0), /* 0 V */
        .torque_constant_Nm_per_A = EMA_R(0x1.f559b3d07c84bp-5), /* 0.0612 Nm/A */
        .back_emf_V_s_per_rad = EMA_R(0x1.f559b3d07c84bp-5), /* 0.0612 V s/rad */
        .resistance_ohm = EMA_R(0x1.fae147ae147aep-1), /* 0.99 ohm */
        .inductance_H = EMA_R(0x1.a36e2eb1c432dp-11), /* 0.0008 H */
        .torque_limit_Nm = EMA_R(0x1.7ae147ae147aep+0), /* 1.48 Nm */
        .ratio = EMA_R(4.0), /* 4 */
        .efficiency = EMA_R(1.0), /* 1 */
        .lead_mm = EMA_R(5.0), /* 5 mm */
        .inertia_kgm2 = EMA_R(0x1.f75104d551d69p-15), /* 6e-05 kg m2 */
        .viscous_Nm_s_per_rad = EMA_R(0x1.a36e2eb1c432dp-14), /* 0.0001 Nm s/rad */
        .csj_Nm = EMA_R(0x1.1a9fbe76c8b44p-3), /* 0.138 Nm */
        .dynamic_ratio = EMA_R(1.0), /* 1 */
        .friction_asymmetry = EMA_R(0.0), /* 0 */
        .load_torque_Nm = EMA_R(0.0), /* 0 Nm */
        .blk_mm = EMA_R(0x1.0e5604189374cp-5), /* 0.033 mm */
        .travel_mm = EMA_R(25.0), /* 25 mm */
        .resolution_mm = EMA_R(0.0), /* 0 mm */
        .delay_s = EMA_R(0.0), /* 0 s */
        .rod_gain_error = EMA_R(0.0), /* 0 */
        .rod_offset_mm = EMA_R(0.0), /* 0 mm */
        .step_s = EMA_R(0x1.0624dd2f1a9fcp-10), /* 0.001 s */
        .csj_lower_Nm = EMA_R(0x1.47ae147ae147bp-7), /* 0.01 Nm */
        .csj_upper_Nm = EMA_R(0x1.8000000000000p+0), /* 1.5 Nm */
        .blk_lower_mm = EMA_R(0.0), /* 0 mm */
        .blk_upper_mm = EMA_R(0x1.999999999999ap-4), /* 0.1 mm */
        .initial_temperature_mm2s = EMA_R(0x1.999999999999ap-5), /* 0.05 mm2 s */
        .cooling = EMA_R(0x1.bd70a3d70a3d7p-1), /* 0.87 */
        .function_tolerance_mm2s = EMA_R(0x1.c25c268497682p-44), /* 1e-13 mm2 s */
        .csj_min_shift_percent = EMA_R(5.0), /* 5 % */
        .blk_min_shift_percent = EMA_R(10.0), /* 10 % */
        .csj_scatter_percent = EMA_R(0.0), /* 0 % */
        .blk_scatter_percent = EMA_R(0.0), /* 0 % */
        .csj_day_scatter_percent = EMA_R(0.0), /* 0 % */
        .csj_per_degC_percent = EMA_R(0.0), /* 0 % */
        .csj_per_degC_std_percent = EMA_R(0.0), /* 0 % */
        .day_winding_ratio = EMA_R(0.0), /* 0 */
        .day_apart_degC = EMA_R(0.0), /* 0 degC */
        .command_speed_mm_s = EMA_R(0.0), /* 0 mm/s */
        .unseen_percent = EMA_R(0.0), /* 0 % */
        .position_noise_mm = EMA_R(0x1.47ae147ae147bp-8), /* 0.005 mm */
        .shared_noise_mm = EMA_R(0.0), /* 0 mm */
        .confidence_std = EMA_R(3.0), /* 3 */
        .adequacy_ratio = EMA_R(2.0), /* 2 */
        .structure_ratio = EMA_R(0x1.3333333333333p-2), /* 0.3 */
    },
    .options = {
        .structure = 0, /* pid */
        .derivative = 0, /* error */
        .average_speed = 0, /* no */
        .every_steps = 1,
        .mode = 0, /* voltage */
        .side = 0, /* motor */
        .record_every_steps = 1,
        .substeps = 0,
        .reanneal_interval = 60,
        .evaluation_budget = 400,
        .seed = 1,
        .day_values = 0, /* no */
    },
    .effects = {
        .stribeck_friction = {
            .rise = EMA_R(0.0), /* 0 */
            .speed_rad_s = EMA_R(10.0), /* 10 rad/s */
            .shape = EMA_R(1.0), /* 1 */
        },
        .cogging_torque = {
            .amplitude_Nm = EMA_R(0.0), /* 0 Nm */
            .periods = EMA_R(12.0), /* 12 */
            .phase_rad = EMA_R(0.0), /* 0 rad */
        },
        .constant_load = {
            .torque_Nm = EMA_R(0.0), /* 0 Nm */
        },
        .winding_heating = {
            .rise_degC = EMA_R(0.0), /* 0 degC */
        },
        .inverter_dead_time = {
            .drop_V = EMA_R(0.0), /* 0 V */
            .width_A = EMA_R(0x1.999999999999ap-3), /* 0.2 A */
        },
        .transmission_compliance = {
            .period_s = EMA_R(0.0), /* 0 s */
            .mass_kg = EMA_R(5.0), /* 5 kg */
            .damping_ratio = EMA_R(0x1.999999999999ap-5), /* 0.05 */
        },
        .feedback_delay = {
            .delay_s = EMA_R(0.0), /* 0 s */
        },
        .spring_load = {
            .stiffness_Nm_per_mm = EMA_R(0.0), /* 0 Nm/mm */
        },
        .presliding = {
            .stretch_rad = EMA_R(0.0), /* 0 rad */
        },
        .coulomb_asymmetry = {
            .asymmetry = EMA_R(0.0), /* 0 */
        },
        .viscous_asymmetry = {
            .asymmetry = EMA_R(0.0), /* 0 */
        },
        .load_dependent_friction = {
            .ratio = EMA_R(0.0), /* 0 */
        },
        .pitch_ripple = {
            .ratio = EMA_R(0.0), /* 0 */
            .phase_rad = EMA_R(0.0), /* 0 rad */
        },
        .torque_ripple = {
            .ratio = EMA_R(0.0), /* 0 */
            .periods = EMA_R(6.0), /* 6 */
            .phase_rad = EMA_R(0.0), /* 0 rad */
        },
        .magnet_weakening = {
            .loss = EMA_R(0.0), /* 0 */
        },
        .supply_sag = {
            .sag = EMA_R(0.0), /* 0 */
        },
        .source_resistance = {
            .resistance_ohm = EMA_R(0.0), /* 0 ohm */
        },
        .current_limit = {
            .limit_A = EMA_R(0.0), /* 0 A */
        },
        .sensor_gain = {
            .error = EMA_R(0.0), /* 0 */
        },
        .sensor_offset = {
            .offset_mm = EMA_R(0.0), /* 0 mm */
        },
        .actuation_delay = {
            .delay_s = EMA_R(0.0), /* 0 s */
        },
        .viscous_rise = {
            .rise = EMA_R(0.0), /* 0 */
        },
        .concave_viscous = {
            .drag_Nm_per_sqrt_rad_s = EMA_R(0.0), /* 0 Nm/sqrt(rad/s) */
        },
        .quadratic_viscous = {
            .drag_Nm_s2_per_rad2 = EMA_R(0.0), /* 0 Nm s2/rad2 */
        },
        .jam_spot = {
            .amplitude_Nm = EMA_R(0.0), /* 0 Nm */
            .place_mm = EMA_R(0.0), /* 0 mm */
            .width_mm = EMA_R(0x1.3333333333333p-2), /* 0.3 mm */
        },
        .inertia_change = {
            .change = EMA_R(0.0), /* 0 */
        },
        .gain_drift = {
            .drift = EMA_R(0.0), /* 0 */
        },
        .learned_torque = {
            .gain = EMA_R(0.0), /* 0 */
            .axis = EMA_R(1.0), /* 1 */
            .first = EMA_R(-1.0), /* -1 */
            .last = EMA_R(1.0), /* 1 */
            .node_00 = EMA_R(0.0), /* 0 */
            .node_01 = EMA_R(0.0), /* 0 */
            .node_02 = EMA_R(0.0), /* 0 */
            .node_03 = EMA_R(0.0), /* 0 */
            .node_04 = EMA_R(0.0), /* 0 */
            .node_05 = EMA_R(0.0), /* 0 */
            .node_06 = EMA_R(0.0), /* 0 */
            .node_07 = EMA_R(0.0), /* 0 */
            .node_08 = EMA_R(0.0), /* 0 */
            .node_09 = EMA_R(0.0), /* 0 */
            .node_10 = EMA_R(0.0), /* 0 */
            .node_11 = EMA_R(0.0), /* 0 */
            .node_12 = EMA_R(0.0), /* 0 */
            .node_13 = EMA_R(0.0), /* 0 */
            .node_14 = EMA_R(0.0), /* 0 */
            .node_15 = EMA_R(0.0), /* 0 */
        },
        .learned_friction = {
            .gain = EMA_R(0.0), /* 0 */
            .axis = EMA_R(1.0), /* 1 */
            .first = EMA_R(-1.0), /* -1 */
            .last = EMA_R(1.0), /* 1 */
            .node_00 = EMA_R(0.0), /* 0 */
            .node_01 = EMA_R(0.0), /* 0 */
            .node_02 = EMA_R(0.0), /* 0 */
            .node_03 = EMA_R(0.0), /* 0 */
            .node_04 = EMA_R(0.0), /* 0 */
            .node_05 = EMA_R(0.0), /* 0 */
            .node_06 = EMA_R(0.0), /* 0 */
            .node_07 = EMA_R(0.0), /* 0 */
            .node_08 = EMA_R(0.0), /* 0 */
            .node_09 = EMA_R(0.0), /* 0 */
            .node_10 = EMA_R(0.0), /* 0 */
            .node_11 = EMA_R(0.0), /* 0 */
            .node_12 = EMA_R(0.0), /* 0 */
            .node_13 = EMA_R(0.0), /* 0 */
            .node_14 = EMA_R(0.0), /* 0 */
            .node_15 = EMA_R(0.0), /* 0 */
        },
        .learned_voltage = {
            .gain = EMA_R(0.0), /* 0 */
            .axis = EMA_R(1.0), /* 1 */
            .first = EMA_R(-1.0), /* -1 */
            .last = EMA_R(1.0), /* 1 */
            .node_00 = EMA_R(0.0), /* 0 */
            .node_01 = EMA_R(0.0), /* 0 */
            .node_02 = EMA_R(0.0), /* 0 */
            .node_03 = EMA_R(0.0), /* 0 */
            .node_04 = EMA_R(0.0), /* 0 */
            .node_05 = EMA_R(0.0), /* 0 */
            .node_06 = EMA_R(0.0), /* 0 */
            .node_07 = EMA_R(0.0), /* 0 */
            .node_08 = EMA_R(0.0), /* 0 */
            .node_09 = EMA_R(0.0), /* 0 */
            .node_10 = EMA_R(0.0), /* 0 */
            .node_11 = EMA_R(0.0), /* 0 */
            .node_12 = EMA_R(0.0), /* 0 */
            .node_13 = EMA_R(0.0), /* 0 */
            .node_14 = EMA_R(0.0), /* 0 */
            .node_15 = EMA_R(0.0), /* 0 */
        },
        .learned_reading = {
            .gain = EMA_R(0.0), /* 0 */
            .axis = EMA_R(1.0), /* 1 */
            .first = EMA_R(-1.0), /* -1 */
            .last = EMA_R(1.0), /* 1 */
            .node_00 = EMA_R(0.0), /* 0 */
            .node_01 = EMA_R(0.0), /* 0 */
            .node_02 = EMA_R(0.0), /* 0 */
            .node_03 = EMA_R(0.0), /* 0 */
            .node_04 = EMA_R(0.0), /* 0 */
            .node_05 = EMA_R(0.0), /* 0 */
            .node_06 = EMA_R(0.0), /* 0 */
            .node_07 = EMA_R(0.0), /* 0 */
            .node_08 = EMA_R(0.0), /* 0 */
            .node_09 = EMA_R(0.0), /* 0 */
            .node_10 = EMA_R(0.0), /* 0 */
            .node_11 = EMA_R(0.0), /* 0 */
            .node_12 = EMA_R(0.0), /* 0 */
            .node_13 = EMA_R(0.0), /* 0 */
            .node_14 = EMA_R(0.0), /* 0 */
            .node_15 = EMA_R(0.0), /* 0 */
        },
        .directional_stribeck = {
            .rise = EMA_R(0.0), /* 0 */
            .asymmetry = EMA_R(0x1.0000000000000p-1), /* 0.5 */
            .speed_rad_s = EMA_R(10.0), /* 10 rad/s */
            .shape = EMA_R(1.0), /* 1 */
        },
        .load_dependent_stribeck = {
            .ratio = EMA_R(0.0), /* 0 */
            .speed_rad_s = EMA_R(10.0), /* 10 rad/s */
            .shape = EMA_R(1.0), /* 1 */
        },
        .winding_warming = {
            .rise_degC_per_W = EMA_R(0.0), /* 0 degC/W */
            .time_s = EMA_R(10.0), /* 10 s */
        },
        .grease_warming = {
            .fall = EMA_R(0.0), /* 0 */
            .time_s = EMA_R(5.0), /* 5 s */
        },
        .elastic_backlash = {
            .gap_mm = EMA_R(0.0), /* 0 mm */
            .contact_mm = EMA_R(0x1.3333333333333p-2), /* 0.3 mm */
        },
    },
};

#endif
