"""Tables of what the library does not hold, each with its gain fitted in the loop: what `ema diagnose` advises to learn and `ema add` puts in."""

from __future__ import annotations

from collections.abc import Iterator

from ema_tools.compare.localisation import Where
from ema_tools.compare.unexplained import LearnedTable, learned, left_over
from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record
from ema_tools.fit.evidence import Evidence, View, settled
from ema_tools.fit.refit import Fit, refit
from ema_tools.select.holdout import fitted_machine
from ema_tools.select.strategies.strategy import LEAST_LIMIT


def learned_tables(machine: Actuator, record: Record, places: Where) -> list[LearnedTable]:
    """The tables that the balances of a record suggest, the most telling first; `places`: where the model of `machine` fails on it."""
    return [table for one in left_over(machine, record, places) if (table := learned(one)) is not None]


def table_fit(here: View, table: LearnedTable) -> Fit:
    """The gain of a table fitted to the view."""
    gain = f"effects.{table.effect}.gain"
    return refit(here, {gain: 1.0}, {name: value for name, value in table.changes.items() if name != gain})


def helpful_tables(evidence: Evidence, record: Record, places: Where) -> Iterator[LearnedTable]:
    """Those of `learned_tables` that lower the error by more than noise can make it, at a size that is no bound and could not be none."""
    here = settled(evidence, {})
    for table in learned_tables(fitted_machine(evidence, None), record, places):
        fit = table_fit(here, table)
        if here.cost - fit.cost >= LEAST_LIMIT and fit.determined(table.effect) and not fit.at_bound:
            yield table
