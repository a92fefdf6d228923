"""Every effect that the truth plant can hide: one small function each, and one sum per place where they act.

`v` is the record of all values by name, see `ema_tools.truth.plant`. An effect at its zero contributes nothing. To add
one: write its function under the name in `ema_effects.def` and add it to the sum of its place.
"""

from __future__ import annotations

import math
from typing import Any

from ema_tools.reference.compiled import compiled


@compiled
def stribeck_friction(v: Any, w: float) -> float:
    """Share of the level of dry friction by which it exceeds the level at high speed."""
    rise = v["stribeck_friction.rise"]
    if rise == 0.0:
        return 0.0
    return rise * math.exp(-((abs(w) / v["stribeck_friction.speed_rad_s"]) ** v["stribeck_friction.shape"]))


@compiled
def cogging_torque(v: Any, theta: float) -> float:
    """Torque on the shaft, Nm."""
    amplitude = v["cogging_torque.amplitude_Nm"]
    if amplitude == 0.0:
        return 0.0
    return amplitude * math.sin(v["cogging_torque.periods"] * theta + v["cogging_torque.phase_rad"])


@compiled
def constant_load(v: Any) -> float:
    """Torque against extension, Nm."""
    return v["constant_load.torque_Nm"]


@compiled
def spring_load(v: Any, x_mm: float) -> float:
    """Torque against extension, Nm."""
    return v["spring_load.stiffness_Nm_per_mm"] * x_mm


@compiled
def winding_heating(v: Any) -> float:
    """Resistance over the cold one."""
    return 1.0 + 0.00393 * v["winding_heating.rise_degC"]


@compiled
def inverter_dead_time(v: Any, i: float) -> float:
    """Change of the motor voltage, V."""
    drop = v["inverter_dead_time.drop_V"]
    if drop == 0.0:
        return 0.0
    return -drop * i / math.hypot(i, v["inverter_dead_time.width_A"])


@compiled
def feedback_delay(v: Any) -> float:
    """Added age of the feedback, s."""
    return v["feedback_delay.delay_s"]


@compiled
def transmission_compliance(v: Any, gap_mm: float, gap_mm_s: float) -> float:
    """Force on the rod's mass in N for a spring compressed by `gap_mm` at `gap_mm_s`; 0 when the transmission is rigid."""
    period = v["transmission_compliance.period_s"]
    if period == 0.0:
        return 0.0
    mass = v["transmission_compliance.mass_kg"]
    pulsation = 2.0 * math.pi / period
    pull = pulsation * pulsation * gap_mm + 2.0 * v["transmission_compliance.damping_ratio"] * pulsation * gap_mm_s
    return 1e-3 * mass * pull


@compiled
def rod_mass_kg(v: Any) -> float:
    """Mass behind the spring; 0 when the transmission is rigid."""
    if v["transmission_compliance.period_s"] == 0.0:
        return 0.0
    return v["transmission_compliance.mass_kg"]


@compiled
def friction_factor(v: Any, w: float) -> float:
    """Level of dry friction at speed `w` over the level without effects."""
    return 1.0 + stribeck_friction(v, w)


@compiled
def shaft_torque_Nm(v: Any, theta: float) -> float:
    """All torques on the shaft."""
    return cogging_torque(v, theta)


@compiled
def load_Nm(v: Any, x_mm: float) -> float:
    """All torques against extension."""
    return v["screw.load_torque_Nm"] + constant_load(v) + spring_load(v, x_mm)


@compiled
def resistance_ohm(v: Any) -> float:
    """Winding resistance."""
    return v["motor.resistance_ohm"] * winding_heating(v)


@compiled
def lost_voltage_V(v: Any, i: float) -> float:
    """All changes of the motor voltage."""
    return inverter_dead_time(v, i)


@compiled
def feedback_age_s(v: Any) -> float:
    """Age of the feedback."""
    return v["encoder.delay_s"] + feedback_delay(v)
