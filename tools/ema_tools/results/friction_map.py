"""What `ema map` writes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from ema_tools.results.parts import Provenance


@dataclass(frozen=True)
class MapPointEntry:
    """Runs of one speed in one direction."""

    speed_rad_s: float  # of the motor, negative backward
    torque_Nm: float  # of the drive at the motor shaft, inertia and known disturbances taken off
    low_Nm: float  # of its band: the mean less one standard deviation of the samples
    high_Nm: float
    interval95: tuple[float | None, float | None]  # of the mean
    model_Nm: float  # what the actuator's model asks for there
    runs: int
    seconds: float  # of all of them together
    records: tuple[str, ...]

    @property
    def outside(self) -> bool:
        """Whether the model lies outside the 95 % interval of the mean; where there is none, outside the band."""
        low, high = self.interval95
        low, high = (self.low_Nm, self.high_Nm) if low is None or high is None else (low, high)
        return not low <= self.model_Nm <= high


@dataclass(frozen=True)
class BothWays:
    """One speed that was run in both directions."""

    speed_rad_s: float
    friction_Nm: float  # half the difference of the torques
    load_Nm: float  # half their sum, against extension


@dataclass(frozen=True)
class MapResult:
    """The steady-state friction map."""

    command: Literal["map"]
    name: str  # of the first record
    actuator: str
    records: tuple[str, ...]
    sentence: str
    runs: int  # at constant speed
    points: tuple[MapPointEntry, ...]  # by speed
    both_ways: tuple[BothWays, ...]  # by speed
    left_out: dict[str, str] = field(default_factory=dict)  # records without a run at constant speed, and why
    provenance: Provenance = field(default_factory=dict)
