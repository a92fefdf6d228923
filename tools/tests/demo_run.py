"""One run of the demo for all tests that look at it, in whatever process of a test run they are."""

from __future__ import annotations

import fcntl
import io
import os
import shutil
import tempfile
from functools import cache
from pathlib import Path

from rich.console import Console

from ema_tools.cli import demo

_PRINTED = "printed.txt"


def _folder(process: int) -> Path:
    """Of the test run that this process leads."""
    return Path(tempfile.gettempdir()).resolve() / f"ema_demo_{process}"


def forget_demo_run() -> None:
    """What the run leaves goes when the tests end: called by the process that leads them."""
    shutil.rmtree(_folder(os.getpid()), ignore_errors=True)


@cache
def demo_run() -> tuple[Path, str]:
    """Folder of the results, and what was printed with the page and the new machine where a user finds them."""
    # the workers of pytest-xdist are children of the process that leads them
    folder = _folder(os.getppid() if "PYTEST_XDIST_WORKER" in os.environ else os.getpid())
    folder.mkdir(exist_ok=True)
    results, printed = folder / "results", folder / _PRINTED
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not printed.exists():
            console = io.StringIO()
            page = demo.run(Console(file=console, width=100, soft_wrap=True), results)
            assert page == results / "report.html"
            printed.write_text(console.getvalue(), encoding="utf-8")
    root = demo.recordings_folder().parent
    return results, printed.read_text(encoding="utf-8").replace(str(results), "build/demo").replace(f"{root}/", "")
