"""What is said of a fleet and its units."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ema_tools.fit.wear import READINGS_LEAST
from ema_tools.tasks.history import Trend, UnitHistory
from ema_tools.words.page import text as words
from ema_tools.words.page.names import FAULT_TITLES, listed
from ema_tools.words.page.trend import SHORT
from ema_tools.words.sentences.sizes import significant


def summary(units: Sequence[UnitHistory]) -> str:
    """The fleet in one or two sentences."""
    drifting = [one for one in units if any(trend.change.changed for trend in one.trends)]
    count = f"{len(units)} unit{'s' if len(units) != 1 else ''}"
    bad = sum(len(one.bad) for one in units)
    could = f" {bad} recording{'s' if bad != 1 else ''} could not be judged." if bad else ""
    near = [f"{one.unit} ({doubtful(one)})" for one in units if doubtful(one)]
    could = f"{f' Undecided near a large shift in the last record: {listed(near)}.' if near else ''}{could}"
    if not drifting:
        return f"None of {count} is known to drift.{could}" if near else f"None of {count} drifts.{could}"
    first = next((one for one in units if math.isfinite(one.urgency[0])), None)
    nearest = f" {first.unit} reaches a limit first, that of {soonest(first)}." if first is not None else ""
    return f"{len(drifting)} of {count} drift{'s' if len(drifting) == 1 else ''}.{nearest}{could}"


def unit_words(one: UnitHistory) -> str:
    """One unit in a sentence."""
    drifting = [trend for trend in one.trends if trend.change.changed]
    if not one.trends and not one.undecided_near:
        return f"{one.unit}: no reading that counts."
    near = doubtful(one)
    if not drifting:
        return f"{one.unit}: no drift is shown, but the last record is undecided near {near}." if near else f"{one.unit} does not drift."
    said = listed(
        [
            f"{SHORT[trend.name]} has changed by {words.shift(trend.change.by)} since {day_of(trend, trend.change.since)}"
            for trend in drifting
        ]
    )
    nearest = f"; it reaches its limit of {soonest(one)}" if math.isfinite(one.urgency[0]) else ""
    return f"{one.unit}: {said}{nearest}."


def doubtful(one: UnitHistory) -> str:
    """Large shifts that an undecided last record reads, as "BLK +77.0 %"; empty where there are none."""
    shifts = one.undecided_near.items()
    return listed([f"{SHORT[name]} {words.shift(percent)}" for name, percent in shifts])


def trend_words(trend: Trend) -> str:
    """One value of a unit in a sentence or two."""
    title = FAULT_TITLES[trend.name]
    last = f"last reading {words.shift(float(trend.shift_percent[-1]))}"
    if trend.days.size < READINGS_LEAST:
        return f"{title}: {last}; a change is told from {READINGS_LEAST} readings on."
    if not trend.change.changed:
        return f"{title}: no change ({last}; by chance as much in {_percent(trend.change.chance)} of units without one)."
    first, end = trend.change.since95
    since = f"since {day_of(trend, trend.change.since)} (95 %: {day_of(trend, first)} … {day_of(trend, end)})"
    if trend.life is None:
        return f"{title}: changed by {words.shift(trend.change.by)} {since}; {last}. No remaining life is told: it falls, or there are too few readings."
    return f"{title}: changed by {words.shift(trend.change.by)} {since}; {last}. {_rate_words(trend)}The limit of +{trend.limit_percent:g} % is reached {_life_words(trend)}."


def _rate_words(trend: Trend) -> str:
    found = trend.outlook
    return f"Its trend is {100.0 * found.rate:+.3g} ± {100.0 * found.rate_std:.2g} % in 100 days. " if found is not None else ""


def _life_words(trend: Trend) -> str:
    life = trend.life
    if life is None or not math.isfinite(life.low):
        return "not in what can be foreseen"
    middle = f"in {_days(life.median)}" if math.isfinite(life.median) else "later than can be foreseen, if at all"
    high = f"{life.high:.0f}" if math.isfinite(life.high) else "∞"
    return f"{middle} (90 %: {life.low:.0f} … {high} after the last reading)"


def soonest(one: UnitHistory) -> str:
    """When a unit reaches the nearer of its limits."""
    trend = min(one.trends, key=lambda trend: trend.urgency)
    return f"{SHORT[trend.name]} {_life_words(trend)}"


def _days(days: float) -> str:
    if not math.isfinite(days):
        return "never"
    return f"{round(days)} days" if days >= 10.0 else f"{days:.1f} days"


def _percent(share: float) -> str:
    return f"{significant(100.0 * share, 2)} %"


def day_of(trend: Trend, days: float) -> str:
    """The date of a day of the trend."""
    return trend.dates[int(np.argmin(np.abs(trend.days - days)))].date().isoformat() if math.isfinite(days) else "–"
