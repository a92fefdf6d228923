"""Torque constant and back-EMF vary with the motor angle: kt, ke (1 + ratio cos(periods theta + phase)).

Source: T. M. Jahns and W. L. Soong, Pulsating torque minimization techniques, IEEE Trans. Ind. Electron. 43 (1996).
"""

from typing import Any

from ema_tools.base.compiled import compiled
from reference_model.elementary import cos
from reference_model.point import Point

EXAMPLE = {"ratio": 0.05, "periods": 6.0, "phase_rad": 0.4}


@compiled
def motor_change(effect: Any, point: Point) -> float:
    """Relative change of both constants."""
    return effect.ratio * cos(effect.periods * point.angle_rad + effect.phase_rad)
