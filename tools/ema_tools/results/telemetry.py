"""What `ema telemetry` writes: results that firmware packed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class PackedValue:
    """A value that was identified, in its own unit; None for a number that is not finite."""

    name: str  # section.field
    estimate: float | None
    std: float | None
    bias: float | None
    half_95: float | None  # of the 95 % interval about the estimate
    shift_percent: float | None  # of the healthy value
    at_bound: bool


@dataclass(frozen=True)
class PackedFinding:
    """What the table of signatures said, scores in variances of the noise; None for a number that is not finite."""

    kind: str  # adequate, missing, unknown or none
    effect: str | None
    runner_up: str | None
    alike: tuple[str, ...]
    size: float | None
    score: float | None
    runner_up_score: float | None
    limit: float | None
    energy: float | None


@dataclass(frozen=True)
class Packet:
    """One result."""

    software: str  # major.minor.patch of the module
    configuration: str  # eight hexadecimal digits: identity of the unit's configuration, as `ema export --image` writes it
    verdict: str  # healthy, fault or undecided
    reasons: tuple[str, ...]
    adequate: bool
    outcome: str  # why the search stopped
    values: tuple[PackedValue, ...]
    finding: PackedFinding | None  # None of a session without a table
    objective_before_mm2s: float | None
    objective_after_mm2s: float | None
    residual_rms_mm: float | None
    residual_correlation: float | None
    outside_ratio: float | None
    evaluations: int
    model_steps: int
    search: dict[str, int]  # counts
    random: str  # hexadecimal digits: final state of the random numbers


@dataclass(frozen=True)
class TelemetryResult:
    """Packed results of a file, in its order."""

    command: Literal["telemetry"]
    file: str
    packets: tuple[Packet, ...]
