"""Scale error of the rod sensor: it reads x (1 + error)."""

from collections.abc import Mapping
from typing import Any

EXAMPLE = {"error": 0.005}


def change_values(effect: Any, values: Mapping[str, float]) -> dict[str, float]:
    """The gain error is larger by the effect's."""
    return {"encoder.rod_gain_error": values["encoder.rod_gain_error"] + effect.error}
