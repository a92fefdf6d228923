"""Cold grease: viscous damping D (1 + rise)."""

from collections.abc import Mapping
from typing import Any

EXAMPLE = {"rise": 4.0}


def change_values(effect: Any, values: Mapping[str, float]) -> dict[str, float]:
    """The damping grows."""
    damping = values["screw.viscous_Nm_s_per_rad"]
    return {"screw.viscous_Nm_s_per_rad": damping * (1.0 + effect.rise)}
