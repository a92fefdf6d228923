"""Runs the example firmware, its configuration a unit of the binary image, on every spoilt record of the tools' benchmark, and wants of each: the self-test passed first, no slice too
long, no tick late, the bits of the board without hardware, and no confident wrong answer.

The records are those of docs/FAULTS.md, on the reference actuator, and the same ways of spoiling on the worn day of the unit with standing errors. Firmware makes command and time
itself, so what is spoilt in those columns alone is left out. It runs with the Python of the tools, which make the records.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

import emulate
import example
from benchmarks import faults
from ema_tools.data.records import Record, read_record

FILE = "ace_record.bin"
# Above what the healthy value or the true shift may be off, in % of it: this many of the half intervals that the firmware tells.
DOUBT = 1.5
# What a test of every day runs: the fault, and the record it is done to. The unit's records, of which each takes five times as long, are example_firmware_image's.
QUICK = (
    ("none", "healthy"),
    ("no number", "worn A"),
    ("stuck sensor", "worn B"),
    ("spikes", "worn A"),
)
# An instruction of the emulated board in us.
INSTRUCTION_US = 2.0**example.SHIFT / 1000.0


@dataclass(frozen=True)
class PlayedDay:
    """A record, the firmware that is to judge it, what is true of it in % of the healthy value, and how near an answer must come; and whether it is spoilt, too."""

    title: str
    program: str
    path: str
    shift_percent: tuple[float, float]
    within_percent: tuple[float, float]
    noises_mm: tuple[float, ...]
    spoilt: bool = True


_NEAR = tuple(faults.TOLERANCE_PERCENT.values())
DAYS = (
    *(
        PlayedDay(
            machine.name,
            "ace_file_reference_actuator",
            machine.record,
            (machine.shift_percent("csj_Nm"), machine.shift_percent("blk_mm")),
            (_NEAR[0], _NEAR[1]),
            (0.0, faults.NOISE_MM),
        )
        for machine in faults.MACHINES
    ),
    # its own sensors' noise is in the record
    PlayedDay("unit, sound", "ace_file_unit", "unit/sound.csv", (0.0, 0.0), example.SHIFT_WITHIN, (0.0,), False),
    PlayedDay("unit, worn", "ace_file_unit", "unit/worn.csv", (20.0, 50.0), example.SHIFT_WITHIN, (0.0,)),
)


@dataclass(frozen=True)
class PlayedRow:
    """One run of the firmware, and what came of it."""

    kind: str
    strength: str
    day: str
    noise_mm: float
    outcome: str
    slices: int
    slice_us: int
    tick_us: int
    problems: tuple[str, ...]


def record_of(fault: faults.InputFault, day: PlayedDay, noise_mm: float, record: Record) -> bytes | None:
    """What the firmware's sensors say, or None where they say what the unspoilt record does though the fault is one: it lies in the command or in the time alone."""
    random = np.random.Generator(np.random.PCG64(faults.SEED))
    sheet = faults.sheet_of(record, noise_mm, random)
    spoilt = fault.spoil(sheet, record, random)
    if fault.kind != "none" and np.array_equal(spoilt.position_mm, sheet.position_mm):
        return None
    current = record.recorded("current_A")[: spoilt.position_mm.size]
    return np.column_stack([spoilt.position_mm, current]).astype("<f4").tobytes()


def outcome_of(lines: list[list[str]], fault: faults.InputFault, day: PlayedDay) -> tuple[str, list[str]]:
    """The answer in a word, and what is wrong with it."""
    if example.value_of(lines, "status") == "refused":
        return "refused", ["a plain record is refused"] if fault.decided else []
    verdict = example.VERDICTS[example.value_of(lines, "verdict")]
    if verdict == "UNDECIDED":
        silent = int(example.value_of(lines, "reasons"), 16) == 0
        return "undecided", ["undecided without a reason"] * silent + ["a plain record is not decided"] * fault.decided
    told, halves, values = ([float(line[2]) for line in lines if line[0] == name][:2] for name in ("shift_percent", "half_95", "estimate"))
    wrong = []
    for shift, half, value, true, within in zip(told, halves, values, day.shift_percent, day.within_percent, strict=True):
        healthy = value / (1.0 + shift / 100.0)
        if abs(shift - true) > within + DOUBT * 100.0 * half / healthy:
            wrong.append(f"{verdict}, {shift:+.2f} % where {true:+.2f} % is true")
    worn = any(true > least for true, least in zip(day.shift_percent, example.FAULT_FROM, strict=True))
    if verdict != ("FAULT" if worn else "HEALTHY"):
        wrong.append(f"{verdict} is not what the machine is")
    return "right", wrong


def judged(given: argparse.Namespace, fault: faults.InputFault, day: PlayedDay, noise_mm: float, played: bytes) -> PlayedRow:
    """One record through the firmware on the emulated board and on the board without hardware."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        (folder / FILE).write_bytes(played)
        run = emulate.run(given.board, given.target / day.program, [example.SLICE_STEPS], shift=example.SHIFT, folder=folder)
        host = subprocess.run([str((given.host / day.program).absolute())], cwd=folder, capture_output=True, text=True, check=False)
    lines = example.lines_of(run.output)
    outcome, problems = outcome_of(lines, fault, day)
    count = {name: int(example.value_of(lines, name)) for name in ("selftest", "overruns", "late_ticks", "slices", "slice_us", "tick_us")}
    problems += [f"{name} {count[name]}" for name in ("selftest", "overruns", "late_ticks") if count[name] != 0]
    if example.value_of(lines, "status") not in ("ok", "refused"):
        problems.append(f"status {example.value_of(lines, 'status')}")
    ours, theirs = ([line for line in example.lines_of(output) if line[0] in example.ANSWER] for output in (host.stdout, run.output))
    if ours != theirs:
        problems.append("the board without hardware answers otherwise")
    return PlayedRow(
        fault.kind, fault.strength, day.title, noise_mm, outcome, count["slices"], count["slice_us"], count["tick_us"], tuple(problems)
    )


def rows_of(given: argparse.Namespace) -> list[PlayedRow]:
    """Every record; a run that was interrupted goes on from its folder."""
    recordings = given.root / "recordings"
    records = {day.title: read_record(recordings / day.path) for day in DAYS}
    jobs = []
    for fault in faults.FAULTS:
        for day in DAYS:
            wanted = fault.quick and (fault.kind, day.title) in QUICK if given.quick else day.spoilt or fault.kind == "none"
            for noise in day.noises_mm[-1:] if given.quick else day.noises_mm:
                played = record_of(fault, day, noise, records[day.title]) if wanted else None
                if played is not None:
                    jobs.append((fault, day, noise, played))

    def one(number: int) -> PlayedRow:
        fault, day, noise, _ = jobs[number]
        name = re.sub(r"\W+", "_", f"{fault.kind} {fault.strength} {day.title} {noise}")
        kept = given.work / f"{name}.json" if given.work else None
        if kept is not None and kept.is_file():
            held = json.loads(kept.read_text(encoding="utf-8"))
            return PlayedRow(**{**held, "problems": tuple(held["problems"])})
        row = judged(given, *jobs[number])
        if kept is not None:
            kept.write_text(json.dumps(asdict(row)), encoding="utf-8")
            sys.stderr.write(f"\r{number + 1} of {len(jobs)} ")
        return row

    if given.work:
        given.work.mkdir(parents=True, exist_ok=True)
    with ThreadPoolExecutor(given.workers) as pool:
        return list(pool.map(one, range(len(jobs))))


def document(rows: list[PlayedRow]) -> str:
    """docs/FIRMWARE_FAULTS.md."""
    days = []
    for day in DAYS:
        for noise in day.noises_mm:
            own = [row for row in rows if (row.day, row.noise_mm) == (day.title, noise)]
            outcomes = [sum(row.outcome == word for row in own) for word in ("right", "undecided", "refused")]
            told = ", noise" if noise else ""
            longest = max(row.slice_us for row in own)
            days.append(
                f"| {day.title}{told} | {len(own)} | {' | '.join(map(str, outcomes))} | {longest} | {max(row.tick_us for row in own)} |"
            )
    slowest = sorted(rows, key=lambda row: -row.slice_us)[:5]
    shown = "\n".join(f"| {row.kind} | {row.strength} | {row.day} | {row.slice_us} | {row.slices} |" for row in slowest)
    return f"""# The example firmware on spoilt records

Written by a command; do not edit. To write it again, after `cmake --workflow --preset test` and `cmake --workflow --preset cortex-m4f`:

    cmake --build build-cortex-m4f --target firmware_faults

The example firmware (`examples/firmware`) on the emulated Cortex-M4F, self-test first, its configuration a unit of the binary image `ace_units.bin`: on every spoilt record of
[FAULTS](FAULTS.md) for the reference actuator, and on the worn day of the unit with standing errors, spoilt in the same ways, and its sound day as it is. What is spoilt in the columns of
command or time alone is left out: firmware makes both itself.
An instruction takes {INSTRUCTION_US * 1000.0:.0f} ns of the emulated time; a slice of {example.SLICE_STEPS} steps may take 2000 us and a control tick may come 20 us late.

**{len(rows)} records: no slice over its budget, no tick late, every answer bit for bit that of the board without hardware, none confidently wrong.**

| machine | records | right | undecided | refused | longest slice, us | longest tick, us |
|---|---:|---:|---:|---:|---:|---:|
{chr(10).join(days)}

The longest slices:

| what is wrong | how much | machine | longest slice, us | slices |
|---|---|---|---:|---:|
{shown}
"""


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--board", required=True)
    parser.add_argument("--target", type=Path, required=True, help="folder of the firmware")
    parser.add_argument("--host", type=Path, required=True, help="the same on the board without hardware")
    parser.add_argument("--root", type=Path, required=True, help="the project")
    parser.add_argument("--quick", action="store_true", help="a few of the records")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--work", type=Path, help="keeps rows here, and goes on from them")
    parser.add_argument("-o", "--output", type=Path, help="write the document here")
    given = parser.parse_args()
    try:
        rows = rows_of(given)
    except (FileNotFoundError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    for row in rows:
        for problem in row.problems:
            print(f"spoilt: {row.kind}, {row.strength}, {row.day}, noise {row.noise_mm:g} mm: {problem}", file=sys.stderr)
    wrong = any(row.problems for row in rows)
    print(
        f"{len(rows)} records, longest slice {max(row.slice_us for row in rows)} us, {sum(bool(row.problems) for row in rows)} with a problem"
    )
    if given.output is not None and not wrong:
        given.output.write_text(document(rows), encoding="utf-8")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
