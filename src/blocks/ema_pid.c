#include "blocks/ema_pid.h"

#include "blocks/ema_limits.h"

void ema_pid_prepare(ema_pid_t* pid, const ema_params_t* params, const ema_options_t* options)
{
    pid->every_steps = (uint32_t)options->every_steps;
    pid->period_s = params->step_s * (ema_real)pid->every_steps;
    pid->anti_windup_per_s = params->anti_windup_per_s;
    pid->output_limit = params->output_limit;
#if EMA_ONLY_PI
    pid->cascade = false;
    pid->plain = true;
    pid->gain = params->kp_per_m;
    pid->integral_gain = params->ki_per_m_s;
#else
    pid->speed_limit_m_s = ema_limit_or_none(params->speed_limit_m_s);
    pid->cascade = options->structure == 1;
    pid->gain = pid->cascade ? params->speed_gain_s_per_m : params->kp_per_m;
    pid->integral_gain = pid->cascade ? params->speed_integral_per_m : params->ki_per_m_s;
    pid->outer_gain = pid->cascade ? params->position_gain_per_s : params->kd_s_per_m;
    pid->derivative_on_speed = options->derivative == 1;
    pid->average_speed = options->average_speed == 1;
    pid->plain = !pid->cascade && !(params->kd_s_per_m > EMA_R(0.0));
#endif
}

ema_real ema_pid_general(const ema_pid_t* pid, ema_state_t* state, ema_real error_m, ema_real feedback_mm)
{
    const bool first = state->step == 0U;
    const ema_real rate_hz = EMA_R(1.0) / pid->period_s;
    const ema_real previous_mm = first ? feedback_mm : state->previous_feedback_mm;
    const ema_real measure_mm = pid->average_speed ? (EMA_R(0.5) * (feedback_mm + previous_mm)) : feedback_mm;
    const ema_real previous_measure_mm = first ? measure_mm : state->previous_measure_mm;
    const ema_real previous_error_m = first ? error_m : state->previous_error_m;
    const ema_real speed_m_s = (measure_mm - previous_measure_mm) * EMA_R(1.0e-3) * rate_hz;
    state->previous_feedback_mm = feedback_mm;
    state->previous_measure_mm = measure_mm;
    state->previous_error_m = error_m;

    ema_real controlled = error_m;
    ema_real raw = state->integral;
    if (pid->cascade) {
        controlled = ema_clamp(pid->outer_gain * error_m, -pid->speed_limit_m_s, pid->speed_limit_m_s) - speed_m_s;
        raw += pid->gain * controlled;
    } else {
        const ema_real derivative_m_s =
            pid->derivative_on_speed ? -speed_m_s : ((error_m - previous_error_m) * rate_hz);
        raw += pid->gain * error_m;
        raw += pid->outer_gain * derivative_m_s;
    }
    const ema_real output = ema_clamp(raw, -pid->output_limit, pid->output_limit);
    state->integral += pid->period_s * ((pid->integral_gain * controlled) + (pid->anti_windup_per_s * (output - raw)));
    return output;
}
