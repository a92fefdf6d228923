"""Block 2, controller and drive electronics: normalised output to what the motor gets over one model step.

Equations: docs/DESIGN.md, "2. Controller and drive electronics".
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ema_tools.base.compiled import compiled

MOTOR_LAW = 0  # the voltage is given, the winding's own equation holds
LOOP_LAW = 1  # the current follows its reference with the loop's time constant
IDEAL_LAW = 2  # the current is its reference


class Supply(NamedTuple):
    """What is held over a model step."""

    law: int
    voltage_V: float
    reference_A: float
    recorded_V: float


@compiled
def supply(drive: Any, motor: Any, output: float, current_A: float, speed_rad_s: float) -> Supply:
    """The drive's decision at the start of a step from the held output and the state of the motor."""
    if drive.mode == 0:
        voltage = output * drive.supply_V
        return Supply(MOTOR_LAW, voltage, 0.0, voltage)

    reference = output * drive.current_scale_A
    back_emf = motor.back_emf_V_s_per_rad * speed_rad_s
    law = LOOP_LAW
    if drive.current_loop_s == 0.0:
        law = IDEAL_LAW
        voltage = motor.resistance_ohm * limited(drive, reference) + back_emf
    else:
        rise = (reference - current_A) / drive.current_loop_s
        voltage = motor.resistance_ohm * current_A + motor.inductance_H * rise + back_emf
        if abs(voltage) > drive.supply_V:
            law = MOTOR_LAW
            voltage = drive.supply_V if voltage > 0.0 else -drive.supply_V
    recorded = output * drive.command_scale_V if drive.command_scale_V > 0.0 else voltage
    return Supply(law, voltage, reference, recorded)


@compiled
def delayed(outputs: np.ndarray, step: int) -> float:
    """Output of the control law at `step`; zero before the first."""
    return outputs[step] if step >= 0 else 0.0


@compiled
def limited(drive: Any, current_A: float) -> float:
    """`current_A` inside the drive's limits."""
    if drive.current_limit_A > 0.0:
        return max(-drive.current_limit_A, min(drive.current_limit_A, current_A))
    return current_A
