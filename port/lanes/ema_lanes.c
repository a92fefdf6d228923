#include "ema_lanes.h"

#include "ema_effect_sites.h"

/* One number of every lane from its plant. */
#define EMA_LANES_OF(name, block)                                                                                      \
    EMA_EACH_LANE                                                                                                      \
    {                                                                                                                  \
        lanes->constant.name[l] = lanes->plant[l].block.name;                                                          \
    }

bool ema_lanes_alike(const ema_plant_t* one, const ema_plant_t* other)
{
    bool alike = (one->tries_whole_step == other->tries_whole_step) && (one->substeps == other->substeps)
                 && (one->active.any == other->active.any) && (one->pid.plain == other->pid.plain)
                 && (one->pid.every_steps == other->pid.every_steps) && (one->encoder.plain == other->encoder.plain)
                 && (one->encoder.at_rod == other->encoder.at_rod)
                 && (one->drive.current_mode == other->drive.current_mode)
                 && (one->drive.delayed == other->drive.delayed)
                 && ((one->drive.delay_part > EMA_R(0.0)) == (other->drive.delay_part > EMA_R(0.0)))
                 && (one->motor_circuit.algebraic == other->motor_circuit.algebraic)
                 && (one->current_loop.algebraic == other->current_loop.algebraic);
    for (uint32_t k = 0; alike && (k < (uint32_t)EMA_EFFECT_COUNT); ++k) {
        const uint32_t differ = one->active.present[k / 32U] ^ other->active.present[k / 32U];
        /* what acts before the run has become numbers of the plant */
        alike = (((differ >> (k % 32U)) & 1U) == 0U) || (ema_effect_rows[k].site == (uint8_t)EMA_SITE_PARAMETER);
    }
    return alike;
}

void ema_lanes_leave(const ema_lanes_t* lanes, uint32_t lane, ema_state_t* state)
{
    const ema_lanes_state_t* const now = &lanes->now;
    state->motion = (int32_t)now->motion[lane];
    state->play_side = (int32_t)now->play_side[lane];
    state->step = lanes->step;
    state->current_A = now->current_A[lane];
    state->speed_rad_s = now->speed_rad_s[lane];
    state->angle_rad = now->angle_rad[lane];
    state->angle_low_rad = now->angle_low_rad[lane];
    state->motor_mm = now->motor_mm[lane];
    state->play_mm = now->play_mm[lane];
    state->rod_mm = now->rod_mm[lane];
    state->rod_speed_mm_s = now->rod_speed_mm_s[lane];
    state->integral = now->integral[lane];
    state->output = now->output[lane];
    for (uint32_t k = 0; k < (uint32_t)EMA_EFFECT_MEMORY_COUNT; ++k) {
        state->effect_memory[k] = now->effect_memory[k][lane];
    }
}

void ema_lanes_return(ema_lanes_t* lanes, uint32_t lane)
{
    const ema_state_t* const state = &lanes->state[lane];
    ema_lanes_state_t* const now = &lanes->now;
    now->motion[lane] = (ema_real)state->motion;
    now->play_side[lane] = (ema_real)state->play_side;
    now->current_A[lane] = state->current_A;
    now->speed_rad_s[lane] = state->speed_rad_s;
    now->angle_rad[lane] = state->angle_rad;
    now->angle_low_rad[lane] = state->angle_low_rad;
    now->motor_mm[lane] = state->motor_mm;
    now->play_mm[lane] = state->play_mm;
    now->rod_mm[lane] = state->rod_mm;
    now->rod_speed_mm_s[lane] = state->rod_speed_mm_s;
    now->integral[lane] = state->integral;
    now->output[lane] = state->output;
    for (uint32_t k = 0; k < (uint32_t)EMA_EFFECT_MEMORY_COUNT; ++k) {
        now->effect_memory[k][lane] = state->effect_memory[k];
    }
}

static void ema_lanes_responses(ema_lanes_responses_t* to, const ema_responses_t* from, uint32_t lane)
{
    const ema_real* const current = (const ema_real*)(const void*)&from->current;
    const ema_real* const speed = (const ema_real*)(const void*)&from->speed;
    const ema_real* const angle = (const ema_real*)(const void*)&from->angle;
    const ema_real* const stuck = &from->stuck_from_current;
    for (uint32_t k = 0; k < EMA_RESPONSES; ++k) {
        to->current[k][lane] = current[k];
        to->speed[k][lane] = speed[k];
        to->angle[k][lane] = angle[k];
    }
    for (uint32_t k = 0; k < ((EMA_RESPONSES - 1U) / 2U); ++k) {
        to->stuck[k][lane] = stuck[k];
    }
}

void ema_lanes_start(ema_lanes_t* lanes)
{
    EMA_LANES_OF(period_s, pid)
    EMA_LANES_OF(gain, pid)
    EMA_LANES_OF(integral_gain, pid)
    EMA_LANES_OF(anti_windup_per_s, pid)
    EMA_LANES_OF(output_limit, pid)
    EMA_LANES_OF(supply_V, drive)
    EMA_LANES_OF(torque_constant_Nm_per_A, motor)
    EMA_LANES_OF(back_emf_V_s_per_rad, motor)
    EMA_LANES_OF(torque_limit_Nm, motor)
    EMA_LANES_OF(resistance_ohm, motor)
    EMA_LANES_OF(lead_mm, gearbox)
    EMA_LANES_OF(lead_mm_per_rad, gearbox)
    EMA_LANES_OF(loss_opposing, gearbox)
    EMA_LANES_OF(loss_aiding, gearbox)
    EMA_LANES_OF(inverse_inertia_per_kgm2, screw)
    EMA_LANES_OF(viscous_Nm_s_per_rad, screw)
    EMA_LANES_OF(static_Nm, screw)
    EMA_LANES_OF(dynamic_Nm, screw)
    EMA_LANES_OF(asymmetry, screw)
    EMA_LANES_OF(load_torque_Nm, screw)
    EMA_LANES_OF(forward_torque_Nm, screw)
    EMA_LANES_OF(backward_torque_Nm, screw)
    EMA_LANES_OF(hold_lower_Nm, screw)
    EMA_LANES_OF(hold_upper_Nm, screw)
    EMA_LANES_OF(stop_lower_rad, screw)
    EMA_LANES_OF(stop_upper_rad, screw)
    EMA_LANES_OF(half_play_mm, screw)
    EMA_LANES_OF(rod_gain, encoder)
    EMA_LANES_OF(rod_offset_mm, encoder)
    EMA_EACH_LANE
    {
        const ema_plant_t* const plant = &lanes->plant[l];
        const ema_circuit_t* const circuit = plant->drive.current_mode ? &plant->current_loop : &plant->motor_circuit;
        const ema_real* const held = (const ema_real*)(const void*)&plant->effects;
        for (size_t k = 0; k < (sizeof plant->effects / sizeof *held); ++k) {
            lanes->held[k][l] = held[k];
        }
        lanes->constant.algebraic[l] = circuit->algebraic ? EMA_R(1.0) : EMA_R(0.0);
        lanes->constant.rate_current[l] = circuit->rate_current;
        lanes->constant.rate_speed[l] = circuit->rate_speed;
        lanes->constant.rate_voltage[l] = circuit->rate_voltage;
        lanes->constant.linear_current_A[l] = plant->linear_current_A;
        lanes->constant.held_current_A[l] =
            (plant->drive.current_limit_A < plant->torque_limit_A) ? plant->drive.current_limit_A : EMA_R(-1.0);
        lanes->constant.step_s[l] = plant->step_s;
        lanes->substep_s[l] = plant->substep_s;
        lanes->asked[l] = EMA_R(1.0);
        ema_lanes_responses(&lanes->responses[0], &plant->responses[0], l);
        ema_lanes_responses(&lanes->responses[1], &plant->responses[1], l);
        ema_lanes_return(lanes, l);
    }
    lanes->row = &lanes->rows[0];
    lanes->step = 0U;
    lanes->lane_spans = 0U;
    lanes->left_spans = 0U;
}
