"""The loop sees an older position: transport delay of a sampled measurement."""

from collections.abc import Mapping
from typing import Any

EXAMPLE = {"delay_s": 1.4e-3}


def change_values(effect: Any, values: Mapping[str, float]) -> dict[str, float]:
    """The age of the feedback is larger by the effect's."""
    return {"encoder.delay_s": values["encoder.delay_s"] + effect.delay_s}
