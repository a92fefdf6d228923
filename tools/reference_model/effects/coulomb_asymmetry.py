"""Dry friction that differs between the directions: level * (1 + asymmetry sgn w).

Source: A. Janot, M. Gautier, M. Brunot, direction-dependent friction of the EMPS axis (2019).
"""

from collections.abc import Mapping
from typing import Any

EXAMPLE = {"asymmetry": 0.06}


def change_values(effect: Any, values: Mapping[str, float]) -> dict[str, float]:
    """The asymmetry is larger by the effect's."""
    return {"screw.friction_asymmetry": values["screw.friction_asymmetry"] + effect.asymmetry}
