"""The result of `ema fleet`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from ema_tools.fit.wear import Outlook
from ema_tools.results.fleet import FleetResult, FleetUnitEntry, LifeEntry, TrendEntry
from ema_tools.results.parts import Provenance
from ema_tools.tasks.history import Trend, UnitHistory
from ema_tools.words.sentences.fleet import day_of, soonest, summary, trend_words, unit_words


def fleet_result(
    units: Sequence[UnitHistory], limits: Mapping[str, float], false_alarm: float, judged: int, wall_s: float, provenance: Provenance
) -> FleetResult:
    """What was found of every unit, in the order given."""
    return FleetResult("fleet", summary(units), tuple(map(_unit, units)), dict(limits), false_alarm, judged, wall_s, provenance)


def _unit(one: UnitHistory) -> FleetUnitEntry:
    last = one.last
    trends = {trend.name: trend_entry(trend) for trend in one.trends}
    nearest = soonest(one) if math.isfinite(one.urgency[0]) else None
    return FleetUnitEntry(
        one.unit, trends, last.verdict if last is not None else None, len(one.rows), len(one.bad), unit_words(one), nearest
    )


def trend_entry(trend: Trend, sentence: str = "") -> TrendEntry:
    """One value of a unit; `sentence` in place of the fleet's own."""
    change = trend.change
    return TrendEntry(
        sentence=sentence or trend_words(trend),
        days=tuple(trend.days.tolist()),
        shift_percent=tuple(trend.shift_percent.tolist()),
        std_percent=tuple(trend.std_percent.tolist()),
        limit_percent=trend.limit_percent,
        changed=change.changed,
        chance=change.chance,
        by_percent=change.by,
        since=day_of(trend, change.since) if change.changed else None,
        since_day=change.since if change.changed else None,
        life=_life(trend.outlook) if trend.outlook is not None else None,
    )


def _life(outlook: Outlook) -> LifeEntry:
    life = outlook.life

    def days(value: float) -> float | None:
        return value if math.isfinite(value) else None

    return LifeEntry(days(life.median), (days(life.low), days(life.high)), life.reached, life.now, outlook.rate, outlook.rate_std)
