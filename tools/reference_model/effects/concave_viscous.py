"""Shear-thinning grease: torque - drag sqrt|w| sgn w.

Source: L. Simoni et al., Friction modeling with temperature effects (2015).
"""

import math
from typing import Any

from ema_tools.base.compiled import compiled
from reference_model.point import Point

EXAMPLE = {"drag_Nm_per_sqrt_rad_s": 0.004}


@compiled
def torque_Nm(effect: Any, point: Point) -> float:
    """Torque on the shaft."""
    drag = effect.drag_Nm_per_sqrt_rad_s * math.sqrt(abs(point.speed_rad_s))
    return -drag if point.speed_rad_s > 0.0 else drag
