"""Turbulent drag on the rotor: torque - drag w |w|.

Source: F. M. White, Fluid Mechanics (2011), ch. 7.
"""

from typing import Any

from ema_tools.base.compiled import compiled
from reference_model.point import Point

EXAMPLE = {"drag_Nm_s2_per_rad2": 1e-6}


@compiled
def torque_Nm(effect: Any, point: Point) -> float:
    """Torque on the shaft."""
    return -effect.drag_Nm_s2_per_rad2 * point.speed_rad_s * abs(point.speed_rad_s)
