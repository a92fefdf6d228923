"""Friction falls with speed: level * (1 + rise exp(-(|w|/speed)^shape)).

Source: H. Olsson et al., Friction models and friction compensation, Eur. J. Control 4 (1998).
"""

from typing import Any

from ema_tools.base.compiled import compiled
from reference_model.elementary import exp, power
from reference_model.point import Point

EXAMPLE = {"rise": 0.5, "speed_rad_s": 15.0, "shape": 1.5}


@compiled
def level_change_Nm(effect: Any, level_Nm: float, point: Point) -> float:
    """Change of the level of dry friction."""
    return level_Nm * effect.rise * exp(-power(abs(point.speed_rad_s) / effect.speed_rad_s, effect.shape))
