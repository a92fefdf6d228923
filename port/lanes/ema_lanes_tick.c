/* One model step of all lanes: ema_tick, with what ema_model_step does around it. */
#include "ema_delayed.h"
#include "ema_drive.h"
#include "ema_effect_sites.h"
#include "ema_encoder.h"
#include "ema_lanes.h"
#include "ema_pid.h"
#include "ema_screw.h"

/* What the sensors read, and what the rod does. */
static void ema_lanes_read(ema_lanes_t* lanes)
{
    ema_lanes_output_t* const row = lanes->row;
    const ema_lanes_state_t* const now = &lanes->now;
    const ema_real transmits = ema_flag(ema_acts(&lanes->plant[0], EMA_SITE_TRANSMISSION));
    EMA_EACH_LANE
    {
        const ema_encoder_t encoder = {.rod_gain = lanes->constant.rod_gain[l],
                                       .rod_offset_mm = lanes->constant.rod_offset_mm[l]};
        const ema_real carried = ema_flag((now->play_side[l] * now->speed_rad_s[l]) > EMA_R(0.0));
        const ema_real speed_mm_s =
            ema_choose(carried, lanes->constant.lead_mm_per_rad[l] * now->speed_rad_s[l], EMA_R(0.0));
        row->speed_mm_s[l] = ema_choose(transmits, now->rod_speed_mm_s[l], speed_mm_s);
        row->position_mm[l] = ema_encoder_rod(&encoder, now->rod_mm[l]);
        row->motor_position_mm[l] = now->motor_mm[l];
    }
    /* how far outside its table a lane has been is not told: what ema_site_seen watches is left out */
    if (ema_acts(&lanes->plant[0], EMA_SITE_READING)) {
        for (uint32_t l = 0; l < EMA_LANES; ++l) {
            const ema_site_t here = {.plant = &lanes->plant[l],
                                     .speed_rad_s = now->speed_rad_s[l],
                                     .angle_rad = now->angle_rad[l],
                                     .position_mm = now->rod_mm[l],
                                     .current_A = now->current_A[l]};
            row->position_mm[l] += ema_site_reading(&lanes->plant[l], &here);
        }
    }
}

/* What the position loop sees: ema_encoder_step. */
static const ema_real* ema_lanes_feedback(ema_lanes_t* lanes)
{
    const ema_encoder_t* const shape = &lanes->plant[0].encoder;
    const ema_real* const position_mm = shape->at_rod ? lanes->row->position_mm : lanes->row->motor_position_mm;
    for (uint32_t l = 0; !shape->plain && (l < EMA_LANES); ++l) {
        lanes->state[l].step = lanes->step;
        lanes->feedback_mm[l] = ema_encoder_general(&lanes->plant[l].encoder, &lanes->state[l], position_mm[l]);
    }
    return shape->plain ? position_mm : lanes->feedback_mm;
}

static inline void ema_lane_applied(ema_lanes_t* lanes, uint32_t l, const ema_drive_output_t* applied)
{
    lanes->applied.input[l] = applied->input;
    lanes->applied.voltage_V[l] = applied->voltage_V;
    lanes->applied.current_loop[l] = applied->current_loop ? EMA_R(1.0) : EMA_R(0.0);
    lanes->row->voltage_V[l] = applied->voltage_V;
}

/* ema_pid_step and ema_drive_step in their plain forms: proportional and integral action, a share of the bus voltage.
 */
static void ema_lanes_control_plain(ema_lanes_t* lanes, ema_real command_mm, const ema_real* feedback_mm)
{
    ema_lanes_state_t* const now = &lanes->now;
    EMA_EACH_LANE
    {
        const ema_pid_t pid = {.plain = true,
                               .every_steps = 1U,
                               .period_s = lanes->constant.period_s[l],
                               .gain = lanes->constant.gain[l],
                               .integral_gain = lanes->constant.integral_gain[l],
                               .anti_windup_per_s = lanes->constant.anti_windup_per_s[l],
                               .output_limit = lanes->constant.output_limit[l]};
        const ema_drive_t drive = {.supply_V = lanes->constant.supply_V[l]};
        const ema_motor_t motor = {0};
        ema_state_t state;
        ema_drive_output_t applied;
        state.integral = now->integral[l];
        now->output[l] = ema_pid_step(&pid, &state, command_mm, feedback_mm[l]);
        now->integral[l] = state.integral;
        ema_drive_step(&drive, &motor, now->output[l], EMA_R(0.0), EMA_R(0.0), &applied);
        ema_lane_applied(lanes, l, &applied);
    }
}

/* The same in all their forms. */
static void ema_lanes_control_general(ema_lanes_t* lanes, ema_real command_mm, const ema_real* feedback_mm)
{
    ema_lanes_state_t* const now = &lanes->now;
    for (uint32_t l = 0; l < EMA_LANES; ++l) {
        ema_state_t* const state = &lanes->state[l];
        ema_drive_output_t applied;
        state->step = lanes->step;
        state->integral = now->integral[l];
        state->output = now->output[l];
        now->output[l] = ema_pid_step(&lanes->plant[l].pid, state, command_mm, feedback_mm[l]);
        now->integral[l] = state->integral;
        ema_drive_step(&lanes->plant[l].drive, &lanes->plant[l].motor, now->output[l], now->current_A[l],
                       now->speed_rad_s[l], &applied);
        ema_lane_applied(lanes, l, &applied);
    }
}

/* ema_drive_current */
static void ema_lanes_follow(ema_lanes_t* lanes)
{
    const ema_plant_t* const shape = &lanes->plant[0];
    if (shape->motor_circuit.algebraic || (shape->drive.current_mode && shape->current_loop.algebraic)) {
        for (uint32_t l = 0; l < EMA_LANES; ++l) {
            ema_state_t* const state = &lanes->state[l];
            const ema_drive_output_t applied = {lanes->applied.input[l], lanes->applied.voltage_V[l],
                                                lanes->applied.current_loop[l] != EMA_R(0.0)};
            state->current_A = lanes->now.current_A[l];
            state->speed_rad_s = lanes->now.speed_rad_s[l];
            ema_drive_current(&lanes->plant[l], state, &applied);
            lanes->now.current_A[l] = state->current_A;
        }
    }
}

/* What was asked for earlier: ema_delayed_output. */
static void ema_lanes_late(ema_lanes_t* lanes)
{
    for (uint32_t l = 0; l < EMA_LANES; ++l) {
        const ema_real voltage_V = lanes->row->voltage_V[l];
        lanes->state[l].step = lanes->step;
        lanes->state[l].current_A = lanes->now.current_A[l];
        lanes->state[l].speed_rad_s = lanes->now.speed_rad_s[l];
        ema_delayed_output(&lanes->plant[l], &lanes->state[l], &lanes->work, lanes->now.output[l]);
        ema_lane_applied(lanes, l, &lanes->work.applied);
        lanes->row->voltage_V[l] = voltage_V;
    }
}

/* ema_delayed_step */
static void ema_lanes_late_motion(ema_lanes_t* lanes)
{
    const ema_lanes_plant_t* const constant = &lanes->constant;
    ema_lane_t first_s;
    ema_lane_t rest_s;
    EMA_EACH_LANE
    {
        first_s[l] = lanes->plant[l].drive.delay_part * constant->step_s[l];
        rest_s[l] = constant->step_s[l] - first_s[l];
    }
    if (lanes->plant[0].drive.delay_part > EMA_R(0.0)) {
        ema_lanes_motion_span(lanes, 0U, first_s);
        for (uint32_t l = 0; l < EMA_LANES; ++l) {
            ema_drive_output_t applied;
            lanes->state[l].step = lanes->step;
            lanes->state[l].current_A = lanes->now.current_A[l];
            lanes->state[l].speed_rad_s = lanes->now.speed_rad_s[l];
            ema_drive_late(&lanes->plant[l], &lanes->state[l], lanes->plant[l].drive.delay_steps, &applied);
            lanes->applied.input[l] = applied.input;
            lanes->applied.voltage_V[l] = applied.voltage_V;
            lanes->applied.current_loop[l] = applied.current_loop ? EMA_R(1.0) : EMA_R(0.0);
        }
        ema_lanes_follow(lanes);
    }
    ema_lanes_motion_span(lanes, 1U, rest_s);
}

/* ema_motion_arrive */
static void ema_lanes_arrive(ema_lanes_t* lanes)
{
    const ema_lanes_plant_t* const constant = &lanes->constant;
    ema_lanes_state_t* const now = &lanes->now;
    const ema_real transmits = ema_flag(ema_acts(&lanes->plant[0], EMA_SITE_TRANSMISSION));
    EMA_EACH_LANE
    {
        const ema_real motor_mm =
            (constant->lead_mm_per_rad[l] * now->angle_rad[l]) + (constant->lead_mm_per_rad[l] * now->angle_low_rad[l]);
        ema_real play_mm;
        ema_real side;
        ema_lane_play(lanes, l, motor_mm, &play_mm, &side);
        now->motor_mm[l] = motor_mm;
        now->play_side[l] = side;
        now->play_mm[l] = play_mm;
        now->rod_mm[l] = ema_choose(transmits, now->rod_mm[l], play_mm);
    }
}

bool ema_lanes_finite(const ema_lanes_t* lanes, uint32_t lane)
{
    const ema_lanes_state_t* const now = &lanes->now;
    return ema_is_finite(now->current_A[lane]) && ema_is_finite(now->speed_rad_s[lane])
           && ema_is_finite(now->motor_mm[lane]) && ema_is_finite(now->rod_mm[lane])
           && ema_is_finite(now->integral[lane]);
}

bool ema_lanes_step(ema_lanes_t* lanes, ema_real command_mm)
{
    const ema_plant_t* const shape = &lanes->plant[0];
    const ema_lanes_state_t* const now = &lanes->now;
    ema_lanes_read(lanes);
    const ema_real* const feedback_mm = ema_lanes_feedback(lanes);
    if (shape->pid.plain && (shape->pid.every_steps == 1U) && !shape->drive.current_mode) {
        ema_lanes_control_plain(lanes, command_mm, feedback_mm);
    } else {
        ema_lanes_control_general(lanes, command_mm, feedback_mm);
    }
    if (shape->drive.delayed) {
        ema_lanes_late(lanes);
    }
    ema_lanes_follow(lanes);
    EMA_EACH_LANE
    {
        lanes->row->current_A[l] = now->current_A[l];
    }
    if (shape->drive.delayed) {
        ema_lanes_late_motion(lanes);
    } else if (ema_acts_on_motion(shape)) {
        ema_lanes_motion_span(lanes, 1U, lanes->constant.step_s);
    } else {
        ema_lanes_motion_plain(lanes);
    }
    if (ema_acts_by_warmth(shape)) {
        ema_lanes_warm(lanes, lanes->row->current_A);
    }
    ema_lanes_arrive(lanes);
    ++lanes->step;
    ema_lane_bit_t lost = 0;
    EMA_EACH_LANE
    {
        /* zeros, unless one of them is none */
        const ema_real zero = (now->current_A[l] - now->current_A[l]) + (now->speed_rad_s[l] - now->speed_rad_s[l])
                              + (now->motor_mm[l] - now->motor_mm[l]) + (now->rod_mm[l] - now->rod_mm[l])
                              + (now->integral[l] - now->integral[l]);
        lost |= (zero == EMA_R(0.0)) ? 0 : 1;
    }
    return lost == 0;
}
