"""The constants halved and doubled: what becomes of the answers of a small set of cases. Rows are kept as they come; what is there is not done again."""

from __future__ import annotations

import ast
import hashlib
import json
import os
import queue
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from benchmarks.constants.listing import PACKAGE, Constant
from benchmarks.constants.replay import ARGUMENTS, Job
from ema_tools.base.errors import InputError
from ema_tools.base.files import write_json
from ema_tools.base.one_thread import ONE_THREAD

FACTORS = (0.5, 2.0)
# One case of each way through the diagnosis, near the limits rather than far from them: a large effect is named with any constant.
CASES = (
    "repeats presliding medium",
    "repeats pitch_ripple medium holdout=True",
    "repeats quadratic_viscous small",
    "repeats csj large",
    "repeats healthy  machine=1 command=chirp",
    "position cogging_torque medium",
    "alone stribeck_friction large",
    "alone winding_heating large",
    "alone healthy  machine=601 command=chirp",
    "pair cogging_torque+feedback_delay large machine=2",
    "outside speed_hump large",
    "exchanged columns",
    "emps",
)
ROOT = Path(__file__).resolve().parents[2]  # where this package is imported from
# Constants that are changed together first: most move nothing, and where nothing moved each of them is done.
TOGETHER = 8
# A case is given up at so many times its usual seconds, and not before the least.
_PATIENCE, _PATIENCE_LEAST_S = 10.0, 120.0
_SHOWN_ERROR = 5e-4  # a smaller change of the error that is left is not told
# What lies outside: it reads no constant of the diagnosis, or is not part of an answer.
_APART = ("words",)


@dataclass
class Swept:
    """What was measured, as the file holds it. `cases`: by name the plain outline, seconds and the keys read; `rows`: by key the text of its value and, by factor, by case the answer."""

    sources: str
    cases: dict[str, dict[str, Any]] = field(default_factory=dict)
    rows: dict[str, dict[str, Any]] = field(default_factory=dict)

    def reached(self, key: str) -> tuple[str, ...]:
        """Cases in which a constant is read, as far as that is known: what a class holds, or what was read while a module was imported, may be used in any."""
        return tuple(
            name for name, one in self.cases.items() if "." in key.partition(":")[2] or key in one["read"] or key in one["imported"]
        )

    @property
    def count(self) -> int:
        """Answers that the rows hold."""
        return sum(len(answers) for row in self.rows.values() for answers in row.values() if isinstance(answers, dict))

    def answers(self, one: Constant, factor: float) -> dict[str, Any]:
        """Answers by case with a constant times a factor; of another value of it none."""
        row = self.rows.get(one.key, {})
        return dict(row.get(str(factor), {})) if row.get("value") == one.text else {}

    def keep(self, one: Constant, factor: float, case: str, answer: Mapping[str, Any]) -> None:
        """One more answer."""
        row = self.rows.setdefault(one.key, {"value": one.text})
        if row["value"] != one.text:
            row.clear()
            row["value"] = one.text
        row.setdefault(str(factor), {})[case] = dict(answer)


def sources_of(package: Path = PACKAGE) -> str:
    """A number that changes with what the package does, not with its comments."""
    found = hashlib.sha256()
    for path in sorted(package.rglob("*.py")):
        if path.relative_to(package).parts[0] not in _APART:
            found.update(ast.dump(ast.parse(path.read_text(encoding="utf-8"))).encode())
    return found.hexdigest()[:16]


def _of_file(path: Path) -> Swept:
    return Swept(**json.loads(path.read_text(encoding="utf-8"))) if path.exists() else Swept(sources_of())


def read_swept(path: Path) -> Swept:
    """The file's rows, none where it is absent. Raises InputError where it was made with other sources."""
    found = _of_file(path)
    if found.sources != sources_of():
        raise InputError(f"{path}: measured with other sources than today's: --sweep looks which of its rows still hold, and goes on")
    return found


def renewed(before: Swept, cases: Mapping[str, dict[str, Any]]) -> Swept:
    """Rows of an earlier state of the sources beside today's plain answers `cases`: they hold for the cases whose plain answer is what it was."""
    same = {name for name, one in cases.items() if name in before.cases and _same(before.cases[name]["outline"], one["outline"])}
    found = Swept(sources_of(), dict(cases))
    for key, row in before.rows.items():
        kept = {factor: {name: one for name, one in row.get(factor, {}).items() if name in same} for factor in map(str, FACTORS)}
        if any(kept.values()):
            found.rows[key] = {"value": row["value"], **{factor: one for factor, one in kept.items() if one}}
    return found


def _same(one: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    """Whether two outlines say the same, to what the table shows of the error."""
    if any(one[name] != other[name] for name in ("verdict", "first", "accepted")):
        return False
    if not one["error"] or not other["error"]:
        return bool(one["error"] == other["error"])
    return bool(abs(one["error"] / other["error"] - 1.0) < _SHOWN_ERROR)


def write_swept(path: Path, swept: Swept) -> None:
    """Into another file first: a sweep that is ended while it writes leaves the last one."""
    write_json(path, swept.__dict__, force=True)


def recorded(names: Sequence[str], records: Path, told: Callable[[str], None]) -> dict[str, str]:
    """Folders of the cases by name, those that are absent made; a case whose files cannot be had is left out and told."""
    from benchmarks import frozen

    by_name = {case.name: case for case in frozen.CASES}
    found = {}
    for name in names:
        folder = records / "".join(letter if letter.isalnum() else "_" for letter in name)
        if not (folder / ARGUMENTS).is_file():
            folder.mkdir(parents=True, exist_ok=True)
            arguments = frozen.made(by_name[name], folder)
            if arguments is None:
                told(f"{name}: left out: point EMA_EMPS at DATA_EMPS.mat")
                continue
            # last, so that a folder that has it is whole
            (folder / ARGUMENTS).write_text(json.dumps(arguments), encoding="utf-8")
        found[name] = str(folder.resolve())
    return found


class Ended:
    """Whether the sweep is being ended, and the processes that are to end with it."""

    def __init__(self) -> None:
        self._asked = threading.Event()
        self._processes: set[subprocess.Popen[str]] = set()

    def __bool__(self) -> bool:
        return self._asked.is_set()

    def begun(self, process: subprocess.Popen[str]) -> None:
        """One more process."""
        self._processes.add(process)
        if self:
            process.kill()

    def end(self) -> None:
        """Ends them all."""
        self._asked.set()
        for process in list(self._processes):
            process.kill()


def run(job: Job, seconds: Mapping[str, float], keep: Callable[[dict[str, Any]], None], ended: Ended) -> None:
    """One process replays the cases of a job; a case that ends it, or takes far longer than its usual `seconds`, is kept as broken, and another process goes on."""
    left = dict(job.folders)
    while left and not ended:
        now = Job(left, job.keys, job.factor, job.core)
        process = subprocess.Popen(
            [sys.executable, "-m", "benchmarks.constants.replay"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            cwd=ROOT,
            env=os.environ | ONE_THREAD,
            # a Ctrl-C reaches this process alone, which ends the others: a case that it cut off would count as broken
            start_new_session=True,
        )
        ended.begun(process)
        assert process.stdin is not None and process.stdout is not None
        process.stdin.write(now.text())
        process.stdin.close()
        late = threading.Event()
        watch = _watched(process, seconds.get(next(iter(left)), 0.0), late)
        for line in process.stdout:
            watch.cancel()
            row = json.loads(line)
            left.pop(row["case"])
            keep(row)
            watch = _watched(process, seconds.get(next(iter(left), ""), 0.0), late)
        process.wait()
        watch.cancel()
        if left and not ended:
            case = next(iter(left))
            left.pop(case)
            keep({"case": case, "broken": "took far longer than usual" if late.is_set() else f"ended by exit code {process.returncode}"})


def _watched(process: subprocess.Popen[str], seconds: float, late: threading.Event) -> threading.Timer:
    def end() -> None:
        late.set()
        process.kill()

    timer = threading.Timer(max(_PATIENCE_LEAST_S, _PATIENCE * seconds), end)
    timer.daemon = True
    timer.start()
    return timer


def sweep(chosen: Sequence[Constant], names: Sequence[str], path: Path, records: Path, workers: int, told: Callable[[str], None]) -> Swept:
    """Replays the cases that read each of the chosen constants, with it halved and doubled, one process on each of so many cores; `told` hears how it goes, line by line.

    Constants are changed several at once; where an answer moved, the group is halved until it is known which of them moved it.
    """
    before = _of_file(path)
    swept = before if before.sources == sources_of() else Swept(sources_of())
    folders = recorded(list(names) if swept is before else sorted({*names, *before.cases}), records, told)
    cores: queue.Queue[int | None] = queue.Queue()
    usable: list[int | None] = list(sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else [None] * workers)
    for place in range(workers):
        cores.put(usable[place % len(usable)])
    lock = threading.Lock()
    ended = Ended()

    def on_a_core(work: Callable[[int | None], None]) -> None:
        core = cores.get()
        try:
            work(core)
        finally:
            cores.put(core)

    def plain(name: str) -> None:
        def keep(row: dict[str, Any]) -> None:
            if "broken" in row:
                raise InputError(f"{name}: {row['broken']}: run it by python -m benchmarks.frozen --only and mend that first")
            with lock:
                swept.cases[row.pop("case")] = row
                # what an earlier state measured stays in the file until it is known what of it holds
                if swept is before:
                    write_swept(path, swept)
            told(f"{name}: {row['seconds']:.1f} s, reads {len(row['read'])} constants")

        on_a_core(lambda core: run(Job({name: folders[name]}, core=core), {}, keep, ended))

    def changed(group: Sequence[Constant], factor: float, wanted: Mapping[str, str]) -> None:
        moving: dict[str, str] = {}

        def keep(row: dict[str, Any]) -> None:
            case = row.pop("case")
            unchanged = row.pop("unchanged", [])
            if len(group) > 1 and ("broken" in row or not _same(swept.cases[case]["outline"], row["outline"])):
                moving[case] = wanted[case]
                return
            with lock:
                for one in group:
                    swept.keep(one, factor, case, {**row, "same": one.key in unchanged, "together": len(group)})
                write_swept(path, swept)

        begun = time.perf_counter()
        usual = {name: swept.cases[name]["seconds"] for name in wanted}
        on_a_core(lambda core: run(Job(dict(wanted), tuple(one.key for one in group), factor, core), usual, keep, ended))
        seconds = time.perf_counter() - begun
        if not ended:
            for one in group:
                if len(group) == 1 or not moving:
                    told(f"{one.key} x {factor:g}: {words(moved(swept, one, factor))} ({seconds / len(group):.0f} s)")
            if moving:
                half = len(group) // 2
                changed(group[:half], factor, moving)
                changed(group[half:], factor, moving)

    def groups(factor: float) -> Iterator[tuple[tuple[Constant, ...], dict[str, str]]]:
        by_cases: dict[tuple[str, ...], list[Constant]] = {}
        for one in chosen:
            done = swept.answers(one, factor)
            open_cases = tuple(name for name in swept.reached(one.key) if name in names and name in folders and name not in done)
            if open_cases:
                by_cases.setdefault(open_cases, []).append(one)
        for open_cases, members in by_cases.items():
            for place in range(0, len(members), TOGETHER):
                yield tuple(members[place : place + TOGETHER]), {name: folders[name] for name in open_cases}

    with ThreadPoolExecutor(workers) as pool:
        _all((pool.submit(plain, name) for name in folders if name not in swept.cases), ended)
        if swept is not before:
            swept.rows = renewed(before, swept.cases).rows
            told(f"the sources have changed: {swept.count} of {before.count} answers still hold")
            write_swept(path, swept)
        _all((pool.submit(changed, group, factor, wanted) for factor in FACTORS for group, wanted in groups(factor)), ended)
    return swept


def _all(futures: Iterable[Future[None]], ended: Ended) -> None:
    waiting = list(futures)
    try:
        for future in waiting:
            future.result()
    except BaseException:
        for future in waiting:
            future.cancel()
        ended.end()
        raise


@dataclass(frozen=True)
class Moved:
    """How far the answers of so many `cases` moved: how many verdicts, first names and accepted sets changed, how many calls broke, and the largest change of the error that is left, as a share."""

    cases: int
    verdicts: int
    firsts: int
    sets: int
    broken: int
    error: float
    same: bool


def moved(swept: Swept, one: Constant, factor: float) -> Moved:
    """Against the plain answers."""
    answers = swept.answers(one, factor)
    verdicts = firsts = sets = broken = 0
    error = 0.0
    for case, answer in answers.items():
        if "broken" in answer:
            broken += 1
            continue
        before, after = swept.cases[case]["outline"], answer["outline"]
        verdicts += before["verdict"] != after["verdict"]
        firsts += before["first"] != after["first"]
        sets += before["accepted"] != after["accepted"]
        if before["error"] and after["error"]:
            error = max(error, abs(after["error"] / before["error"] - 1.0))
    return Moved(len(answers), verdicts, firsts, sets, broken, error, all(answer.get("same", False) for answer in answers.values()))


def words(found: Moved) -> str:
    """The same as a reader of the table takes it."""
    if not found.cases:
        return "not swept"
    if found.same:
        return "stays what it is"
    parts = [
        f"{count} {title if count == 1 else more}"
        for count, title, more in (
            (found.verdicts, "verdict", "verdicts"),
            (found.firsts, "first name", "first names"),
            (found.sets, "accepted set", "accepted sets"),
            (found.broken, "broken", "broken"),
        )
        if count
    ]
    if found.error >= _SHOWN_ERROR:
        parts.append(f"error {100.0 * found.error:.2g} %")
    return f"{', '.join(parts) or 'nothing'} of {found.cases}"
