"""A fleet's recordings judged, each once: on this machine's cores or on a cluster, where the workers read the recordings themselves and write their results as they come."""

from __future__ import annotations

import contextlib
import hashlib
import itertools
import math
import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, ProcessPoolExecutor, wait
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ema_tools import __version__
from ema_tools.base.errors import InputError, LibraryError
from ema_tools.base.files import readable, reason
from ema_tools.data.actuator import Actuator, read_actuator
from ema_tools.data.machine_state import BaselineRecords
from ema_tools.data.manifest import Entry
from ema_tools.data.motion_records import same_samples
from ema_tools.data.records import Record, read_record
from ema_tools.plant.native import IdentifiedValue
from ema_tools.results.store import FleetRow, key_of, keys, write_part
from ema_tools.tasks.calibrate import calibrate
from ema_tools.tasks.identify import Identified, identify
from ema_tools.tasks.onboard_search import KEYS
from ema_tools.tasks.own_machine import own_machine

if TYPE_CHECKING:
    from distributed import Client

_BATCH = 16  # recordings of one unit that a worker judges at once and writes as one part [layout]
_JUDGED_AS = 1  # rises when the same recording is to be judged anew, and not with every version of the tools [layout]
_AHEAD = 4  # batches that wait for each worker: what is sent is a list of paths, and memory does not grow with the fleet [layout]
RESULTS, UNITS = "results", "units"
_KILLED = "every worker that judged it was killed: look at it alone with ema identify, and at the memory of the machine"
_TRIES = 3  # times that a batch whose worker was killed is judged again by itself [layout]
_LEAST_RUNS = 2  # healthy runs of one command that show a unit itself [chance]


@dataclass(frozen=True)
class Batch:
    """Recordings of one unit, its healthy runs, and what its model is named after; all that a worker is told."""

    unit: str
    actuator: str
    healthy: tuple[str, ...]
    model: str  # file of the unit's own model
    entries: tuple[Entry, ...]
    keys: tuple[str, ...]
    results: str
    guarded: bool
    refused: str = ""  # why none of the unit's recordings can be judged

    def alone(self) -> list[Batch]:
        """One batch for each of its recordings."""
        return [replace(self, entries=(entry,), keys=(key,)) for entry, key in zip(self.entries, self.keys, strict=True)]


def planned(entries: Sequence[Entry], folder: Path, guarded: bool) -> tuple[list[Batch], dict[tuple[str, str], str]]:
    """What is left to do of a fleet, unit by unit, and the keys of all of it by unit and file, done or not. Raises InputError for a store that cannot be read."""
    done = keys(folder / RESULTS)
    batches: list[Batch] = []
    wanted: dict[tuple[str, str], str] = {}
    for unit, group in itertools.groupby(entries, lambda one: one.unit):
        own = tuple(group)
        runs = tuple(str(one.file) for one in own if one.kind == "healthy")
        actuators = {one.actuator for one in own}
        actuator = min(actuators)
        refused = ""
        if len(actuators) > 1:
            # no answer of either would be of the unit; the other units have nothing to do with it
            refused = f"{unit}: {' and '.join(sorted(one.name for one in actuators)[:2])}: a unit has one actuator file: name the same one in its rows"
        base = key_of(str(_JUDGED_AS), str(guarded), unit, _content(actuator), *map(_stamp, runs), *([refused] if refused else []))
        model = folder / UNITS / f"{_name(unit)}-{base[:8]}.toml"
        named = [(one, key_of(base, str(one.file), _stamp(str(one.file)))) for one in own]
        wanted |= {(unit, str(one.file)): key for one, key in named}
        left = [(one, key) for one, key in named if key not in done]
        for start in range(0, len(left), _BATCH):
            part = left[start : start + _BATCH]
            shown = tuple(one for one, _ in part)
            batches.append(
                Batch(unit, str(actuator), runs, str(model), shown, tuple(key for _, key in part), str(folder / RESULTS), guarded, refused)
            )
    return batches, wanted


def run_fleet(
    batches: Iterable[Batch], scheduler: str | None = None, workers: int | None = None, done: Callable[[int, int], None] | None = None
) -> tuple[int, int]:
    """Judge what is planned; returns how many recordings were judged, and how many of them are bad.

    `scheduler`: the address of a Dask cluster that sees the same folders; without one, processes of this machine, `workers` of them or one per core. `done` is called
    after every batch with the numbers of good and bad recordings. Raises InputError if the scheduler does not answer or Dask is not installed.
    """
    good = bad = 0
    judged = _on_cluster(batches, scheduler) if scheduler else _on_this_machine(batches, workers or len(os.sched_getaffinity(0)))
    with contextlib.closing(judged):
        for batch_good, batch_bad in judged:
            good, bad = good + batch_good, bad + batch_bad
            if done is not None:
                done(good, bad)
    return good + bad, bad


def _on_this_machine(batches: Iterable[Batch], workers: int) -> Generator[tuple[int, int], None, None]:
    """Good and bad recordings of each batch, judged by processes of this machine. After a worker was killed, each batch at work then is judged by itself."""
    ahead = _AHEAD * workers
    left = firsts_first(batches, ahead)
    while first := list(itertools.islice(left, ahead)):
        lost: list[Batch] = []
        with _processes(workers) as pool:
            at_work = {pool.submit(judge, batch): batch for batch in first}
            while at_work:
                finished, _ = wait(at_work, return_when=FIRST_COMPLETED)
                for future in finished:
                    batch = at_work.pop(future)
                    if isinstance(future.exception(), BrokenExecutor):
                        lost.append(batch)
                    else:
                        yield future.result()
                for batch in itertools.islice(left, 0 if lost else ahead - len(at_work)):
                    try:
                        at_work[pool.submit(judge, batch)] = batch
                    except BrokenExecutor:
                        lost.append(batch)
        for batch in lost:
            yield from _by_itself(batch)


def _by_itself(batch: Batch) -> Iterator[tuple[int, int]]:
    """Good and bad recordings of a batch judged in a process of its own; recording by recording if that is killed, and the one that its process does not survive is bad."""
    for _ in range(_TRIES):
        with _processes(1) as pool:
            future = pool.submit(judge, batch)
            if not isinstance(future.exception(), BrokenExecutor):
                yield future.result()
                return
    if len(batch.entries) == 1:
        yield _killed(batch)
    else:
        for alone in batch.alone():
            yield from _by_itself(alone)


@contextlib.contextmanager
def _processes(workers: int) -> Iterator[ProcessPoolExecutor]:
    pool = ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"), _begin_worker)
    try:
        yield pool
    finally:
        pool.shutdown(cancel_futures=True)


def _begin_worker() -> None:
    """Ctrl-C ends a worker without a traceback, and no worker outlives the process that began it."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _killed(batch: Batch) -> tuple[int, int]:
    """The one recording of the batch is bad, since its worker is killed each time."""
    write_part(Path(batch.results), [replace(_row(batch, 0), status="bad", reason=f"{batch.entries[0].file}: {_KILLED}")])
    return 0, 1


def _on_cluster(batches: Iterable[Batch], scheduler: str) -> Generator[tuple[int, int], None, None]:
    """Good and bad recordings of each batch, judged by the workers of a Dask cluster. Raises InputError."""
    with _client(scheduler) as client:
        from distributed import KilledWorker, as_completed

        ahead = _AHEAD * max(1, len(client.scheduler_info()["workers"]))
        left = firsts_first(batches, ahead)
        at_work = {}
        following = as_completed()

        def begin(batch: Batch) -> None:
            future = client.submit(judge, batch, pure=False)
            at_work[future.key] = batch
            following.add(future)

        for batch in itertools.islice(left, ahead):
            begin(batch)
        for future in following:
            batch = at_work.pop(future.key)
            try:
                yield future.result()
            except KilledWorker:
                if len(batch.entries) > 1:
                    # one of them takes its worker with it: by itself it is known, and the others are judged
                    for alone in batch.alone():
                        begin(alone)
                    continue
                yield _killed(batch)
            for further in itertools.islice(left, 1):
                begin(further)


def firsts_first(batches: Iterable[Batch], units: int) -> Iterator[Batch]:
    """The batches of so many units after another, the first of each before the others of any: it makes the unit's model, and two at work side by side would both make it."""
    groups = itertools.groupby(batches, lambda one: one.unit)
    while window := [list(group) for _, group in itertools.islice(groups, units)]:
        yield from (own[0] for own in window)
        yield from itertools.chain.from_iterable(own[1:] for own in window)


@contextlib.contextmanager
def _client(scheduler: str) -> Iterator[Client]:
    try:
        from distributed import Client
    except ImportError:
        raise InputError(f"--scheduler needs Dask, which is not installed: {_how_to_install()}, or leave --scheduler out") from None

    try:
        client = Client(scheduler, timeout=10)
    except (OSError, ValueError) as error:
        raise InputError(
            f"--scheduler {scheduler}: no cluster answers there ({error}): start one by dask scheduler, or leave it out"
        ) from None
    with client:
        yield client


def _how_to_install() -> str:
    """What installs Dask for this Python: a target of the build folder that its environment lies in, else pip."""
    environment = Path(sys.prefix)
    if (environment / "run.stamp").is_file():
        return f"run cmake --build {environment.parent} --target venv_fleet"
    return f"run {sys.executable} -m pip install dask distributed"


def judge(batch: Batch) -> tuple[int, int]:
    """One batch: its rows stand in the store afterwards. How many recordings could be judged, and how many not."""
    rows = list(_rows(batch))
    write_part(Path(batch.results), rows)
    bad = sum(row.status == "bad" for row in rows)
    return len(rows) - bad, bad


def _rows(batch: Batch) -> Iterator[FleetRow]:
    why = ""
    try:
        if batch.refused:
            raise InputError(batch.refused)
        model: Actuator | None = unit_model(batch)
        runs = [read_record(path, model) for path in batch.healthy] if batch.guarded else []
    except (InputError, LibraryError) as error:
        model, runs, why = None, [], str(error)
    for place, entry in enumerate(batch.entries):
        row = _row(batch, place)
        try:
            if model is None:
                raise InputError(why)
            yield _judged(row, entry, model, runs)
        except (InputError, LibraryError) as error:
            yield replace(row, status="bad", reason=readable(str(error)))


def _row(batch: Batch, place: int) -> FleetRow:
    """The row of one recording before it is judged."""
    entry = batch.entries[place]
    return FleetRow(batch.keys[place], batch.unit, entry.date, str(entry.file), entry.kind, batch.actuator, software=__version__)


def unit_model(batch: Batch) -> Actuator:
    """The unit's own model: as its file is where that was calibrated, or too few healthy runs show it; else calibrated on them, once. Raises InputError."""
    kept = Path(batch.model)
    if kept.is_file():
        return read_actuator(kept)
    model = read_actuator(batch.actuator)
    if model.healthy or len(batch.healthy) < _LEAST_RUNS:
        return model
    runs = [read_record(path, model) for path in batch.healthy]
    own = own_machine(calibrate(model, runs).actuator, runs)
    if own is None:
        return model
    found = replace(
        own.actuator.changed({}), baseline=BaselineRecords.of([replace(run, path=str(Path(run.path).resolve())) for run in runs])
    )
    begun = kept.with_name(f".{kept.name}.{os.getpid()}")
    kept.parent.mkdir(parents=True, exist_ok=True)
    found.write(begun, force=True)
    os.replace(begun, kept)
    return read_actuator(kept)


def _judged(row: FleetRow, entry: Entry, model: Actuator, runs: Sequence[Record]) -> FleetRow:
    record = read_record(entry.file, model)
    others = [one for one in runs if not same_samples(one, record)]
    found = identify(model, record, others, guarding=bool(runs))
    checked = found.checked
    effect = checked.effects[0] if checked is not None and found.objection == "missing" and checked.effects else None
    told: dict[str, Any] = {}
    for one in found.answer.identified:
        told |= _value(found, one)
    return replace(
        row,
        **told,
        sha256=hashlib.sha256(entry.file.read_bytes()).hexdigest(),
        verdict=found.verdict,
        reasons="; ".join(found.answer.reasons),
        adequate=found.adequate,
        residual_rms_mm=found.answer.residual_rms_mm,
        effect=effect,
        evaluations=found.answer.evaluations,
        wall_s=found.wall_s,
    )


def _value(found: Identified, one: IdentifiedValue) -> dict[str, Any]:
    """The columns of one identified value."""
    name, _, unit = KEYS[one.name].partition("_")
    healthy = found.healthy[one.name]
    ends = [100.0 * (end / healthy - 1.0) if end is not None and math.isfinite(end) and healthy else None for end in found.interval95(one)]
    return {
        KEYS[one.name]: one.estimate,
        f"{name}_healthy_{unit}": healthy,
        f"{name}_shift_percent": one.shift_percent,
        f"{name}_low_percent": ends[0],
        f"{name}_high_percent": ends[1],
    }


def _content(path: Path) -> str:
    """What a file holds, in short; of one that cannot be read, that: the worker says why."""
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError as error:
        return reason(error)


def _stamp(path: str) -> str:
    """Size and time of a recording, by which another one is known without reading it."""
    try:
        state = os.stat(path)
    except OSError as error:
        return reason(error)
    return f"{state.st_size} {state.st_mtime_ns}"


def _name(unit: str) -> str:
    """The unit's name as a file's."""
    return "".join(one if one.isalnum() or one in "-_." else "_" for one in unit).strip(".") or "unit"
