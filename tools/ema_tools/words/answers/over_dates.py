"""Several results over dates, for their page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ema_tools.results.over_dates import UnitOverDates
from ema_tools.results.reading import Result
from ema_tools.tasks.several_results import SeveralReadings, several_results
from ema_tools.words.answers.fleet import trend_entry
from ema_tools.words.sentences.over_dates import by_order_words, several_words, whence_words

_DAY_S = 86_400.0  # of a day [physics]


def over_dates(found: Sequence[tuple[Path, Result]]) -> tuple[UnitOverDates, ...]:
    """Every unit of which `found`, with the files that hold it, has two records or more."""
    return tuple(map(_unit, several_results(found)))


def _unit(one: SeveralReadings) -> UnitOverDates:
    rows = one.history.rows
    first = rows[0].date
    days = tuple((row.date - first).total_seconds() / _DAY_S + (0.0 if one.dated else 1.0) for row in rows)
    return UnitOverDates(
        unit=one.history.unit,
        dated=one.dated,
        rows=rows,
        days=days,
        trends={trend.name: trend_entry(trend) if one.dated else trend_entry(trend, by_order_words(trend)) for trend in one.history.trends},
        thresholds_percent=dict(one.thresholds),
        sentence=several_words(one),
        whence=whence_words(one),
    )
