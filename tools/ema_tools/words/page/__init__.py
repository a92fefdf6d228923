"""The page for results of `ema identify`, `ema compare`, `ema diagnose` and `ema add`: one HTML file that needs nothing else. For the last two see `ema_tools.words.page.diagnosis`.

Besides the keys that programs read, a result may hold these, and the page shows what is there:

    name         what to call it; else the file's name
    wall_s       time of the identification
    curves       {start_s, period_s, measured: {position_mm: [...], speed_mm_s, current_A, voltage_V}, before: {...}, after: {...}};
                 for a comparison `model` in place of before and after; the speed is derived where it is absent
    search       {cost_mm2s: [...]}: cost of every model run in the order they were made
    provenance   {key: text}: command, versions, seed, record
    case, noise  letter of the paper's case whose truth is known, and the sensor noise in the record
    sentence     of a comparison: what it found
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ema_tools.base.errors import InputError
from ema_tools.base.files import write_text
from ema_tools.words.page.page import render
from ema_tools.words.page.results import read_result

__all__ = ["write_report"]


def write_report(results: Sequence[Path], output: Path, command: str, force: bool = False) -> None:
    """Writes the page for the result files to `output`.

    `command` is the command line that asked for it, for the page's provenance.
    Raises InputError, one line that names file and field, before anything is written.
    """
    if not results:
        raise InputError("report: no result to show: give at least one file written with --json")
    write_text(output, render([read_result(path) for path in results], command), force)
