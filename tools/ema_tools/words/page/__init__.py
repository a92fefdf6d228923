"""The page for results of `ema identify`, `ema compare`, `ema diagnose` and `ema add`: one HTML file that needs nothing else."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from ema_tools.base.errors import InputError
from ema_tools.base.files import write_text
from ema_tools.results.over_dates import UnitOverDates
from ema_tools.results.reading import Result, read_result
from ema_tools.words.page.page import render
from ema_tools.words.page.results import shown

__all__ = ["write_report"]


# The units of several results, with the files that hold them.
OverDates = Callable[[Sequence[tuple[Path, Result]]], Sequence[UnitOverDates]]


def write_report(results: Sequence[Path], output: Path, command: str, force: bool = False, over_dates: OverDates | None = None) -> None:
    """Writes the page for the result files to `output`.

    `command` is the command line that asked for it, for the page's provenance; `over_dates` says which of the results are of one unit.
    Raises InputError, one line that names file and field, before anything is written.
    """
    if not results:
        raise InputError("report: no result to show: give at least one file written with --json")
    found = [(path, read_result(path)) for path in results]
    drawn = [shown(one, str(path), path.stem) for path, one in found]
    write_text(output, render(drawn, command, over_dates(found) if over_dates is not None else ()), force)
