"""The drive limits the current; of two limits the lower counts."""

from collections.abc import Mapping
from typing import Any

EXAMPLE = {"limit_A": 5.0}


def change_values(effect: Any, values: Mapping[str, float]) -> dict[str, float]:
    """The limit of the drive; zero was none."""
    known = values["drive.current_limit_A"]
    return {"drive.current_limit_A": min(known, effect.limit_A) if known > 0.0 else effect.limit_A}
