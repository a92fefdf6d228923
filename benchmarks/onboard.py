"""What the onboard table names, and what its signals and its rate cost: `python -m benchmarks.onboard -o docs/ONBOARD_DIAGNOSIS.md`.

Machines of the hidden trials, simulated by the truth plant, which shares no code with the module; each is known by calibration on five healthy runs, as a user's would be. The search is the
module's own on the rod position alone; the table is applied as the module does, by `ema_tools.tasks.signature_table.judge`, which the tests hold against the C code.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import click
import numpy as np

from benchmarks.hidden.catalogue import FAULTS, LIBRARY, OUTSIDE, SEVERITIES, change, same_class
from benchmarks.hidden.machines import Machine, machine, measured, seed_of
from benchmarks.hidden.sealed import record_of
from ema_tools.base.errors import InputError
from ema_tools.base.files import write_text
from ema_tools.base.parallel import each
from ema_tools.data.actuator import Actuator, reference_actuator
from ema_tools.data.cases import CASES, HEALTHY_BLK_MM, HEALTHY_CSJ_NM
from ema_tools.data.records import Record
from ema_tools.plant.native import Identification, SearchSettings
from ema_tools.tasks.calibrate import calibrate
from ema_tools.tasks.onboard_search import run
from ema_tools.tasks.signature_table import RATE_HZ, SIGNALS, Judged, Signatures, judge, residual_of, signatures
from ema_tools.words.terminal.console import Bar, progress, run_command

COMMAND = "chirp"
REPEATS = 5
DAYS = 10
STRENGTHS = ("small", "medium", "large")
_BEHIND = ("medium", "large")
CHOICES: Sequence[tuple[tuple[str, ...], float]] = (
    (("position_mm",), 10.0),
    (("position_mm",), 25.0),
    (("position_mm",), 50.0),
    (SIGNALS, 10.0),
    (SIGNALS, 25.0),
    (SIGNALS, 50.0),
    (("position_mm", "motor_position_mm"), 25.0),
    (("position_mm", "motor_position_mm", "current_A"), 10.0),
    (("position_mm", "motor_position_mm", "current_A"), 25.0),
)
# As src/session/ema_guarded.c begins a search.
_WARMTH = 1e-3
_REACH = (0.5, 2.0)
BEGIN, END = "<!-- measured: written by the command below -->", "<!-- end of measured -->"


@dataclass(frozen=True)
class Kept:
    """A record with what is hidden in it."""

    kind: str
    name: str
    strength: str
    record: Record


@dataclass(frozen=True)
class Known:
    """A machine as its owner knows it, and its records."""

    actuator: Actuator
    healthy: tuple[Record, ...]
    kept: tuple[Kept, ...]


def _fault_values(unit: Machine, csj: float, blk: float) -> dict[str, float]:
    values = {**{name: reference_actuator()[name] for name in ("screw.csj_Nm", "screw.blk_mm")}, **unit.values}
    return {"screw.csj_Nm": values["screw.csj_Nm"] * csj, "screw.blk_mm": values["screw.blk_mm"] * blk}


def known(number: int) -> Known:
    """The unit of that number with everything that is hidden in it."""
    unit = machine(number)

    def seen(values: Mapping[str, float], *day: object) -> Record:
        return record_of(measured(unit, values, COMMAND, seed_of("onboard", number, *day)), 0)

    healthy = tuple(seen({}, "repeat", k) for k in range(REPEATS))
    kept = [Kept("healthy", "", "", seen({}, "healthy", k)) for k in range(DAYS)]
    for kind, names in (("effect", LIBRARY), ("fault", FAULTS), ("outside", OUTSIDE)):
        kept += [
            Kept(kind, name, strength, seen(change(unit, name, SEVERITIES[strength], COMMAND).values, name, strength))
            for name in names
            for strength in STRENGTHS
        ]
    kept += [
        Kept("case", case.letter, "", seen(_fault_values(unit, case.csj_Nm / HEALTHY_CSJ_NM, case.blk_mm / HEALTHY_BLK_MM), case.letter))
        for case in CASES
    ]
    return Known(calibrate(reference_actuator(), healthy).actuator, healthy, tuple(kept))


def _named(found: Judged, kept: Kept) -> bool:
    return found.kind == "missing" and same_class(found.scored[0].effect, kept.name)


def naming(machines: Sequence[Known], signals: tuple[str, ...], rate_hz: float) -> list[str]:
    """A row of the table of choices: what is named against the known machine, CSJ and BLK healthy."""
    right = dict.fromkeys(STRENGTHS, 0)
    three = dict.fromkeys(STRENGTHS, 0)
    all_of = dict.fromkeys(STRENGTHS, 0)
    accused, days, size, rate = 0, 0, 0.0, rate_hz
    for one in machines:
        table = signatures(one.actuator, one.healthy, signals, rate_hz)
        size = max(size, 2.0 * table.numbers / 1024.0)
        # a rate with which the table would not fit is lowered
        rate = min(rate, 1.0 / (table.bin_rows * one.actuator.record_period_s))
        for kept in one.kept:
            if kept.kind not in ("healthy", "effect"):
                continue
            found = judge(table, residual_of(table, kept.record))
            if kept.kind == "healthy":
                accused, days = accused + (found.kind != "adequate"), days + 1
                continue
            all_of[kept.strength] += 1
            right[kept.strength] += _named(found, kept)
            three[kept.strength] += any(same_class(scored.effect, kept.name) for scored in found.scored[:3])
    cells = [f"{right[strength]} of {all_of[strength]}, {three[strength]} among three" for strength in STRENGTHS]
    return [", ".join(signals), f"{rate:.3g}", f"{size:.0f}", *cells, f"{accused} of {days}"]


def _start(table: Signatures, found: Judged) -> tuple[float, ...]:
    actuator = table.actuator
    bounds = {
        "screw.csj_Nm": ("search.csj_lower_Nm", "search.csj_upper_Nm"),
        "screw.blk_mm": ("search.blk_lower_mm", "search.blk_upper_mm"),
    }
    near = [float(np.clip(one.healthy + found.moved[one.key], _REACH[0] * one.healthy, _REACH[1] * one.healthy)) for one in table.faults]
    return tuple(
        float(np.clip(value, actuator[bounds[one.name][0]], actuator[bounds[one.name][1]]))
        for one, value in zip(table.faults, near, strict=True)
    )


@dataclass(frozen=True)
class GuardedRun:
    """One record through search and table: from the healthy start, and from the table's."""

    kept: Kept
    cold: Identification
    warm: Identification
    found: Judged


def guarded(table: Signatures, kept: Kept) -> GuardedRun:
    """The record as ema_guarded_run treats it, and beside it the search without a table."""
    actuator = table.actuator
    cold = run(actuator, kept.record, SearchSettings(), 32)
    first = judge(table, residual_of(table, kept.record))
    temperature = min(
        max(_WARMTH * cold.objective_before, actuator["search.function_tolerance_mm2s"]), actuator["search.initial_temperature_mm2s"]
    )
    warm = run(actuator, kept.record, SearchSettings(start=_start(table, first), initial_temperature=temperature), 32)
    at = actuator.changed({one.name: one.estimate for one in warm.identified})
    return GuardedRun(kept, cold, warm, judge(table, residual_of(table, kept.record, at), at))


def _row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def verdicts(answers: Sequence[GuardedRun]) -> list[str]:
    """Rows: what is hidden, records, those that the session alone calls explained, and faulty; those to which the table objects, and rightly named ones."""
    groups: list[tuple[str, list[GuardedRun]]] = [("nothing", [one for one in answers if one.kept.kind == "healthy"])]
    for kind, title in (("fault", "CSJ +5 % / +15 %, BLK +25 % / +75 %"), ("case", "cases A, B, C")):
        groups.append((title, [one for one in answers if one.kept.kind == kind]))
    for kind, title in (("effect", "effect of the library"), ("outside", "effect outside it")):
        groups += [
            (f"{title}, {strength}", [one for one in answers if one.kept.kind == kind and one.kept.strength == strength])
            for strength in _BEHIND
        ]
    rows = []
    for title, group in groups:
        adequate = sum(one.warm.adequate for one in group)
        fault = sum(one.warm.verdict == "fault" for one in group)
        objected = sum(one.found.kind != "adequate" for one in group)
        right = sum(_named(one.found, one.kept) for one in group) if title.startswith("effect of") else None
        rows.append(_row([title, str(len(group)), str(adequate), str(fault), str(objected), "" if right is None else str(right)]))
    return rows


def searches(answers: Sequence[GuardedRun]) -> list[str]:
    """Rows: what is hidden, model runs without and with a table (its own two counted), and how far the estimates lie apart at most, in standard errors."""
    rows = []
    for title, kinds in (
        ("nothing", ("healthy",)),
        ("CSJ or BLK", ("fault",)),
        ("case A", ("A",)),
        ("case B", ("B",)),
        ("case C", ("C",)),
        ("an effect", ("effect", "outside")),
    ):
        group = [one for one in answers if one.kept.kind in kinds or (one.kept.kind == "case" and one.kept.name in kinds)]
        cold, warm = (
            float(np.mean([run_of.evaluations for run_of in runs])) for runs in ([one.cold for one in group], [one.warm for one in group])
        )
        apart = [
            abs(a.estimate - b.estimate) / b.std
            for one in group
            for a, b in zip(one.warm.identified, one.cold.identified, strict=True)
            if b.std > 0.0
        ]
        rows.append(_row([title, f"{cold:.0f}", f"{warm + 2.0:.0f}", f"{np.max(apart):.2g}"]))
    return rows


def written(first: int, machines: int, choices: Sequence[Sequence[str]], answers: Sequence[GuardedRun]) -> str:
    """The block of the document."""
    lines = [
        BEGIN,
        (
            f"Machines {first} to {first + machines - 1}, on which nothing was chosen: {len(LIBRARY)} effects, small, medium and large as in [NAMING](NAMING.md), one record each; "
            f"{DAYS} healthy days of each machine."
        ),
        "",
        _row(["signals", "rate, Hz", "KiB", *(f"named, {strength}" for strength in STRENGTHS), "healthy accused"]),
        "|---|---:|---:|---:|---:|---:|---:|",
        *(_row(choice) for choice in choices),
        "",
        f"With the table that is shipped ({' and '.join(SIGNALS)} at {RATE_HZ:g} Hz), behind the module's own search on the rod position:",
        "",
        _row(["hidden", "records", "session alone: explained", "session alone: fault", "table objects", "rightly named"]),
        "|---|---:|---:|---:|---:|---:|",
        *verdicts(answers),
        "",
        _row(["hidden", "model runs without", "with the table", "estimates apart at most, standard errors"]),
        "|---|---:|---:|---:|",
        *searches(answers),
        END,
    ]
    return "\n".join(lines)


def placed(document: str, block: str) -> str:
    """The document with the block in its place. Raises InputError when it has none."""
    before, begin, rest = document.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise InputError(f"the document has no place for the figures: write {BEGIN} and {END} into it")
    return before + block + after


def _count(bar: Bar, before: int, done: int) -> None:
    bar.update(before + done)


@click.command()
@click.option("--machines", default=3, show_default=True, type=click.IntRange(1), help="Number of machines.")
@click.option(
    "--first", default=11, show_default=True, type=click.IntRange(1), help="Number of the first; shapes and sizes were chosen on 1 to 5."
)
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Document whose figures are replaced; else the terminal.")
def measure(machines: int, first: int, output: Path | None) -> None:
    """Naming by the onboard table."""
    begun = time.monotonic()
    with progress("machines", machines) as bar:
        units = []
        for number in range(first, first + machines):
            units.append(known(number))
            bar.update(len(units))
    choices = [naming(units, signals, rate) for signals, rate in CHOICES]
    answers: list[GuardedRun] = []
    with progress("searches", sum(kept.strength != "small" for one in units for kept in one.kept)) as bar:
        for one in units:
            table = signatures(one.actuator, one.healthy)
            wanted = [kept for kept in one.kept if kept.strength != "small"]
            answers += each(partial(guarded, table), wanted, partial(_count, bar, len(answers)))
    block = written(first, machines, choices, answers)
    if output:
        write_text(output, placed(output.read_text(encoding="utf-8"), block), force=True)
    else:
        click.echo(block)
    click.echo(f"{time.monotonic() - begun:.0f} s", err=True)


if __name__ == "__main__":
    run_command(measure)
