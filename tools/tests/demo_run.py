"""One run of the demo for all tests that look at it."""

from __future__ import annotations

import io
from functools import cache
from pathlib import Path

from rich.console import Console

from ema_tools.cli import demo
from shared_results import shared_folder


@shared_folder
def _demo(folder: Path) -> None:
    console = io.StringIO()
    page = demo.run(Console(file=console, width=100, soft_wrap=True), folder / "results")
    assert page == folder / "results" / "report.html"
    (folder / "printed.txt").write_text(console.getvalue().replace(str(folder / "results"), "build/demo"), encoding="utf-8")


@cache
def demo_run() -> tuple[Path, str]:
    """Folder of the results, and what was printed with the page and the new machine where a user finds them."""
    root = demo.recordings_folder().parent
    return _demo() / "results", (_demo() / "printed.txt").read_text(encoding="utf-8").replace(f"{root}/", "")
