"""What the terminal shows: results on standard output, progress on standard error and only when somebody watches."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import Any

import click
from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn
from rich.table import Table

from ema_tools.base.errors import InputError
from ema_tools.base.files import readable
from ema_tools.words.sentences.sizes import significant

_SHOW_AFTER_S = 0.5
_WORD, _GAP = 16, 2  # columns of a text that may go on below, and between two [layout]


class _Whole(Console):
    """A console that cuts no number: a table whose numbers need more columns than there are is as wide as they."""

    def print(self, *objects: Any, **options: Any) -> None:
        least = max((_least_width(one) for one in objects if isinstance(one, Table)), default=0)
        if least <= self.width:
            super().print(*objects, **options)
        else:
            Console(width=least, file=self.file, highlight=False, soft_wrap=True).print(*objects, **options)


def output() -> Console:
    """Console of the results; 100 columns wide when it is not a terminal, so that tables do not break."""
    return _Whole(width=None if sys.stdout.isatty() else 100, highlight=False, soft_wrap=not sys.stdout.isatty())


def _least_width(made: Table) -> int:
    """Columns that a table of `table` takes at least: its numbers whole, the first words of what may go on below."""
    return sum(
        max([len(str(column.header)), *map(len, map(str, column.cells))] if column.no_wrap else [_WORD]) + _GAP for column in made.columns
    )


def table(title: str, *columns: str, text_columns: int = 1) -> Table:
    """An empty table; all columns but the first `text_columns` are numbers."""
    made = Table(title=title, title_justify="left", title_style="bold", header_style="bold", box=None, padding=(0, _GAP, 0, 0))
    for place, column in enumerate(columns):
        # a name that is cut cannot be typed: what does not fit goes on below
        made.add_column(column, justify="left" if place < text_columns else "right", no_wrap=place >= text_columns, overflow="fold")
    return made


class Bar:
    """Progress of one task; appears after half a second on a terminal, and nowhere else."""

    def __init__(self, title: str, total: float) -> None:
        """`total` is the amount of work, in the unit that `update` uses."""
        self._title = title
        self._total = total
        self._begun_s = time.monotonic()
        self._progress: Progress | None = None
        self._task: TaskID | None = None
        self._shown = sys.stderr.isatty()
        self._done = 0.0

    def __enter__(self) -> Bar:
        return self

    def update(self, done: float, note: str = "") -> None:
        """Say how much is done by now."""
        if self._shown and (self._progress is not None or time.monotonic() - self._begun_s >= _SHOW_AFTER_S):
            self._show(done, note)

    def note(self, text: str) -> None:
        """Say at once what is done now, where nobody knows how much of it there is."""
        if self._shown:
            self._show(self._done, text)

    def _show(self, done: float, note: str) -> None:
        self._done = done
        if self._progress is None:
            columns = (
                TextColumn("{task.description}"),
                BarColumn(),
                TextColumn("{task.completed:.0f}/{task.total:.0f} {task.fields[note]}"),
                TimeElapsedColumn(),
            )
            self._progress = Progress(*columns, console=Console(stderr=True), transient=True)
            self._progress.start()
            self._task = self._progress.add_task(self._title, total=self._total, note="")
        if self._task is not None:
            self._progress.update(self._task, completed=done, note=note)

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._progress is not None:
            self._progress.stop()


@contextmanager
def progress(title: str, total: float) -> Iterator[Bar]:
    """A `Bar` for the length of a with block."""
    with Bar(title, total) as bar:
        yield bar


def complain(message: str) -> None:
    """One line on standard error."""
    sys.stderr.write(f"ema: {' '.join(readable(message).split())}\n")


def run_command(command: click.Command) -> None:
    """Run a program's command; what goes wrong because of an input is one line and exit code 1, a wrong option exit code 2."""
    try:
        command(standalone_mode=False)
    except InputError as error:
        complain(str(error))
        sys.exit(1)
    except click.ClickException as error:
        error.show()
        sys.exit(2)


def number(value: float | None, digits: int = 4) -> str:
    """A number with `digits` significant digits; a dash for none."""
    if value is None or value != value:
        return "-"
    return significant(value, digits)
