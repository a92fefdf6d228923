"""Effects that the library does not hold: what a machine may have and no row of the list describes. A search must call them unknown.

As in `effects`, `v` is the record of all values by name, and an effect at its zero contributes nothing. `DEFAULTS` lists every value; the first of each effect is its size.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from benchmarks.truth.kept import kept_compiled

DEFAULTS: Mapping[str, Mapping[str, float]] = {
    "broken_ball": {"friction_Nm": 0.0, "per_turn": 3.3, "sharpness": 20.0, "phase_rad": 0.0},
    "encoder_eccentricity": {"error_rad": 0.0, "phase_rad": 0.0},
    "lead_error": {"amplitude_mm": 0.0, "phase_rad": 0.0},
    "bus_hum": {"ratio": 0.0, "frequency_hz": 100.0, "phase_rad": 0.0},
    "speed_hump": {"drag_Nm": 0.0, "speed_rad_s": 70.0, "width_rad_s": 15.0},
    "command_dead_band": {"width_mm": 0.0},
    "magnetic_lag": {"lag_A": 0.0, "swing_A": 1.0},
    "integrator_leak": {"rate_per_s": 0.0},
}


@kept_compiled
def broken_ball(v: Any, theta: float) -> float:
    """Dry friction on top, Nm: a bump whenever the damaged ball passes the return, at a pitch that belongs neither to the screw nor to the motor."""
    friction = v["broken_ball.friction_Nm"]
    if friction == 0.0:
        return 0.0
    turned = v["broken_ball.per_turn"] * theta / v["gearbox.ratio"] + v["broken_ball.phase_rad"]
    return friction * math.exp(v["broken_ball.sharpness"] * (math.cos(turned) - 1.0))


@kept_compiled
def encoder_eccentricity(v: Any, theta: float) -> float:
    """What the motor encoder reads on top, rad: its disc runs out of true, one period per motor turn."""
    error = v["encoder_eccentricity.error_rad"]
    if error == 0.0:
        return 0.0
    return error * math.sin(theta + v["encoder_eccentricity.phase_rad"])


@kept_compiled
def lead_error(v: Any, rod_mm: float) -> float:
    """Where the rod stands beside the place that the angle says, mm: the thread wobbles once per turn of the screw."""
    amplitude = v["lead_error.amplitude_mm"]
    if amplitude == 0.0:
        return 0.0
    return amplitude * math.sin(2.0 * math.pi * rod_mm / v["screw.lead_mm"] + v["lead_error.phase_rad"])


@kept_compiled
def bus_hum(v: Any, time_s: float) -> float:
    """Bus voltage over its mean: ripple of a rectifier."""
    ratio = v["bus_hum.ratio"]
    if ratio == 0.0:
        return 1.0
    return 1.0 + ratio * math.sin(2.0 * math.pi * v["bus_hum.frequency_hz"] * time_s + v["bus_hum.phase_rad"])


@kept_compiled
def speed_hump(v: Any, w: float) -> float:
    """Drag on the shaft, Nm, around one speed: a resonance of the gears takes power there, so drag falls with speed above it."""
    drag = v["speed_hump.drag_Nm"]
    if drag == 0.0:
        return 0.0
    z = (abs(w) - v["speed_hump.speed_rad_s"]) / v["speed_hump.width_rad_s"]
    return math.copysign(drag * math.exp(-z * z), w)


@kept_compiled
def command_dead_band(v: Any, error: float) -> float:
    """Control error that the controller acts on, m: it ignores what is smaller than half the width."""
    half = 0.5e-3 * v["command_dead_band.width_mm"]
    return error - min(max(error, -half), half)


@kept_compiled
def magnetic_lag(v: Any, lag: float) -> float:
    """Current that makes no torque, A: the iron's magnetisation lags by `lag` (-1 .. 1) behind the current."""
    return v["magnetic_lag.lag_A"] * lag


@kept_compiled
def lag_after(v: Any, lag: float, change_A: float) -> float:
    """The lag after a change of current: it follows the direction of change within the swing."""
    turned = change_A / v["magnetic_lag.swing_A"]
    return (lag + turned) / (1.0 + abs(turned))


@kept_compiled
def integrator_leak(v: Any, integral: float) -> float:
    """Rate at which the controller's integral is lost, 1/s times the integral."""
    return v["integrator_leak.rate_per_s"] * integral
