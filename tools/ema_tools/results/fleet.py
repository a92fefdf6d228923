"""What `ema fleet` writes: every unit's trends and remaining life; the readings themselves stand in the store."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ema_tools.results.codec import Series
from ema_tools.results.parts import Provenance


@dataclass(frozen=True)
class LifeEntry:
    """Time from the last reading until the limit, days: median and 90 % interval; None where it lies beyond what can be foreseen."""

    median_days: float | None
    interval90_days: tuple[float | None, float | None]
    reached: float  # probability that it is reached in what is looked ahead
    now_percent: float  # the value of the last day by all days
    rate_percent_per_day: float | None = None  # its trend there, with its standard error
    rate_std_percent_per_day: float | None = None


@dataclass(frozen=True)
class TrendEntry:
    """One value of a unit, in % of its healthy value: its readings with standard errors on days after the first, what has changed, and when it reaches its limit."""

    sentence: str
    days: Series
    shift_percent: Series
    std_percent: Series
    limit_percent: float
    changed: bool
    chance: float  # share of units without change that show as much
    by_percent: float
    since: str | None  # first day of the change, ISO 8601; None without one
    since_day: float | None  # the same in days after the first
    life: LifeEntry | None  # None where nothing wears, or too little is known


@dataclass(frozen=True)
class FleetUnitEntry:
    """One unit; the trends by csj and blk."""

    unit: str
    trends: dict[str, TrendEntry]
    verdict: str | None  # of the last recording that could be judged
    records: int
    not_judged: int
    sentence: str
    soonest: str | None  # when it reaches the nearer of its limits, in words; None where nothing wears


@dataclass(frozen=True)
class FleetResult:
    """All units, the most urgent first."""

    command: Literal["fleet"]
    sentence: str
    units: tuple[FleetUnitEntry, ...]
    limits_percent: dict[str, float]
    false_alarm: float
    judged_now: int
    wall_s: float
    provenance: Provenance
