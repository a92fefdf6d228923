"""The position gain has drifted: Kp (1 + drift), in either structure of the control law."""

from collections.abc import Mapping
from typing import Any

EXAMPLE = {"drift": 0.1}


def change_values(effect: Any, values: Mapping[str, float]) -> dict[str, float]:
    """Both position gains change, so that the structure in use has it."""
    names = ("control.kp_per_m", "control.position_gain_per_s")
    return {name: values[name] * (1.0 + effect.drift) for name in names}
