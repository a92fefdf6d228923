"""One run of the demo for all tests that look at it."""

from __future__ import annotations

import io
import tempfile
from functools import cache
from pathlib import Path

from rich.console import Console

from ema_tools.cli import demo

# Kept until the tests end.
_FOLDER = tempfile.TemporaryDirectory(prefix="ema_demo_")


@cache
def demo_run() -> tuple[Path, str]:
    """Folder of the results, and what was printed with the page and the new machine where a user finds them."""
    folder = Path(_FOLDER.name).resolve()
    printed = io.StringIO()
    page = demo.run(Console(file=printed, width=100, soft_wrap=True), folder)
    assert page == folder / "report.html"
    root = demo.recordings_folder().parent
    return folder, printed.getvalue().replace(str(folder), "build/demo").replace(f"{root}/", "")
