"""Block 3, motor: voltage to current to torque.

Equations: docs/DESIGN.md, "3. Motor".
"""

from __future__ import annotations

from typing import Any

from ema_tools.base.compiled import compiled


@compiled
def back_emf_V(motor: Any, speed_rad_s: float, change: float) -> float:
    """Voltage that the turning magnets induce; `change` is the relative change of its constant by effects."""
    return motor.back_emf_V_s_per_rad * (1.0 + change) * speed_rad_s


@compiled
def current_rate_A_per_s(motor: Any, voltage_V: float, current_A: float, speed_rad_s: float, change: float) -> float:
    """Rate of the current of a winding with inductance; `voltage_V` includes what effects add."""
    drop = motor.resistance_ohm * current_A + back_emf_V(motor, speed_rad_s, change)
    return (voltage_V - drop) / motor.inductance_H


@compiled
def torque_Nm(motor: Any, current_A: float, change: float) -> float:
    """Torque on the shaft, limited by the induction flux."""
    torque = motor.torque_constant_Nm_per_A * (1.0 + change) * current_A
    if motor.torque_limit_Nm > 0.0:
        return max(-motor.torque_limit_Nm, min(motor.torque_limit_Nm, torque))
    return torque


@compiled
def saturation(motor: Any, current_A: float, change: float) -> int:
    """-1 or 1 while the torque is limited, else 0."""
    torque = motor.torque_constant_Nm_per_A * (1.0 + change) * current_A
    if motor.torque_limit_Nm > 0.0 and abs(torque) > motor.torque_limit_Nm:
        return 1 if torque > 0.0 else -1
    return 0
