"""Dead time of the half bridges takes voltage against the current: - drop i / sqrt(i^2 + width^2).

Source: D. Leggate and R. J. Kerkman, Pulse-based dead-time compensator, IEEE Trans. Ind. Electron. 44 (1997).
"""

import math
from typing import Any

from ema_tools.base.compiled import compiled
from reference_model.point import Point

EXAMPLE = {"drop_V": 0.6, "width_A": 0.3}


@compiled
def voltage_change_V(effect: Any, point: Point) -> float:
    """Change of the motor voltage."""
    root = math.sqrt(point.current_A * point.current_A + effect.width_A * effect.width_A)
    return -effect.drop_V * point.current_A / root
