"""The ways in which a missing effect is sought, one file each: against healthy repeats, from the data sheet alone, and in the mean of a healthy machine's repeats."""

from __future__ import annotations

from collections.abc import Collection

from ema_tools.fit.evidence import Evidence
from ema_tools.select.strategies.data_sheet_alone import DataSheetAlone
from ema_tools.select.strategies.strategy import Strategy
from ema_tools.select.strategies.with_repeats import WithRepeats


def strategy_for(evidence: Evidence, only: Collection[str] | None = None) -> Strategy:
    """The one that the evidence allows; `only`: the effects and faults that are tried."""
    return (WithRepeats if evidence.repeats else DataSheetAlone)(evidence, only)
