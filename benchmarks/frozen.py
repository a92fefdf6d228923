"""Answers of `ema diagnose` that were frozen, and the comparison with those of today: a move of the code changes none of them.

    python -m benchmarks.frozen                    # every answer anew, compared with the frozen ones
    python -m benchmarks.frozen --only repeats     # those whose name has this in it
    python -m benchmarks.frozen --write            # today's answers become the frozen ones

Each case is a call of the command as a user types it, in a folder with its files; what it wrote with --json, less the curves and where it came from, or the line of its error,
is the answer. Records come from the truth plant's machines, the shipped recordings and, where it is given by EMA_EMPS, the measured axis EMPS.
"""

from __future__ import annotations

import argparse
import contextlib
import gzip
import io
import json
import math
import multiprocessing
import os
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ema_tools.base.one_thread import ONE_THREAD
from ema_tools.words.terminal.console import progress

_ROOT = Path(__file__).resolve().parents[1]
FROZEN = _ROOT / "tools" / "tests" / "frozen" / "diagnose.json.gz"
# What differs from one machine to another, or repeats the records.
_LEFT_OUT = ("provenance", "next", "curves", "workbench", "format")
# Another processor rounds sums in another order; a search that goes the same way then ends this near.
_NEAR = 1e-4
_LONG = 24
_SHOWN = 5
_MEDIUM, _LARGE, _SMALL = "medium", "large", "small"


@dataclass(frozen=True)
class FrozenCase:
    """One call. `hidden`: effects in the truth plant's machine; `repeats`: healthy records given; `signals`: those left in the files, none for all;
    `holdout`: a record of another command is held out; `files`: for a case of shipped or measured files, the actuator and the options."""

    name: str
    hidden: tuple[str, ...] = ()
    severity: str = ""
    machine: int = 1
    command: str = "chirp"
    repeats: int = 5
    signals: tuple[str, ...] = ()
    holdout: bool = False
    files: tuple[str, ...] = ()
    change: str = ""


def _cases() -> Iterator[FrozenCase]:
    def named(kind: str, hidden: Sequence[str], severity: str, **more: Any) -> FrozenCase:
        told = (f"{name}={value}" for name, value in more.items() if name in ("machine", "command", "holdout"))
        return FrozenCase(" ".join((kind, "+".join(hidden) or "healthy", severity, *told)), tuple(hidden), severity, **more)

    for effect in ("stribeck_friction", "presliding", "cogging_torque", "torque_ripple", "inverter_dead_time", "transmission_compliance"):
        yield named("repeats", (effect,), _MEDIUM)
    for effect in ("feedback_delay", "jam_spot", "load_dependent_friction", "current_limit", "constant_load", "winding_heating"):
        yield named("repeats", (effect,), _MEDIUM, machine=2)
    for effect in ("gain_drift", "pitch_ripple", "spring_load"):
        yield named("repeats", (effect,), _MEDIUM, holdout=True)
    for effect in ("viscous_rise", "supply_sag", "sensor_gain"):
        yield named("repeats", (effect,), _LARGE, command="multisine")
    for effect in ("actuation_delay", "quadratic_viscous", "magnet_weakening"):
        yield named("repeats", (effect,), _SMALL)
    for effect in ("csj", "blk"):
        yield named("repeats", (effect,), _LARGE)
    for effect in (
        "stribeck_friction",
        "cogging_torque",
        "inverter_dead_time",
        "source_resistance",
        "presliding",
        "winding_heating",
        "jam_spot",
    ):
        yield named("alone", (effect,), _LARGE, repeats=0)
    for effect in ("stribeck_friction", "pitch_ripple"):
        yield named("alone", (effect,), _LARGE, repeats=0, machine=2, holdout=True)
    for effect in ("stribeck_friction", "cogging_torque", "presliding", "torque_ripple", "viscous_rise"):
        yield named("position", (effect,), _MEDIUM, signals=("position_mm",))
    yield named("position alone", ("stribeck_friction",), _LARGE, repeats=0, signals=("position_mm",))
    yield named("three signals", ("presliding",), _MEDIUM, signals=("position_mm", "motor_position_mm", "current_A"))
    pairs = (
        ("stribeck_friction", "winding_heating"),
        ("presliding", "spring_load"),
        ("cogging_torque", "feedback_delay"),
        ("csj", "stribeck_friction"),
        ("blk", "transmission_compliance"),
    )
    for pair in pairs:
        yield named("pair", pair, _LARGE, machine=2)
    for effect in ("broken_ball", "speed_hump", "command_dead_band", "bus_hum", "lead_error"):
        yield named("outside", (effect,), _LARGE)
    for number, command in ((1, "chirp"), (2, "chirp"), (3, "fast chirp"), (4, "triangle"), (5, "slow chirp")):
        yield named("repeats", (), "", machine=number, command=command)
    for number, command in ((601, "chirp"), (602, "multisine"), (603, "triangle")):
        yield named("alone", (), "", repeats=0, machine=number, command=command)
    yield FrozenCase("exchanged columns", ("stribeck_friction",), _MEDIUM, change="exchange")
    yield FrozenCase("a row that is no number", (), "", change="nan", repeats=0)
    yield FrozenCase("healthy of another command", (), "", change="command", repeats=2)
    story = [f"--healthy=story/healthy_{k}.csv" for k in range(1, 6)]
    yield FrozenCase("story", files=("reference.toml", "story/today.csv", *story))
    yield FrozenCase("story held out", files=("reference.toml", "story/today.csv", *story, "--holdout=story/today_multisine.csv"))
    yield FrozenCase("story as shipped", files=("reference.toml", "case_a_noisy.csv"))
    yield FrozenCase("emps", files=("emps",))


CASES: tuple[FrozenCase, ...] = tuple(_cases())


def _exchanged(table: dict[str, Any]) -> None:
    table["current_A"], table["voltage_V"] = table["voltage_V"], table["current_A"]


def _no_number(table: dict[str, Any]) -> None:
    table["position_mm"] = table["position_mm"].copy()
    table["position_mm"][4_321] = math.nan


_CHANGES: Mapping[str, Callable[[dict[str, Any]], None]] = {"exchange": _exchanged, "nan": _no_number}


def _write(path: Path, run: Any, signals: Sequence[str], change: str = "") -> None:
    """A recording as a logger writes it."""
    names = signals or ("position_mm", "motor_position_mm", "current_A", "voltage_V")
    table = {"time_s": run.time_s, "command_mm": run.command_mm, **{name: getattr(run, name) for name in names}}
    if change in _CHANGES:
        _CHANGES[change](table)
    rows = zip(*(column.tolist() for column in table.values()), strict=True)
    path.write_text("\n".join([",".join(table), *(",".join(f"{value:.9g}" for value in row) for row in rows)]) + "\n", encoding="utf-8")


def made(case: FrozenCase, folder: Path) -> list[str] | None:
    """The arguments of `ema diagnose` for a case, its files in the folder; None where what it needs is absent."""
    if case.files == ("emps",):
        return _emps(folder)
    if case.files:
        for name in ("story", "case_a_noisy.csv"):
            source = _ROOT / "recordings" / name
            (shutil.copytree if source.is_dir() else shutil.copy)(source, folder / name)
        shutil.copy(_ROOT / "actuators" / "reference.toml", folder)
        return list(case.files)
    from benchmarks.hidden.catalogue import SEVERITIES, change
    from benchmarks.hidden.machines import HELD_OUT, machine, measured, seed_of

    unit = machine(case.machine)
    shutil.copy(_ROOT / "actuators" / "reference.toml", folder)

    def run(command: str, day: str) -> Any:
        changes = [change(unit, effect, SEVERITIES[case.severity], command) for effect in case.hidden] if day == "today" else []
        values = {name: value for one in changes for name, value in one.values.items()}
        return measured(unit, values, command, seed_of("frozen", case.machine, case.hidden, command, day))

    arguments = ["reference.toml", "today.csv"]
    _write(folder / "today.csv", run(case.command, "today"), case.signals, case.change)
    for number in range(1, case.repeats + 1):
        command = HELD_OUT[case.command] if case.change == "command" else case.command
        _write(folder / f"healthy_{number}.csv", run(command, f"healthy {number}"), case.signals)
        arguments.append(f"--healthy=healthy_{number}.csv")
    if case.holdout:
        _write(folder / "other.csv", run(HELD_OUT[case.command], "today"), case.signals)
        arguments.append("--holdout=other.csv")
    return arguments


def _emps(folder: Path) -> list[str] | None:
    source = os.environ.get("EMA_EMPS")
    if not source:
        return None
    _called(["import", "emps", source, "-o", str(folder)])
    return ["actuator.toml", "record.csv"]


def _called(arguments: Sequence[str]) -> str:
    """Runs the command; the line of its error, empty where there is none."""
    from ema_tools.base.errors import InputError
    from ema_tools.cli import cli

    with contextlib.redirect_stdout(io.StringIO()):
        try:
            cli([*arguments], prog_name="ema", standalone_mode=False)
        except InputError as error:
            return str(error)
    return ""


def answered(case: FrozenCase) -> dict[str, Any] | None:
    """The answer of a case, None where its files are absent."""
    with tempfile.TemporaryDirectory() as name, contextlib.chdir(name):
        arguments = made(case, Path(name))
        return None if arguments is None else answer_to(arguments)


def answer_to(arguments: Sequence[str]) -> dict[str, Any]:
    """The answer of `ema diagnose` with these arguments, in the working folder, as it is frozen."""
    return {key: _short(value) for key, value in whole_answer_to(arguments).items() if key not in _LEFT_OUT}


def whole_answer_to(arguments: Sequence[str]) -> dict[str, Any]:
    """The same with all that it holds."""
    error = _called(["diagnose", *arguments, "--json", "answer.json"])
    if error:
        return {"error_line": error}
    result: dict[str, Any] = json.loads(Path("answer.json").read_text(encoding="utf-8"))
    return result


def _short(value: Any) -> Any:
    """The same with long lists, which only a picture needs, as three numbers that a change of one of them moves, and the words in them, each once."""
    if isinstance(value, dict):
        return {key: _short(one) for key, one in value.items()}
    if isinstance(value, list) and len(value) > _LONG:
        numbers = np.array([one for one in _leaves(value) if isinstance(one, (int, float))], dtype=float)
        found = {"count": len(numbers), "sum": float(numbers.sum()), "rms": float(np.sqrt(np.mean(numbers**2))) if numbers.size else 0.0}
        words = dict.fromkeys(one for one in _leaves(value) if isinstance(one, str))
        return {**found, "words": list(words)} if words else found
    return [_short(one) for one in value] if isinstance(value, list) else value


def _leaves(value: Any) -> Iterator[Any]:
    if isinstance(value, list):
        for one in value:
            yield from _leaves(one)
    elif isinstance(value, dict):
        for one in value.values():
            yield from _leaves(one)
    else:
        yield value


def differences(known: Any, today: Any, place: str = "", near: float = 0.0) -> Iterator[str]:
    """Where two answers differ, one line each; numbers may differ by the share `near` of the larger."""
    if isinstance(known, dict) and isinstance(today, dict):
        for key in [*known, *(key for key in today if key not in known)]:
            if key not in today or key not in known:
                yield f"{place}.{key}: {'gone' if key not in today else 'new'}"
            else:
                yield from differences(known[key], today[key], f"{place}.{key}", near)
    elif isinstance(known, list) and isinstance(today, list) and len(known) == len(today):
        for index, (one, other) in enumerate(zip(known, today, strict=True)):
            yield from differences(one, other, f"{place}[{index}]", near)
    elif type(known) in (int, float) and type(today) in (int, float):
        if known != today and not abs(known - today) <= near * max(abs(known), abs(today)):
            yield f"{place}: {known!r} was frozen, {today!r} today"
    elif known != today:
        yield f"{place}: {str(known)[:120]!r} was frozen, {str(today)[:120]!r} today"


def read_frozen(path: Path = FROZEN) -> dict[str, Any]:
    """The frozen answers by name of the case."""
    found: dict[str, Any] = json.loads(gzip.decompress(path.read_bytes()))
    return found


def _ready() -> None:
    os.environ |= ONE_THREAD


def main() -> int:
    """Entry point; 0 when every answer is the frozen one."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="only the cases whose name has this in it")
    parser.add_argument("--write", action="store_true", help="freeze today's answers")
    parser.add_argument("--near", type=float, default=0.0, help=f"share by which numbers may differ: on another machine {_NEAR:g}")
    parser.add_argument("--keep", type=Path, help="write today's answers there")
    parser.add_argument("--workers", type=int, default=2)
    arguments = parser.parse_args()
    cases = [case for case in CASES if arguments.only in case.name]
    _ready()
    today: dict[str, Any] = {}
    with progress("cases", len(cases)) as bar, ProcessPoolExecutor(arguments.workers, multiprocessing.get_context("spawn")) as pool:
        for case, answer in zip(cases, pool.map(answered, cases), strict=True):
            if answer is None:
                print(f"{case.name}: left out: point EMA_EMPS at DATA_EMPS.mat", file=sys.stderr)
            else:
                today[case.name] = answer
            bar.update(len(today))
    text = json.dumps(today, indent=None, separators=(",", ":"))
    if arguments.keep:
        arguments.keep.write_text(text, encoding="utf-8")
    if arguments.write:
        kept = {**(read_frozen() if FROZEN.exists() and arguments.only else {}), **today}
        FROZEN.parent.mkdir(parents=True, exist_ok=True)
        FROZEN.write_bytes(gzip.compress(json.dumps(kept, separators=(",", ":")).encode(), mtime=0))
        print(f"{len(today)} answers frozen")
        return 0
    known = read_frozen()
    changed = 0
    for name, answer in today.items():
        found = list(differences(known.get(name, {}), answer, "", arguments.near))
        changed += bool(found)
        for line in found[:_SHOWN]:
            print(f"{name}: {line.removeprefix('.')}")
        if len(found) > _SHOWN:
            print(f"{name}: and {len(found) - _SHOWN} more")
    print(f"{len(today)} answers, {changed} changed")
    return 1 if changed else 0


if __name__ == "__main__":
    sys.exit(main())
