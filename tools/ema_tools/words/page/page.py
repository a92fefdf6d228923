"""The page of one or several results: one self-contained HTML file. Which kind of page a result has is decided here alone."""

from __future__ import annotations

from collections.abc import Sequence

from ema_tools.results.over_dates import UnitOverDates
from ema_tools.words.page import comparison_page, diagnosis_page, identification_page, map_page, several_page
from ema_tools.words.page.diagnosis_results import Diagnosed
from ema_tools.words.page.results import Mapped, Result, ShownIdentification


def render(results: Sequence[Result], command: str, units: Sequence[UnitOverDates] = ()) -> str:
    """The page as text. `command` made it and stands in its provenance; `units`: results of one unit over dates."""
    if len(results) > 1:
        return several_page.render(results, command, units)
    (one,) = results
    if isinstance(one, Diagnosed):
        return diagnosis_page.render(one, command)
    if isinstance(one, ShownIdentification):
        return identification_page.render(one, command)
    return map_page.render(one, command) if isinstance(one, Mapped) else comparison_page.render(one, command)
