"""Friction that grows with the transmitted torque and falls with speed: level + ratio |kt i| exp(-(|w|/speed)^shape).

Source: A. C. Bittencourt and S. Gunnarsson, Static friction in a robot joint, J. Dyn. Syst. Meas. Control 134 (2012).
"""

from typing import Any

from ema_tools.base.compiled import compiled
from reference_model.elementary import exp, power
from reference_model.point import Point

EXAMPLE = {"ratio": 0.15, "speed_rad_s": 20.0, "shape": 1.3}


@compiled
def level_change_Nm(effect: Any, level_Nm: float, point: Point) -> float:
    """Change of the level of dry friction."""
    torque = abs(point.data.torque_constant_Nm_per_A * point.current_A)
    return effect.ratio * torque * exp(-power(abs(point.speed_rad_s) / effect.speed_rad_s, effect.shape))
