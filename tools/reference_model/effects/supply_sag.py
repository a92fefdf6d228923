"""A bus voltage below its nominal value: Vdc (1 - sag)."""

from collections.abc import Mapping
from typing import Any

EXAMPLE = {"sag": 0.06}


def change_values(effect: Any, values: Mapping[str, float]) -> dict[str, float]:
    """The bus voltage falls."""
    return {"drive.supply_V": values["drive.supply_V"] * (1.0 - effect.sag)}
