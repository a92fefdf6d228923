"""A scored rod: the seal drags on the scored length that is drawn in."""

from typing import Any

from ema_tools.reference.compiled import compiled
from ema_tools.reference.point import Point


@compiled
def level_change_Nm(effect: Any, level_Nm: float, point: Point) -> float:
    """Change of the level of dry friction."""
    return effect.drag_Nm_per_mm * max(0.0, effect.start_mm - point.motor_mm)
