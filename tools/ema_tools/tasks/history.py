"""What a fleet's results say of each unit over its days: has CSJ or BLK changed, since when, and when it reaches its limit."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.base.interval import WIDTH_95
from ema_tools.fit.wear import Drift, Life, Outlook, outlook
from ema_tools.results.store import FleetRow

LIMITS = {
    "csj": 50.0,
    "blk": 100.0,
}  # shift at which a unit is taken out of service where nobody says another, % of the healthy value [judgement]
FALSE_ALARM = 0.01  # of a unit whose value does not change [chance]
_DAY_S = 86_400.0  # of a day [physics]
LARGE = 0.5  # of its limit: a shift that an undecided record may not pass over in silence [judgement]
UNKNOWN = Drift(False, 1.0, math.inf, (math.inf, math.inf), 0.0)  # of too few readings [layout]


@dataclass(frozen=True)
class Trend:
    """One value of one unit: its readings [n] in % of the healthy value with standard errors, on `days` [n] after the unit's first; `outlook` None where nothing wears or too little is known."""

    name: str
    dates: tuple[datetime, ...]
    days: Reals
    shift_percent: Reals
    std_percent: Reals
    limit_percent: float
    change: Drift
    outlook: Outlook | None

    @property
    def life(self) -> Life | None:
        """Time to the limit, where the value wears."""
        return self.outlook.life if self.outlook is not None else None

    @property
    def urgency(self) -> tuple[float, float]:
        """Smaller is sooner: the lower end of the remaining life, then how much of the limit is left."""
        left = 1.0 - float(self.shift_percent[-1]) / self.limit_percent if self.shift_percent.size else 1.0
        return (self.life.low if self.life is not None else math.inf, left)


@dataclass(frozen=True)
class UnitHistory:
    """One unit: its rows by date, and the trends of what was read; readings of a model that does not explain the record are in the rows alone."""

    unit: str
    rows: tuple[FleetRow, ...]
    trends: tuple[Trend, ...]
    limits: Mapping[str, float] = field(default_factory=lambda: LIMITS)

    @property
    def undecided_near(self) -> dict[str, float]:
        """Shifts of the last judged record by name, %, where it is undecided and they exceed a large share of their limit."""
        last = self.last
        if last is None or last.verdict != "undecided":
            return {}
        shifts = {name: last.reading(name)[0] for name in self.limits}
        return {name: shift for name, shift in shifts.items() if shift is not None and shift > LARGE * self.limits[name]}

    @property
    def bad(self) -> tuple[FleetRow, ...]:
        """Recordings that could not be judged."""
        return tuple(row for row in self.rows if row.status == "bad")

    @property
    def last(self) -> FleetRow | None:
        """The last recording that could be judged."""
        return next((row for row in reversed(self.rows) if row.status == "ok"), None)

    @property
    def urgency(self) -> tuple[float, float]:
        """That of the more urgent of its values."""
        return min((one.urgency for one in self.trends), default=(math.inf, 1.0))


def limits_of(text: str | None) -> Mapping[str, float]:
    """Limits from `csj=50,blk=100`. Raises InputError."""
    found = dict(LIMITS)
    for part in filter(None, (text or "").split(",")):
        name, _, value = part.partition("=")
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if name.strip() not in LIMITS or not number > 0.0 or math.isinf(number):
            raise InputError(f"--limit {part}: write csj=PERCENT or blk=PERCENT, a shift above 0")
        found[name.strip()] = number
    return found


def histories(rows: Iterable[FleetRow], limits: Mapping[str, float], false_alarm: float = FALSE_ALARM) -> list[UnitHistory]:
    """The units, the most urgent first."""
    ordered = sorted(rows, key=lambda row: (row.unit, row.date, row.file))
    found = [_history(unit, tuple(own), limits, false_alarm) for unit, own in itertools.groupby(ordered, lambda row: row.unit)]
    return sorted(found, key=lambda one: (one.urgency, one.unit))


def _history(unit: str, rows: tuple[FleetRow, ...], limits: Mapping[str, float], false_alarm: float) -> UnitHistory:
    trends = [_trend(name, rows, limits[name], false_alarm) for name in LIMITS]
    return UnitHistory(unit, rows, tuple(one for one in trends if one.days.size), limits)


def _trend(name: str, rows: Sequence[FleetRow], limit: float, false_alarm: float) -> Trend:
    kept = [row for row in rows if row.counts(name)]
    read = np.array([row.reading(name) for row in kept], dtype=np.float64).reshape(len(kept), 3)
    days = np.array([(row.date - kept[0].date).total_seconds() / _DAY_S for row in kept])
    shift, std = read[:, 0], np.maximum((read[:, 2] - read[:, 1]) / (2.0 * WIDTH_95), 1e-6)
    # both values of a unit are looked at
    found = outlook(days, shift, std, limit, false_alarm / len(LIMITS))
    change = found.drift if found is not None else UNKNOWN
    wears = found is not None and change.changed and change.by > 0.0
    return Trend(name, tuple(row.date for row in kept), days, shift, std, limit, change, found if wears else None)
