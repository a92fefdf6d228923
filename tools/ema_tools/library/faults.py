"""The two fault parameters: what wears. Changes of them compete with the effects, so that a fault is not named as an effect."""

from __future__ import annotations

from collections.abc import Mapping

# The value that each of them is.
FAULTS: Mapping[str, str] = {"csj": "screw.csj_Nm", "blk": "screw.blk_mm"}


def effect_of(name: str) -> str:
    """Effect, or fault parameter, that a value belongs to."""
    for fault, value in FAULTS.items():
        if name == value:
            return fault
    return name.split(".")[-2]
