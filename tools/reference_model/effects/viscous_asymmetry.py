"""Viscous friction that differs between the directions: D (1 + asymmetry sgn w), so the shaft gets - D asymmetry |w| more.

Source: A. Janot, M. Gautier, M. Brunot, direction-dependent friction of the EMPS axis (2019).
"""

from typing import Any

from ema_tools.base.compiled import compiled
from reference_model.point import Point

EXAMPLE = {"asymmetry": 0.4}


@compiled
def torque_Nm(effect: Any, point: Point) -> float:
    """Torque on the shaft beside the even part of the damping."""
    return -point.data.viscous_Nm_s_per_rad * effect.asymmetry * abs(point.speed_rad_s)
