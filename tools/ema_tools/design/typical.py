"""Sizes at which effects are met: the lower end of what is usual on such actuators, for questions that are asked before anything was fitted."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from ema_tools.data.actuator import Actuator, reference_actuator, row_of
from ema_tools.library.definitions import load_definitions
from ema_tools.library.faults import FAULTS

# On the reference actuator; the first value is the size. Sources: the effects' own in `ema effects`; estimates where a usual range begins at zero.
_LOWER_END: Mapping[str, Mapping[str, float]] = {
    "stribeck_friction": {"rise": 0.1, "speed_rad_s": 5.0},
    "presliding": {"stretch_rad": 0.02},
    "coulomb_asymmetry": {"asymmetry": 0.01},
    "constant_load": {"torque_Nm": 0.005},
    "viscous_asymmetry": {"asymmetry": 0.05},
    "load_dependent_friction": {"ratio": 0.02},
    "pitch_ripple": {"ratio": 0.03, "phase_rad": 0.7},
    "cogging_torque": {"amplitude_Nm": 0.0148, "periods": 12.0, "phase_rad": 0.7},
    "torque_ripple": {"ratio": 0.02, "periods": 6.0, "phase_rad": 0.5},
    "transmission_compliance": {"period_s": 0.02, "mass_kg": 2.0},
    "winding_heating": {"rise_degC": 30.0},
    "magnet_weakening": {"loss": 0.02},
    "inverter_dead_time": {"drop_V": 0.1},
    "supply_sag": {"sag": 0.02},
    "source_resistance": {"resistance_ohm": 0.05},
    "sensor_gain": {"error": 0.001},
    "sensor_offset": {"offset_mm": 0.01},
    "feedback_delay": {"delay_s": 2e-4},
    "actuation_delay": {"delay_s": 1e-4},
    "spring_load": {"stiffness_Nm_per_mm": 0.004},
    "viscous_rise": {"rise": 0.5},
    "concave_viscous": {"drag_Nm_per_sqrt_rad_s": 0.001},
    "quadratic_viscous": {"drag_Nm_s2_per_rad2": 1e-7},
    "jam_spot": {"amplitude_Nm": 0.02, "place_mm": 0.5, "width_mm": 0.1},
    "inertia_change": {"change": 0.05},
    "gain_drift": {"drift": 0.02},
}
# Changes of the fault parameters, relative.
_FAULT_SHARE: Mapping[str, float] = MappingProxyType({"csj": 0.05, "blk": 0.25})
# A size in one of these units grows with the machine: by the first letters of its unit, the value that says how large the machine is.
_GROWS_WITH: Mapping[str, str] = {"Nm": "screw.csj_Nm", "V": "drive.supply_V", "ohm": "motor.resistance_ohm"}
# A limit is felt only below the peak of the current.
_LIMIT_SHARE = 0.95


def _scale(actuator: Actuator, name: str) -> float:
    unit = row_of(name).unit
    for start, value in _GROWS_WITH.items():
        if unit.startswith(start) and actuator[value] > 0.0:
            return actuator[value] / reference_actuator()[value]
    return 1.0


def zero_of(actuator: Actuator, effect: str) -> tuple[str, float]:
    """The value that is the size of an effect or fault parameter, and where it lies in the actuator as it is."""
    if effect in FAULTS:
        return FAULTS[effect], actuator[FAULTS[effect]]
    size = load_definitions().effect(effect).size
    return f"effects.{size.name}", actuator[size.name]


def typical_change(actuator: Actuator, effect: str, peak_current_A: float) -> dict[str, float] | None:
    """The values of an effect (or fault parameter) at the lower end of its usual size, on top of what the actuator has of it; None where none is known."""
    name, present = zero_of(actuator, effect)
    if effect in FAULTS:
        return {name: present * (1.0 + _FAULT_SHARE[effect])}
    if effect == "current_limit":
        return {name: _LIMIT_SHARE * peak_current_A}
    if effect not in _LOWER_END:
        return None
    values = {f"effects.{effect}.{field}": value for field, value in _LOWER_END[effect].items()}
    values[name] = present + values[name] * _scale(actuator, name)
    if effect in actuator.active_effects:
        # its shape is known already
        return {name: values[name]}
    return values


def scaled(actuator: Actuator, effect: str, values: Mapping[str, float], factor: float) -> dict[str, float]:
    """The same effect, its distance from what the actuator has of it `factor` times as large, inside its range. A limit goes further below the peak."""
    name, present = zero_of(actuator, effect)
    row = row_of(name)
    moved = (
        values[name] * (1.0 - (1.0 - _LIMIT_SHARE) * (factor - 1.0))
        if effect == "current_limit"
        else present + factor * (values[name] - present)
    )
    return {**values, name: float(np.clip(moved, row.lower, row.upper))}
