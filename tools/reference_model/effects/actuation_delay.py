"""The motor sees the output of the control law later: computation, modulation and current loop of a digital drive."""

from collections.abc import Mapping
from typing import Any

EXAMPLE = {"delay_s": 1.4e-3}


def change_values(effect: Any, values: Mapping[str, float]) -> dict[str, float]:
    """The delay of the drive is larger by the effect's."""
    return {"drive.output_delay_s": values["drive.output_delay_s"] + effect.delay_s}
