"""A supply with inner resistance: bus voltage Vdc - resistance |i|, of which the motor gets the share V / Vdc."""

from typing import Any

from ema_tools.base.compiled import compiled
from reference_model.point import Point

EXAMPLE = {"resistance_ohm": 0.15}


@compiled
def voltage_change_V(effect: Any, point: Point) -> float:
    """Change of the motor voltage."""
    output = point.voltage_V / point.data.supply_V
    return -output * effect.resistance_ohm * abs(point.current_A)
