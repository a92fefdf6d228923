"""Torque of the magnets against the teeth: amplitude * sin(periods theta + phase).

Source: D. C. Hanselman, Brushless Permanent Magnet Motor Design (2003), ch. 10.
"""

from typing import Any

from ema_tools.base.compiled import compiled
from reference_model.elementary import sin
from reference_model.point import Point

EXAMPLE = {"amplitude_Nm": 0.03, "periods": 12.0, "phase_rad": 0.7}


@compiled
def torque_Nm(effect: Any, point: Point) -> float:
    """Torque on the shaft."""
    return effect.amplitude_Nm * sin(effect.periods * point.angle_rad + effect.phase_rad)
