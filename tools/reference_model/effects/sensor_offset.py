"""Zero shift of the rod sensor: it reads x + offset."""

from collections.abc import Mapping
from typing import Any

EXAMPLE = {"offset_mm": 0.05}


def change_values(effect: Any, values: Mapping[str, float]) -> dict[str, float]:
    """The offset is larger by the effect's."""
    return {"encoder.rod_offset_mm": values["encoder.rod_offset_mm"] + effect.offset_mm}
