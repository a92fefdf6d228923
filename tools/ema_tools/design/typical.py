"""Sizes at which effects are met: the lower end of what is usual on such actuators, for questions that are asked before anything was fitted."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ema_tools.data.actuator import Actuator, reference_actuator, row_of
from ema_tools.library.definitions import load_definitions
from ema_tools.library.faults import FAULT_RECORDS, FAULTS
from ema_tools.library.registry import record_of

# A size in one of these units grows with the machine: by the first letters of its unit, the value that says how large the machine is.
_GROWS_WITH: Mapping[str, str] = {"Nm": "screw.csj_Nm", "V": "drive.supply_V", "ohm": "motor.resistance_ohm"}


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
    if effect in FAULT_RECORDS:
        return {name: present * (1.0 + FAULT_RECORDS[effect].typical_share)}
    record = record_of(effect)
    if record.below_peak is not None:
        return {name: record.below_peak.typical * peak_current_A}
    if record.typical is None:
        return None
    values = {f"effects.{effect}.{field}": value for field, value in record.typical.values.items()}
    values[name] = present + values[name] * _scale(actuator, name)
    if effect in actuator.active_effects:
        # its shape is known already
        return {name: values[name]}
    return values


def scaled(actuator: Actuator, effect: str, values: Mapping[str, float], factor: float) -> dict[str, float]:
    """The same effect, its distance from what the actuator has of it `factor` times as large, inside its range. A limit goes further below the peak."""
    name, present = zero_of(actuator, effect)
    row, limit = row_of(name), record_of(effect).below_peak
    moved = (
        values[name] * (1.0 - (1.0 - limit.typical) * (factor - 1.0)) if limit is not None else present + factor * (values[name] - present)
    )
    return {**values, name: float(np.clip(moved, row.lower, row.upper))}
