"""Added or removed mass: J (1 + change)."""

from collections.abc import Mapping
from typing import Any

EXAMPLE = {"change": 0.15}


def change_values(effect: Any, values: Mapping[str, float]) -> dict[str, float]:
    """The total inertia changes."""
    return {"screw.inertia_kgm2": values["screw.inertia_kgm2"] * (1.0 + effect.change)}
