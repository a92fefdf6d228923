"""The page for results of `ema identify`, `ema compare`, `ema diagnose` and `ema add`: one HTML file that needs nothing else."""

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
