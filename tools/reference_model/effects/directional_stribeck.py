"""Friction falls with speed, from another level in each direction: level (1 + rise (1 + asymmetry sgn w) exp(-(|w|/speed)^shape)).

Source: B. Armstrong-Helouvry, Control of Machines with Friction (1991), ch. 4.
"""

from typing import Any

from ema_tools.base.compiled import compiled
from reference_model.elementary import exp, power
from reference_model.point import Point

EXAMPLE = {"rise": 0.4, "asymmetry": -0.6, "speed_rad_s": 12.0, "shape": 1.5}


@compiled
def level_change_Nm(effect: Any, level_Nm: float, point: Point) -> float:
    """Change of the level of dry friction."""
    larger = 1.0 + effect.asymmetry * point.direction
    return level_Nm * effect.rise * larger * exp(-power(abs(point.speed_rad_s) / effect.speed_rad_s, effect.shape))
