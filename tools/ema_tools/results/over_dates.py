"""Several results of units over their dates: what `ema report` draws of them."""

from __future__ import annotations

from dataclasses import dataclass

from ema_tools.results.fleet import TrendEntry
from ema_tools.results.store import FleetRow


@dataclass(frozen=True)
class UnitOverDates:
    """The results of one unit in the order of their dates. `dated`: whether every one has a date; without, `days` are places in the order given, from 1."""

    unit: str
    dated: bool
    rows: tuple[FleetRow, ...]
    days: tuple[float, ...]  # of the rows, after the first
    trends: dict[str, TrendEntry]  # of csj and blk, by the readings that count
    thresholds_percent: dict[str, float]  # smallest shift that is called a fault, where it is known
    sentence: str
    whence: str  # where the dates are from, in words
