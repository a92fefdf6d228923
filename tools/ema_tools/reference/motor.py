"""Block 3, motor: voltage to current to torque.

Equations: docs/DESIGN.md, "3. Motor".
"""

from __future__ import annotations

from typing import Any

from ema_tools.reference.compiled import compiled


@compiled
def current_rate_A_per_s(motor: Any, voltage_V: float, current_A: float, speed_rad_s: float) -> float:
    """Rate of the current of a winding with inductance; `voltage_V` includes what effects add."""
    drop = motor.resistance_ohm * current_A + motor.back_emf_V_s_per_rad * speed_rad_s
    return (voltage_V - drop) / motor.inductance_H


@compiled
def torque_Nm(motor: Any, current_A: float) -> float:
    """Torque on the shaft, limited by the induction flux."""
    torque = motor.torque_constant_Nm_per_A * current_A
    if motor.torque_limit_Nm > 0.0:
        return max(-motor.torque_limit_Nm, min(motor.torque_limit_Nm, torque))
    return torque


@compiled
def saturation(motor: Any, current_A: float) -> int:
    """-1 or 1 while the torque is limited, else 0."""
    torque = motor.torque_constant_Nm_per_A * current_A
    if motor.torque_limit_Nm > 0.0 and abs(torque) > motor.torque_limit_Nm:
        return 1 if torque > 0.0 else -1
    return 0
