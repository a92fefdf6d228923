"""The result of `ema fleet`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from ema_tools.fit.wear import Life
from ema_tools.results.fleet import FleetResult, LifeEntry, TrendEntry, FleetUnitEntry
from ema_tools.results.parts import Provenance
from ema_tools.tasks.history import Trend, UnitHistory
from ema_tools.words.sentences.fleet import day_of, summary, unit_words


def fleet_result(
    units: Sequence[UnitHistory], limits: Mapping[str, float], false_alarm: float, judged: int, wall_s: float, provenance: Provenance
) -> FleetResult:
    """What was found of every unit, in the order given."""
    return FleetResult("fleet", summary(units), tuple(map(_unit, units)), dict(limits), false_alarm, judged, wall_s, provenance)


def _unit(one: UnitHistory) -> FleetUnitEntry:
    last = one.last
    trends = {trend.name: _trend(trend) for trend in one.trends}
    return FleetUnitEntry(one.unit, trends, last.verdict if last is not None else None, len(one.rows), len(one.bad), unit_words(one))


def _trend(trend: Trend) -> TrendEntry:
    change = trend.change
    return TrendEntry(
        readings=int(trend.days.size),
        last_percent=float(trend.shift_percent[-1]),
        limit_percent=trend.limit_percent,
        changed=change.changed,
        chance=change.chance,
        by_percent=change.by,
        since=day_of(trend, change.since) if change.changed else None,
        life=_life(trend.life) if trend.life is not None else None,
    )


def _life(life: Life) -> LifeEntry:
    def days(value: float) -> float | None:
        return value if math.isfinite(value) else None

    return LifeEntry(days(life.median), (days(life.low), days(life.high)), life.reached)
