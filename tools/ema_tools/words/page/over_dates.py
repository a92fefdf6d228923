"""The section of several results over dates: for each unit CSJ and BLK, small and beside each other, and a table of what was drawn."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from ema_tools.results.over_dates import UnitOverDates
from ema_tools.results.store import FleetRow
from ema_tools.words.page import text as words
from ema_tools.words.page.sheet import table
from ema_tools.words.page.trend import SHORT, Beside, drawing, legend

_WORDS = ' class="words"'
_IN_WORDS = (0, 1, 6)  # cells of a row that hold words: record, verdict, what counts [layout]
_ORDER = "results in the order given"


def section(units: Sequence[UnitOverDates], said: bool = False) -> str:
    """Markup of all units; empty without any. `said`: the sentence of the only one stands above already."""
    if not units:
        return ""
    shown = "".join(_unit(one, said) for one in units)
    return legend(shown, "CSJ and BLK over dates") + shown


def _unit(one: UnitOverDates, said: bool) -> str:
    figures = "".join(_figure(one, name) for name in SHORT if any(row.reading(name)[0] is not None for row in one.rows))
    rows = list(map(_row, one.rows, one.days, [one.dated] * len(one.rows)))
    heads = ("Date" if one.dated else "Place", "<Record", "<Verdict", "CSJ", "95 %", "BLK", "95 %", "<Counts")
    title = "" if said else f"<h3>{escape(one.sentence)}</h3>"
    caption = "A reading counts where the model explains the record and the record determines the value."
    listed = table(f"results of {escape(one.unit)}", caption, heads, rows)
    return (
        f'<div class="unit">{title}<div class="pair cards">{figures}</div>'
        f'<details><summary>{len(one.rows)} results of {escape(one.unit)}</summary>{listed}</details><p class="note">{escape(one.whence)}</p></div>'
    )


def _figure(one: UnitOverDates, name: str) -> str:
    trend = one.trends.get(name)
    # without an interval a reading has no place in the trend; it is shown all the same
    shown = [
        (day, shift)
        for row, day in zip(one.rows, one.days, strict=True)
        if not row.counts(name) and (shift := row.reading(name)[0]) is not None
    ]
    first = next((day for row, day in zip(one.rows, one.days, strict=True) if row.counts(name)), 0.0)
    beside = Beside(
        x_title=f"days since {one.rows[0].date.date().isoformat()}" if one.dated else _ORDER,
        threshold_percent=one.thresholds_percent.get(name),
        more_days=np.array([day for day, _ in shown]),
        more_percent=np.array([shift for _, shift in shown]),
        by_order=not one.dated,
        first=first,
    )
    told = trend.sentence if trend is not None else f"{SHORT[name]}: no reading that counts."
    return f"<figure>{drawing(name, trend, beside)}<figcaption>{escape(told)}</figcaption></figure>"


def _row(row: FleetRow, day: float, dated: bool) -> str:
    def value(name: str) -> tuple[str, str]:
        shift, low, high = row.reading(name)
        spread = words.interval(low, high) if low is not None and high is not None else "–"
        return ("–" if shift is None else words.shift(shift), spread)

    counts = [short for name, short in SHORT.items() if row.counts(name)]
    cells = (row.file, row.verdict or "–", *value("csj"), *value("blk"), " and ".join(counts) or "no")
    head = row.date.date().isoformat() if dated else f"{day:g}"
    shown = "".join(f"<td{_WORDS if place in _IN_WORDS else ''}>{escape(cell)}</td>" for place, cell in enumerate(cells))
    return f'<tr><th scope="row">{head}</th>{shown}</tr>'
