"""What `ema next --detect` writes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from ema_tools.results.experiment import SafeLimits
from ema_tools.results.parts import Provenance


@dataclass(frozen=True)
class LimitEntry:
    """What is seen of one value, in % of healthy."""

    scatter: float  # standard deviation of what is read from run to run
    threshold: float  # of its own test, at the rate of false alarms
    alone: float  # the shift that this test finds with the power
    together: float  # the shift of this value alone that the test of both finds with the power
    today: float  # how far it moves besides for what the machine may be today without anybody knowing; 0 where all signals are used


@dataclass(frozen=True)
class SightEntry:
    """What is seen on one command, by value (csj, blk)."""

    title: str
    command: str  # as --command takes it
    duration_s: float
    onboard: dict[str, LimitEntry]  # by the onboard search, which has the rod position alone
    signals: dict[str, LimitEntry]  # by the best use of all that is recorded
    verdict: dict[str, float]  # the shift that the onboard module calls a fault with the power, by the actuator's own thresholds
    false_alarms: float  # share of ground tests of a healthy machine that exceed one of those thresholds, 0..1
    relative: float  # the shift that the onboard test finds over the actuator's own threshold, root mean square of both values; options stand in its order
    could_replace: bool  # no longer than the present test, and hangs no more on what the machine is today
    peak_current_A: float
    peak_speed_mm_s: float


@dataclass(frozen=True)
class DetectionResult:
    """The smallest shifts that a ground test finds, now and under other commands."""

    command: Literal["next"]
    detect: Literal[True]
    false_alarm: float  # share of ground tests of a healthy machine that exceed a threshold, 0..1: of both single tests together, and of the test of both
    power: float  # share of the shifts that are found, 0..1
    runs: int | None  # healthy runs that show mean and scatter; None where both count as known
    channels: tuple[str, ...]  # that are recorded
    sentence: str
    present: SightEntry
    best: SightEntry | None  # that could replace it; None where none is better
    options: tuple[SightEntry, ...]  # safe ones, best first
    unsafe: dict[str, str]  # commands that were left out, and why
    limits: SafeLimits
    provenance: Provenance = field(default_factory=dict)
