"""Runs trials on all cores and keeps every row as soon as it is there; an interrupted run is taken up where it ended."""

from __future__ import annotations

import json
import multiprocessing
import os
import time
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import nullcontext
from pathlib import Path
from typing import Any, Protocol, TypeVar

from benchmarks.hidden.sealed import remembering
from ema_tools.base.files import write_text
from ema_tools.base.one_thread import ONE_THREAD
from ema_tools.words.terminal.console import output, progress

Row = dict[str, Any]


class Job(Protocol):
    """One trial: its name, and that of the file of its group, whose trials share what is known of a machine."""

    @property
    def key(self) -> str:
        """By which an interrupted run is taken up again."""
        ...

    @property
    def group(self) -> str:
        """File of its rows, without the ending."""
        ...


AJob = TypeVar("AJob", bound=Job)
_LOOK_S = 2.0
_PARTS = "parts"


def read_rows(folder: Path) -> list[Row]:
    """Rows of all parts; a line that an interruption cut short is left out."""
    rows: dict[str, Row] = {}
    for part in sorted((folder / _PARTS).glob("*.jsonl")):
        for line in part.read_text(encoding="utf-8").splitlines():
            try:
                row = json.loads(line)
            except json.JSONDecodeError:
                continue
            rows[row["key"]] = row
    return list(rows.values())


def _one_core(cores: Sequence[int]) -> None:
    """A worker keeps to one core, so that its threads do not take the others' time."""
    if hasattr(os, "sched_setaffinity"):
        place = multiprocessing.current_process()._identity[-1]  # workers of a pool have no other number
        os.sched_setaffinity(0, {cores[place % len(cores)]})


def _work(trials: Sequence[AJob], part: Path, work: Callable[[AJob], Row], remember: bool = True) -> int:
    cut_short = part.exists() and not part.read_bytes().endswith(b"\n")
    with part.open("a", encoding="utf-8") as file, remembering() if remember else nullcontext():
        if cut_short:
            file.write("\n")
        for trial in trials:
            file.write(json.dumps(work(trial)) + "\n")
            file.flush()
    return len(trials)


def groups(trials: Sequence[AJob]) -> list[list[AJob]]:
    """Trials of one group together, so that what is known of the machine is computed once; longest first."""
    found: dict[str, list[AJob]] = {}
    for trial in trials:
        found.setdefault(trial.group, []).append(trial)
    return sorted(found.values(), key=len, reverse=True)


def run(trials: Sequence[AJob], folder: Path, workers: int, work: Callable[[AJob], Row], remember: bool = True) -> list[Row]:
    """Rows of all trials, those of an earlier run in the same folder among them. `workers` 0 works in this process; `remember`: see `sealed.remembering`."""
    parts = folder / _PARTS
    parts.mkdir(parents=True, exist_ok=True)
    done = {row["key"] for row in read_rows(folder)}
    wanted = [trial for trial in trials if trial.key not in done]
    tasks = [(group, parts / f"{group[0].group}.jsonl") for group in groups(wanted)]
    with progress("trials", len(wanted)) as bar:
        if workers == 0:
            finished = 0
            for group, part in tasks:
                for trial in group:
                    _work([trial], part, work, remember)
                    finished += 1
                    bar.update(finished)
        elif tasks:
            _in_processes(tasks, workers, work, remember, lambda: bar.update(len(read_rows(folder)) - len(done)))
    keys = {trial.key for trial in trials}
    return [row for row in read_rows(folder) if row["key"] in keys]


def _in_processes(
    tasks: Sequence[tuple[list[AJob], Path]], workers: int, work: Callable[[AJob], Row], remember: bool, look: Callable[[], None]
) -> None:
    cores = sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else list(range(workers))
    # numerical libraries read these when a worker loads them
    os.environ |= ONE_THREAD
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=context, initializer=_one_core, initargs=(cores,)) as pool:
        open_tasks: set[Future[int]] = {pool.submit(_work, group, part, work, remember) for group, part in tasks}
        while open_tasks:
            finished, open_tasks = wait(open_tasks, timeout=_LOOK_S, return_when=FIRST_COMPLETED)
            look()
            for task in finished:
                if task.exception() is not None:
                    pool.shutdown(wait=False, cancel_futures=True)
                task.result()


def told(text: str, heading: str, what: str, begun: float, document: Path | None) -> None:
    """A document from its first telling heading on, and how much was done in which time; written where one is asked for."""
    console = output()
    console.print(text[text.index(heading) :], markup=False)
    console.print(f"{what}, {elapsed(begun)}")
    if document is not None:
        write_text(document, text, force=True)
        console.print(str(document))


def elapsed(begun: float) -> str:
    """Minutes and seconds since."""
    seconds = time.monotonic() - begun
    return f"{int(seconds // 60)} min {seconds % 60:.0f} s"
