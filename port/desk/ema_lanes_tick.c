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
    ema_lanes_output_t* const row = &lanes->row;
    const ema_lanes_state_t* const now = &lanes->now;
    const bool transmits = ema_acts(&lanes->plant[0], EMA_SITE_TRANSMISSION);
    EMA_EACH_LANE
    {
        const ema_encoder_t encoder = {.rod_gain = lanes->constant.rod_gain[l],
                                       .rod_offset_mm = lanes->constant.rod_offset_mm[l]};
        const bool carried = (now->play_side[l] * now->speed_rad_s[l]) > EMA_R(0.0);
        const ema_real rod_mm_s = lanes->constant.lead_mm_per_rad[l] * now->speed_rad_s[l];
        const ema_real speed_mm_s = carried ? rod_mm_s : EMA_R(0.0);
        row->speed_mm_s[l] = transmits ? now->rod_speed_mm_s[l] : speed_mm_s;
        row->position_mm[l] = ema_encoder_rod(&encoder, now->rod_mm[l]);
        row->motor_position_mm[l] = now->motor_mm[l];
    }
    if (ema_acts_on_reading(&lanes->plant[0])) {
        for (uint32_t l = 0; l < EMA_LANES; ++l) {
            ema_lanes_leave(lanes, l, &lanes->state[l]);
            row->position_mm[l] += ema_site_seen(&lanes->plant[l], &lanes->state[l]);
        }
    }
}

/* What the position loop sees: ema_encoder_step. */
static void ema_lanes_feedback(ema_lanes_t* lanes, ema_lane_t feedback_mm)
{
    const ema_encoder_t* const shape = &lanes->plant[0].encoder;
    EMA_EACH_LANE
    {
        feedback_mm[l] = shape->at_rod ? lanes->row.position_mm[l] : lanes->now.motor_mm[l];
    }
    if (!shape->plain) {
        for (uint32_t l = 0; l < EMA_LANES; ++l) {
            lanes->state[l].step = lanes->step;
            feedback_mm[l] = ema_encoder_general(&lanes->plant[l].encoder, &lanes->state[l], feedback_mm[l]);
        }
    }
}

/* ema_pid_step */
static void ema_lanes_control(ema_lanes_t* lanes, ema_real command_mm, const ema_lane_t feedback_mm)
{
    const ema_pid_t* const shape = &lanes->plant[0].pid;
    ema_lanes_state_t* const now = &lanes->now;
    if (!shape->plain) {
        for (uint32_t l = 0; l < EMA_LANES; ++l) {
            ema_state_t* const state = &lanes->state[l];
            state->step = lanes->step;
            state->integral = now->integral[l];
            state->output = now->output[l];
            now->output[l] = ema_pid_step(&lanes->plant[l].pid, state, command_mm, feedback_mm[l]);
            now->integral[l] = state->integral;
        }
    } else if ((lanes->step % shape->every_steps) == 0U) {
        EMA_EACH_LANE
        {
            const ema_pid_t pid = {.plain = true,
                                   .every_steps = 1U,
                                   .period_s = lanes->constant.period_s[l],
                                   .kp_per_m = lanes->constant.kp_per_m[l],
                                   .ki_per_m_s = lanes->constant.ki_per_m_s[l],
                                   .anti_windup_per_s = lanes->constant.anti_windup_per_s[l],
                                   .output_limit = lanes->constant.output_limit[l]};
            ema_state_t state;
            state.integral = now->integral[l];
            now->output[l] = ema_pid_step(&pid, &state, command_mm, feedback_mm[l]);
            now->integral[l] = state.integral;
        }
    } else {
        /* held between control instants */
    }
}

static void ema_lanes_applied(ema_lanes_t* lanes, uint32_t lane, const ema_drive_output_t* applied)
{
    lanes->applied.input[lane] = applied->input;
    lanes->applied.voltage_V[lane] = applied->voltage_V;
    lanes->applied.current_loop[lane] = applied->current_loop ? EMA_R(1.0) : EMA_R(0.0);
}

/* ema_drive_step */
static void ema_lanes_drive(ema_lanes_t* lanes)
{
    if (lanes->plant[0].drive.current_mode) {
        for (uint32_t l = 0; l < EMA_LANES; ++l) {
            ema_drive_output_t applied;
            ema_drive_step(&lanes->plant[l].drive, &lanes->plant[l].motor, lanes->now.output[l],
                           lanes->now.current_A[l], lanes->now.speed_rad_s[l], &applied);
            ema_lanes_applied(lanes, l, &applied);
        }
    } else {
        EMA_EACH_LANE
        {
            const ema_drive_t drive = {.supply_V = lanes->constant.supply_V[l]};
            const ema_motor_t motor = {0};
            ema_drive_output_t applied;
            ema_drive_step(&drive, &motor, lanes->now.output[l], EMA_R(0.0), EMA_R(0.0), &applied);
            lanes->applied.input[l] = applied.input;
            lanes->applied.voltage_V[l] = applied.voltage_V;
            lanes->applied.current_loop[l] = EMA_R(0.0);
        }
    }
}

/* ema_drive_current */
static void ema_lanes_follow(ema_lanes_t* lanes)
{
    const ema_plant_t* const shape = &lanes->plant[0];
    if (shape->motor_circuit.algebraic || shape->current_loop.algebraic) {
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
        ema_lanes_leave(lanes, l, &lanes->state[l]);
        ema_delayed_output(&lanes->plant[l], &lanes->state[l], &lanes->work, lanes->now.output[l]);
        ema_lanes_applied(lanes, l, &lanes->work.applied);
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
            ema_lanes_leave(lanes, l, &lanes->state[l]);
            ema_drive_late(&lanes->plant[l], &lanes->state[l], lanes->plant[l].drive.delay_steps, &applied);
            ema_lanes_applied(lanes, l, &applied);
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
    const bool transmits = ema_acts(&lanes->plant[0], EMA_SITE_TRANSMISSION);
    EMA_EACH_LANE
    {
        const ema_real half_mm = constant->half_play_mm[l];
        const ema_real motor_mm =
            (constant->lead_mm_per_rad[l] * now->angle_rad[l]) + (constant->lead_mm_per_rad[l] * now->angle_low_rad[l]);
        const ema_real play_mm = now->play_mm[l];
        const ema_real gap_mm = motor_mm - play_mm;
        const bool ahead = gap_mm > half_mm;
        const bool behind = gap_mm < -half_mm;
        const ema_real pushed_mm = motor_mm - half_mm;
        const ema_real pulled_mm = motor_mm + half_mm;
        const ema_real side = behind ? EMA_R(-1.0) : EMA_R(0.0);
        const ema_real kept_mm = behind ? pulled_mm : play_mm;
        now->motor_mm[l] = motor_mm;
        now->play_side[l] = ahead ? EMA_R(1.0) : side;
        now->play_mm[l] = ahead ? pushed_mm : kept_mm;
        now->rod_mm[l] = transmits ? now->rod_mm[l] : now->play_mm[l];
    }
}

void ema_lanes_step(ema_lanes_t* lanes, ema_real command_mm, ema_lane_t finite)
{
    const ema_plant_t* const shape = &lanes->plant[0];
    const ema_lanes_state_t* const now = &lanes->now;
    ema_lane_t feedback_mm;
    ema_lanes_read(lanes);
    ema_lanes_feedback(lanes, feedback_mm);
    ema_lanes_control(lanes, command_mm, feedback_mm);
    ema_lanes_drive(lanes);
    EMA_EACH_LANE
    {
        lanes->row.voltage_V[l] = lanes->applied.voltage_V[l];
    }
    if (shape->drive.delayed) {
        ema_lanes_late(lanes);
    }
    ema_lanes_follow(lanes);
    EMA_EACH_LANE
    {
        lanes->row.current_A[l] = now->current_A[l];
    }
    if (shape->drive.delayed) {
        ema_lanes_late_motion(lanes);
    } else if (ema_acts_on_motion(shape)) {
        ema_lanes_motion_span(lanes, 1U, lanes->constant.step_s);
    } else {
        ema_lanes_motion_plain(lanes);
    }
    ema_lanes_arrive(lanes);
    ++lanes->step;
    EMA_EACH_LANE
    {
        const bool moves = ema_is_finite(now->current_A[l]) && ema_is_finite(now->speed_rad_s[l]);
        const bool lies = ema_is_finite(now->motor_mm[l]) && ema_is_finite(now->rod_mm[l]);
        finite[l] = (moves && lies && ema_is_finite(now->integral[l])) ? EMA_R(1.0) : EMA_R(0.0);
    }
}
