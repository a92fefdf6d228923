"""Block 1, PID control logic: position to normalised output, with anti-windup, once per control period.

Equations: docs/DESIGN.md, "1. PID control logic".
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ema_tools.base.compiled import compiled


class PidState(NamedTuple):
    """What the control law keeps: integrator and output in output units, the rest in metres."""

    integral: float
    previous_error_m: float
    previous_feedback_m: float
    previous_measure_m: float
    output: float
    has_run: bool


@compiled
def _clamp(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))


@compiled
def at_rest() -> PidState:
    """State before the first run."""
    return PidState(0.0, 0.0, 0.0, 0.0, 0.0, False)


@compiled
def run(control: Any, period_s: float, command_m: float, feedback_m: float, state: PidState) -> PidState:
    """One run of the control law; the new output is in the returned state."""
    error = command_m - feedback_m
    measure = feedback_m
    if control.average_speed == 1 and state.has_run:
        measure = 0.5 * (feedback_m + state.previous_feedback_m)
    previous_error = state.previous_error_m
    previous_measure = state.previous_measure_m
    if not state.has_run:
        previous_error = error
        previous_measure = measure
    measured_speed = (measure - previous_measure) / period_s

    if control.structure == 1:
        speed_reference = control.position_gain_per_s * error
        if control.speed_limit_m_s > 0.0:
            speed_reference = _clamp(speed_reference, control.speed_limit_m_s)
        speed_error = speed_reference - measured_speed
        raw = control.speed_gain_s_per_m * speed_error + state.integral
        growth = control.speed_integral_per_m * speed_error
    else:
        derivative = (error - previous_error) / period_s
        if control.derivative == 1:
            derivative = -measured_speed
        raw = control.kp_per_m * error + state.integral + control.kd_s_per_m * derivative
        growth = control.ki_per_m_s * error
    output = _clamp(raw, control.output_limit)
    integral = state.integral + period_s * (growth + control.anti_windup_per_s * (output - raw))
    return PidState(integral, error, feedback_m, measure, output, True)
