"""Tables of what the library does not hold, each with its gain fitted in the loop: what `ema diagnose` advises to learn and `ema add` puts in."""

from __future__ import annotations

from collections.abc import Iterator

from ema_tools.compare.localisation import Where
from ema_tools.compare.unexplained import LearnedTable, learned, left_over
from ema_tools.data.records import Record
from ema_tools.fit.evidence import View
from ema_tools.fit.refit import Fit, refit, seen_from, worn
from ema_tools.select.holdout import fitted_machine
from ema_tools.select.strategies.strategy import LEAST_LIMIT


def today_worn(here: View) -> View:
    """The record seen from CSJ and BLK of today, where baseline records tell them: friction and play that have changed are no table, which would hide them. `View.values` holds them."""
    fit = worn(here) if here.evidence.relative else None
    return seen_from(fit) if fit is not None and here.cost - fit.cost >= LEAST_LIMIT else here


def learned_tables(seen: View, record: Record, places: Where) -> list[LearnedTable]:
    """The tables that the balances of a record suggest beside the values of `seen`, the most telling first; `places`: where the model fails on it."""
    machine = fitted_machine(seen.evidence, None).changed(seen.values)
    return [table for one in left_over(machine, record, places) if (table := learned(one)) is not None]


def table_fit(seen: View, table: LearnedTable) -> Fit:
    """The gain of a table fitted to the view, together with the values that the view holds."""
    gain = f"effects.{table.effect}.gain"
    return refit(seen, {gain: 1.0, **seen.values}, {name: value for name, value in table.changes.items() if name != gain})


def helpful_tables(seen: View, record: Record, places: Where) -> Iterator[LearnedTable]:
    """Those of `learned_tables` that lower the error by more than noise can make it, at a size that is no bound and could not be none."""
    for table in learned_tables(seen, record, places):
        fit = table_fit(seen, table)
        if seen.cost - fit.cost >= LEAST_LIMIT and fit.determined(table.effect) and not fit.at_bound:
            yield table
