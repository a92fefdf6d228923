"""What is said of several results of a unit."""

from __future__ import annotations

from ema_tools.tasks.history import Trend
from ema_tools.tasks.several_results import SeveralReadings
from ema_tools.words.page import text as words
from ema_tools.words.page.names import FAULT_TITLES, listed
from ema_tools.words.page.trend import SHORT
from ema_tools.words.sentences.fleet import unit_words

_WHERE = {"record": "the names of the records", "result": "the names of the result files", "folder": "the names of the folders"}
_NAMED = 3  # results without a date that are named [layout]


def several_words(one: SeveralReadings) -> str:
    """A unit in a sentence: what has changed over its dates, else what its last result reads."""
    history = one.history
    if not history.trends:
        return f"{history.unit}: {len(history.rows)} results, and no reading of them counts."
    if one.dated and any(trend.change.changed for trend in history.trends):
        return unit_words(history)
    last = listed([f"{SHORT[trend.name]} {words.shift(float(trend.shift_percent[-1]))}" for trend in history.trends])
    return f"{history.unit}: {len(history.rows)} results; the last that counts reads {last}."


def by_order_words(trend: Trend) -> str:
    """One value without dates, of which no rate and no remaining life is told."""
    first, last = (words.shift(float(trend.shift_percent[place])) for place in (0, -1))
    return f"{FAULT_TITLES[trend.name]}: {first} in the first result that counts, {last} in the last. Without dates nothing is said of its pace."


def whence_words(one: SeveralReadings) -> str:
    """Where the dates are from, or why there are none."""
    if one.dated:
        return f"Dates are from {listed([_WHERE[who] for who in one.sources])}."
    shown = listed([*one.undated[:_NAMED], *([f"{len(one.undated) - _NAMED} more"] if len(one.undated) > _NAMED else [])])
    return f"In the order given: {shown} {'has' if len(one.undated) == 1 else 'have'} no date (such as 2026-03-31) in the name of record, result or folder."
