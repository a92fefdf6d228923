"""Dry friction that varies once per lead: level * (1 + ratio sin(2 pi x / lead + phase)).

Source: periodic lead error of a ball screw, ISO 3408-3.
"""

from typing import Any

from ema_tools.base.compiled import compiled
from reference_model.elementary import TWO_PI, sin
from reference_model.point import Point

EXAMPLE = {"ratio": 0.08, "phase_rad": 0.7}


@compiled
def level_change_Nm(effect: Any, level_Nm: float, point: Point) -> float:
    """Change of the level of dry friction."""
    turns = point.motor_mm / point.data.lead_mm
    return level_Nm * effect.ratio * sin(TWO_PI * turns + effect.phase_rad)
