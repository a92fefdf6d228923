"""Dry friction that grows with the transmitted torque: level + ratio |kt i|.

Source: M. D. L. Dalla Vedova et al., load-dependent dry friction (2012).
"""

from typing import Any

from ema_tools.base.compiled import compiled
from reference_model.point import Point

EXAMPLE = {"ratio": 0.1}


@compiled
def level_change_Nm(effect: Any, level_Nm: float, point: Point) -> float:
    """Change of the level of dry friction."""
    return effect.ratio * abs(point.data.torque_constant_Nm_per_A * point.current_A)
