"""A damaged spot of the raceway: level + amplitude exp(-((x - place) / width)^2)."""

from typing import Any

from ema_tools.base.compiled import compiled
from reference_model.elementary import exp
from reference_model.point import Point

EXAMPLE = {"amplitude_Nm": 0.1, "place_mm": 0.6, "width_mm": 0.3}


@compiled
def level_change_Nm(effect: Any, level_Nm: float, point: Point) -> float:
    """Change of the level of dry friction."""
    away = (point.motor_mm - effect.place_mm) / effect.width_mm
    return effect.amplitude_Nm * exp(-away * away)
