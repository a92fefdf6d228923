"""A spring at the rod: load torque stiffness * x, against displacement; linearised aerodynamic hinge moment."""

from typing import Any

from ema_tools.base.compiled import compiled
from reference_model.point import Point

EXAMPLE = {"stiffness_Nm_per_mm": 0.06, "gearbox.efficiency": 0.9}


@compiled
def load_Nm(effect: Any, point: Point) -> float:
    """Torque against extension."""
    return effect.stiffness_Nm_per_mm * point.motor_mm
