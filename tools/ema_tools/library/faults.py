"""The two fault parameters: what wears. Changes of them compete with the effects, so that a fault is not named as an effect."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ema_tools.library import measurements
from ema_tools.library.measurements import Measurement


@dataclass(frozen=True)
class FaultRecord:
    """The value that it is, the lower end of its usual change, relative, and what tells it from effects that are separated by the same."""

    value: str
    typical_share: float
    separated_by: tuple[Measurement, ...]


FAULT_RECORDS: Mapping[str, FaultRecord] = {
    "csj": FaultRecord("screw.csj_Nm", 0.05, (measurements.BREAK_AWAY,)),
    "blk": FaultRecord("screw.blk_mm", 0.25, (measurements.OUTSIDE_FORCE, measurements.GAUGE)),
}
# The value that each of them is.
FAULTS: Mapping[str, str] = {name: record.value for name, record in FAULT_RECORDS.items()}


def effect_of(name: str) -> str:
    """Effect, or fault parameter, that a value belongs to."""
    for fault, value in FAULTS.items():
        if name == value:
            return fault
    return name.split(".")[-2]
