"""Records that sensors, clocks and cables have spoilt, and what the onboard module makes of them: `python -m benchmarks.faults`.

Every fault at several strengths, on a healthy machine and on two worn ones, without and with sensor noise, goes through the host program, which is the onboard module
alone: no guard of the tools stands behind it. A row is good when the record is refused, when the verdict is undecided with its reason, or when verdict and values are
right. A confident answer that is wrong is a failure, and so is a plain record that is not decided. The outcome of every row is written to docs/FAULTS.md.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.parallel import each
from ema_tools.data.cases import HEALTHY_BLK_MM, HEALTHY_CSJ_NM
from ema_tools.data.records import Record, read_record

ROOT = Path(__file__).resolve().parents[1]
DOCUMENT = ROOT / "docs" / "FAULTS.md"
NOISE_MM = 0.005
SEED = 20_261_121
# A value counts as right within this much of its healthy value, in %, and what the module states: three standard errors and its bias.
TOLERANCE_PERCENT = {"csj_Nm": 1.0, "blk_mm": 3.0}
_HEALTHY = {"csj_Nm": HEALTHY_CSJ_NM, "blk_mm": HEALTHY_BLK_MM}
# Smallest shifts that are a fault: those of the reference actuator.
_THRESHOLD_PERCENT = {"csj_Nm": 5.0, "blk_mm": 10.0}


@dataclass(frozen=True)
class ShippedMachine:
    """One machine: its shipped record and its true values."""

    name: str
    record: str
    csj_Nm: float
    blk_mm: float

    def shift_percent(self, name: str) -> float:
        """True shift of `csj_Nm` or `blk_mm` in % of the healthy value."""
        healthy = _HEALTHY[name]
        return 100.0 * (float(getattr(self, name)) - healthy) / healthy

    @property
    def verdict(self) -> str:
        """What a right verdict is."""
        return "fault" if any(self.shift_percent(name) > threshold for name, threshold in _THRESHOLD_PERCENT.items()) else "healthy"


MACHINES = (
    ShippedMachine("healthy", "healthy.csv", 0.138, 0.033),
    ShippedMachine("worn A", "case_a.csv", 0.3, 0.04125),
    ShippedMachine("worn B", "case_b.csv", 0.1449, 0.066),
)


@dataclass(frozen=True)
class SpoiltTable:
    """What stands in the file: every array [rows]; NaN is written as such."""

    time_s: Reals
    command_mm: Reals
    position_mm: Reals

    def text(self) -> str:
        """The file."""
        rows = zip(self.time_s.tolist(), self.command_mm.tolist(), self.position_mm.tolist(), strict=True)
        return "time_s,command_mm,position_mm\n" + "".join(f"{time:.9g},{command:.9g},{position:.9g}\n" for time, command, position in rows)


Spoil = Callable[[SpoiltTable, Record, np.random.Generator], SpoiltTable]


@dataclass(frozen=True)
class InputFault:
    """One row of the table: `kind` and `strength` in words, what it does, and whether the verdict must still be the right one."""

    kind: str
    strength: str
    spoil: Spoil
    decided: bool = False
    quick: bool = False


def _with(sheet: SpoiltTable, **columns: Reals) -> SpoiltTable:
    return SpoiltTable(**{"time_s": sheet.time_s, "command_mm": sheet.command_mm, "position_mm": sheet.position_mm, **columns})


def _plain(sheet: SpoiltTable, _record: Record, _random: np.random.Generator) -> SpoiltTable:
    return sheet


def _quantised(step_mm: float) -> Spoil:
    return lambda sheet, _record, _random: _with(sheet, position_mm=step_mm * np.round(sheet.position_mm / step_mm))


def _no_number(count: int, value: float) -> Spoil:
    def spoil(sheet: SpoiltTable, _record: Record, random: np.random.Generator) -> SpoiltTable:
        position = sheet.position_mm.copy()
        position[random.choice(position.size, count, replace=False)] = value
        return _with(sheet, position_mm=position)

    return spoil


def _stuck(first: int, rows: int) -> Spoil:
    def spoil(sheet: SpoiltTable, _record: Record, _random: np.random.Generator) -> SpoiltTable:
        position = sheet.position_mm.copy()
        position[first : first + rows] = position[first]
        return _with(sheet, position_mm=position)

    return spoil


def _every(rows: int) -> Spoil:
    """The sensor gives a new value at every `rows`-th row only."""
    return lambda sheet, _record, _random: _with(sheet, position_mm=sheet.position_mm[(np.arange(sheet.position_mm.size) // rows) * rows])


def _dropout(first: int, rows: int, times: int = 1) -> Spoil:
    """The reading falls to zero, `times` times over the record."""

    def spoil(sheet: SpoiltTable, _record: Record, _random: np.random.Generator) -> SpoiltTable:
        position = sheet.position_mm.copy()
        for begin in np.linspace(first, position.size - rows, times).astype(int) if times > 1 else [first]:
            position[begin : begin + rows] = 0.0
        return _with(sheet, position_mm=position)

    return spoil


def _lost(first: int, rows: int, renumbered: bool) -> Spoil:
    def spoil(sheet: SpoiltTable, _record: Record, _random: np.random.Generator) -> SpoiltTable:
        left = np.r_[0:first, first + rows : sheet.time_s.size]
        time = sheet.time_s[: left.size] if renumbered else sheet.time_s[left]
        return SpoiltTable(time, sheet.command_mm[left], sheet.position_mm[left])

    return spoil


def _late(rows: int) -> Spoil:
    """The position stands `rows` rows too late beside its command; less than zero: too early."""

    def spoil(sheet: SpoiltTable, _record: Record, _random: np.random.Generator) -> SpoiltTable:
        at = np.clip(np.arange(sheet.position_mm.size) - rows, 0, sheet.position_mm.size - 1)
        return _with(sheet, position_mm=sheet.position_mm[at])

    return spoil


def _spikes(count: int, height_mm: float) -> Spoil:
    def spoil(sheet: SpoiltTable, _record: Record, random: np.random.Generator) -> SpoiltTable:
        position = sheet.position_mm.copy()
        places = random.choice(position.size, count, replace=False)
        position[places] += height_mm * random.choice((-1.0, 1.0), count)
        return _with(sheet, position_mm=position)

    return spoil


def _clipped(share: float, sides: int = 2) -> Spoil:
    """The sensor's range ends at this share of the rod's way from its middle, on both sides or on the far one alone."""

    def spoil(sheet: SpoiltTable, record: Record, _random: np.random.Generator) -> SpoiltTable:
        least, most = share * float(np.min(record.position_mm)), share * float(np.max(record.position_mm))
        return _with(sheet, position_mm=np.clip(sheet.position_mm, least if sides == 2 else -np.inf, most))

    return spoil


def _cut(first: int, last: int) -> Spoil:
    def spoil(sheet: SpoiltTable, _record: Record, _random: np.random.Generator) -> SpoiltTable:
        part = slice(first, last)
        return SpoiltTable(sheet.time_s[part], sheet.command_mm[part], sheet.position_mm[part])

    return spoil


def _jitter(std_s: float) -> Spoil:
    """Samples are taken at other instants than their rows say."""

    def spoil(sheet: SpoiltTable, _record: Record, random: np.random.Generator) -> SpoiltTable:
        seen = np.interp(sheet.time_s + random.normal(0.0, std_s, sheet.time_s.size), sheet.time_s, sheet.position_mm)
        return _with(sheet, position_mm=seen)

    return spoil


def _stamps(std_s: float) -> Spoil:
    """The instants as written scatter."""
    return lambda sheet, _record, random: _with(sheet, time_s=sheet.time_s + random.uniform(-std_s, std_s, sheet.time_s.size))


def _clock(share: float) -> Spoil:
    """The recorder's clock runs faster than the controller's: the same rows, taken over a longer or shorter time."""

    def spoil(sheet: SpoiltTable, _record: Record, _random: np.random.Generator) -> SpoiltTable:
        return _with(sheet, position_mm=np.interp(sheet.time_s * (1.0 + share), sheet.time_s, sheet.position_mm))

    return spoil


def _gain(position: float, command: float = 1.0) -> Spoil:
    return lambda sheet, _record, _random: _with(sheet, position_mm=position * sheet.position_mm, command_mm=command * sheet.command_mm)


def _swapped(sheet: SpoiltTable, _record: Record, _random: np.random.Generator) -> SpoiltTable:
    return SpoiltTable(sheet.time_s, sheet.position_mm, sheet.command_mm)


def _instead(column: str) -> Spoil:
    """Another signal stands where the rod position should."""
    return lambda sheet, record, _random: _with(sheet, position_mm=record.recorded(column))


def _drift(mm: float) -> Spoil:
    return lambda sheet, _record, _random: _with(sheet, position_mm=sheet.position_mm + np.linspace(0.0, mm, sheet.position_mm.size))


def _offset(mm: float) -> Spoil:
    return lambda sheet, _record, _random: _with(sheet, position_mm=sheet.position_mm + mm)


def _chirp_mm(time_s: Reals, amplitude_mm: float, end_hz: float) -> Reals:
    return np.asarray(amplitude_mm * np.sin(2.0 * np.pi * (0.1 * time_s + (end_hz - 0.1) * time_s**2 / 20.0)))


def _other(amplitude_mm: float, end_hz: float) -> Spoil:
    """The command column holds another chirp than the one that was run."""
    return lambda sheet, _record, _random: _with(sheet, command_mm=_chirp_mm(sheet.time_s, amplitude_mm, end_hz))


def _backwards(sheet: SpoiltTable, _record: Record, _random: np.random.Generator) -> SpoiltTable:
    return _with(sheet, command_mm=sheet.command_mm[::-1])


FAULTS = (
    InputFault("none", "as recorded", _plain, decided=True, quick=True),
    InputFault("resolution", "1 um", _quantised(0.001), decided=True),
    InputFault("resolution", "5 um", _quantised(0.005), decided=True),
    InputFault("resolution", "10 um", _quantised(0.010)),
    InputFault("resolution", "20 um", _quantised(0.020)),
    InputFault("resolution", "0.1 mm", _quantised(0.1)),
    InputFault("no number", "one NaN", _no_number(1, np.nan), quick=True),
    InputFault("no number", "1 % NaN", _no_number(100, np.nan)),
    InputFault("no number", "one infinity", _no_number(1, np.inf)),
    InputFault("stuck sensor", "20 ms", _stuck(6200, 20)),
    InputFault("stuck sensor", "50 ms", _stuck(6200, 50), quick=True),
    InputFault("stuck sensor", "0.2 s", _stuck(6200, 200)),
    InputFault("stuck sensor", "0.2 s at a reversal", _stuck(1550, 200)),
    InputFault("stuck sensor", "2 s", _stuck(6200, 2000)),
    InputFault("stuck sensor", "from 0.5 s on", _stuck(500, 9500)),
    InputFault("stuck sensor", "throughout", _stuck(0, 10000)),
    InputFault("old values", "new one every 2 ms", _every(2)),
    InputFault("old values", "new one every 5 ms", _every(5)),
    InputFault("old values", "new one every 20 ms", _every(20)),
    InputFault("dropout to zero", "1 row", _dropout(6200, 1), quick=True),
    InputFault("dropout to zero", "10 rows", _dropout(6200, 10)),
    InputFault("dropout to zero", "0.5 s", _dropout(6200, 500)),
    InputFault("dropout to zero", "1 row, 50 times", _dropout(100, 1, 50)),
    InputFault("lost rows", "1, time tells", _lost(6200, 1, False)),
    InputFault("lost rows", "100, time tells", _lost(6200, 100, False)),
    InputFault("lost rows", "1, renumbered", _lost(6200, 1, True)),
    InputFault("lost rows", "10, renumbered", _lost(6200, 10, True)),
    InputFault("lost rows", "100, renumbered", _lost(6200, 100, True)),
    InputFault("spikes", "1 of 0.05 mm", _spikes(1, 0.05)),
    InputFault("spikes", "1 of 0.5 mm", _spikes(1, 0.5)),
    InputFault("spikes", "1 of 5 mm", _spikes(1, 5.0), quick=True),
    InputFault("spikes", "1 of 100 mm", _spikes(1, 100.0)),
    InputFault("spikes", "20 of 0.05 mm", _spikes(20, 0.05)),
    InputFault("spikes", "20 of 0.5 mm", _spikes(20, 0.5)),
    InputFault("spikes", "500 of 0.05 mm", _spikes(500, 0.05)),
    InputFault("saturation", "at 99.9 % of the peak", _clipped(0.999)),
    InputFault("saturation", "at 99.5 %", _clipped(0.995)),
    InputFault("saturation", "at 99 %", _clipped(0.99), quick=True),
    InputFault("saturation", "at 97 %", _clipped(0.97)),
    InputFault("saturation", "at 90 %", _clipped(0.90)),
    InputFault("saturation", "at 50 %", _clipped(0.50)),
    InputFault("saturation", "at 99.5 %, one side", _clipped(0.995, 1)),
    InputFault("saturation", "at 99 %, one side", _clipped(0.99, 1)),
    InputFault("saturation", "at 90 %, one side", _clipped(0.90, 1)),
    InputFault("cut record", "last 1 s missing", _cut(0, 9000)),
    InputFault("cut record", "first 3 s alone", _cut(0, 3000)),
    InputFault("cut record", "first 0.5 s alone", _cut(0, 500)),
    InputFault("cut record", "first 50 ms alone", _cut(0, 50)),
    InputFault("cut record", "first 0.2 s missing", _cut(200, 10000)),
    InputFault("cut record", "first 5 s missing", _cut(5000, 10000)),
    InputFault("time jitter", "of the samples, 20 us rms", _jitter(2.0e-5)),
    InputFault("time jitter", "of the samples, 0.1 ms rms", _jitter(1.0e-4)),
    InputFault("time jitter", "of the samples, 0.5 ms rms", _jitter(5.0e-4), quick=True),
    InputFault("time jitter", "of the samples, 2 ms rms", _jitter(2.0e-3)),
    InputFault("time jitter", "of the written instants, 10 us", _stamps(1.0e-5)),
    InputFault("time jitter", "of the written instants, 0.2 ms", _stamps(2.0e-4)),
    InputFault("clock", "0.01 % fast", _clock(1.0e-4)),
    InputFault("clock", "0.1 % fast", _clock(1.0e-3)),
    InputFault("clock", "1 % fast", _clock(1.0e-2)),
    InputFault("lag", "1 ms late", _late(1)),
    InputFault("lag", "1 ms early", _late(-1)),
    InputFault("lag", "5 ms late", _late(5)),
    InputFault("lag", "50 ms late", _late(50)),
    InputFault("wrong sign", "of the position", _gain(-1.0), quick=True),
    InputFault("wrong sign", "of the command", _gain(1.0, -1.0)),
    InputFault("wrong scale", "position 0.1 % large", _gain(1.001)),
    InputFault("wrong scale", "position 0.5 % small", _gain(0.995)),
    InputFault("wrong scale", "position 2 % small", _gain(0.98)),
    InputFault("wrong scale", "command 1 % large", _gain(1.0, 1.01)),
    InputFault("wrong scale", "position in metres", _gain(1.0e-3)),
    InputFault("offset", "10 um", _offset(0.01)),
    InputFault("offset", "0.1 mm", _offset(0.1)),
    InputFault("offset", "1 mm", _offset(1.0)),
    InputFault("drift", "10 um", _drift(0.01)),
    InputFault("drift", "0.1 mm", _drift(0.1)),
    InputFault("swapped channels", "command and position", _swapped, quick=True),
    InputFault("swapped channels", "motor position as position", _instead("motor_position_mm")),
    InputFault("swapped channels", "current as position", _instead("current_A")),
    InputFault("swapped channels", "command as position", _instead("command_mm")),
    InputFault("another command", "chirp to 4.01 Hz", _other(2.0, 4.01)),
    InputFault("another command", "chirp to 4.2 Hz", _other(2.0, 4.2), quick=True),
    InputFault("another command", "chirp to 8 Hz", _other(2.0, 8.0)),
    InputFault("another command", "2.01 mm", _other(2.01, 4.0)),
    InputFault("another command", "2.2 mm", _other(2.2, 4.0)),
    InputFault("another command", "backwards", _backwards),
)


@dataclass(frozen=True)
class Row:
    """One run: what went in, what came out. `refused` is the program's line, else None; shifts and what they may be off (three standard errors and bias) in % of the healthy
    value."""

    fault: InputFault
    machine: ShippedMachine
    noise_mm: float
    refused: str | None
    verdict: str
    reasons: tuple[str, ...]
    shift_percent: tuple[float, float]
    doubt_percent: tuple[float, float]

    @property
    def right(self) -> bool:
        """Verdict and values are those of the machine."""
        errors = (
            abs(self.shift_percent[place] - self.machine.shift_percent(name)) <= TOLERANCE_PERCENT[name] + self.doubt_percent[place]
            for place, name in enumerate(TOLERANCE_PERCENT)
        )
        return self.refused is None and self.verdict == self.machine.verdict and all(errors)

    @property
    def good(self) -> bool:
        """Refused, undecided with a reason, or right; of a plain record right alone."""
        if self.fault.decided:
            return self.right
        return self.refused is not None or (self.verdict == "undecided" and bool(self.reasons)) or self.right


def _program() -> Path:
    folder = os.environ.get("EMA_BIN_DIR")
    return (Path(folder) if folder else ROOT / "build" / "bin") / "ema_identify"


def sheet_of(record: Record, noise_mm: float, random: np.random.Generator) -> SpoiltTable:
    """The unspoilt file of a record, with noise on the rod position."""
    return SpoiltTable(record.time_s, record.command_mm, record.position_mm + noise_mm * random.standard_normal(record.rows))


def run(fault: InputFault, machine: ShippedMachine, noise_mm: float, record: Record, program: Path) -> Row:
    """One record through the host program. Raises RuntimeError when the program itself fails."""
    random = np.random.Generator(np.random.PCG64(SEED))
    sheet = sheet_of(record, noise_mm, random)
    spoilt = fault.spoil(sheet, record, random)
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "record.csv").write_text(spoilt.text(), encoding="utf-8")
        done = subprocess.run(
            [program, "--json", "result.json", "record.csv"], cwd=folder, capture_output=True, text=True, timeout=300, check=False
        )
        if done.returncode == 1:
            return Row(fault, machine, noise_mm, done.stderr.strip(), "", (), (np.nan, np.nan), (np.nan, np.nan))
        if done.returncode != 0:
            raise RuntimeError(f"ema_identify ended with {done.returncode}: {done.stderr.strip()}")
        result = json.loads((Path(folder) / "result.json").read_text(encoding="utf-8"))
    found = [result[name] for name in TOLERANCE_PERCENT]
    shifts = [float(part["shift_percent"]) for part in found]
    doubts = [
        100.0 * (3.0 * float(part["std"]) + float(part["bias"])) / float(part["healthy"]) if part["std"] is not None else np.nan
        for part in found
    ]
    return Row(
        fault, machine, noise_mm, None, str(result["verdict"]), tuple(result["reasons"]), (shifts[0], shifts[1]), (doubts[0], doubts[1])
    )


def table(
    faults: Sequence[InputFault] = FAULTS,
    machines: Sequence[ShippedMachine] = MACHINES,
    noises_mm: Sequence[float] = (0.0, NOISE_MM),
    done: Callable[[int], None] | None = None,
) -> list[Row]:
    """Every fault on every machine with every noise, in this order."""
    program = _program()
    records = {machine.name: read_record(ROOT / "recordings" / machine.record) for machine in machines}
    jobs = [(fault, machine, noise) for fault in faults for machine in machines for noise in noises_mm]
    return each(lambda job: run(job[0], job[1], job[2], records[job[1].name], program), jobs, done)


# Short words for the module's reasons, by how their lines begin.
_REASONS = {
    "the residual is larger": "residual",
    "an estimate lies on a bound": "at bound",
    "the evaluations were used up": "not converged",
    "a shift cannot be told": "near threshold",
    "the record does not determine": "not determined",
    "a parameter fell": "below healthy",
}
_KEY = {
    "right": "verdict and values are those of the machine",
    "residual": "undecided: the residual is larger, or its rows are more alike, than the sensor's noise explains",
    "at bound": "undecided: an estimate lies on a bound of its search",
    "not converged": "undecided: the model runs were used up while the cost still fell",
    "near threshold": "undecided: a shift is closer to its threshold than what it may be off",
    "not determined": "undecided: too much doubt about a parameter, or the rod was never pushed both ways",
    "below healthy": "undecided: a parameter fell, which wear does not do",
    "refused": "the program ends with one line that names file, row and column",
    "**wrong**": "a confident answer that is not the machine's, or a plain record that is not decided",
}


def outcome(row: Row) -> str:
    """The row in a word or two."""
    if not row.good:
        return "**wrong**"
    if row.refused is not None:
        return "refused"
    if row.right:
        return "right"
    return ", ".join(next(short for begin, short in _REASONS.items() if reason.startswith(begin)) for reason in row.reasons)


def counted(rows: Sequence[Row]) -> str:
    """How many rows ended how, in one sentence."""
    refused, right = sum(row.refused is not None for row in rows), sum(row.right for row in rows)
    wrong = sum(not row.good for row in rows)
    return f"{len(rows)} records: {right} answered rightly, {len(rows) - refused - right - wrong} undecided with a reason, {refused} refused, {wrong} wrong."


def document(rows: Sequence[Row]) -> str:
    """The table as Markdown. Outcomes are the same on every machine that gives the module's bits; values are not told."""
    places = [(machine, noise) for machine in MACHINES for noise in (0.0, NOISE_MM)]
    found = {(row.fault.kind, row.fault.strength, row.machine.name, row.noise_mm): outcome(row) for row in rows}
    head = " | ".join(f"{machine.name}, {'noise' if noise else 'no noise'}" for machine, noise in places)
    lines = [
        f"| {fault.kind} | {fault.strength} | "
        + " | ".join(found[fault.kind, fault.strength, machine.name, noise] for machine, noise in places)
        + " |"
        for fault in FAULTS
    ]
    machines = "; ".join(
        f"{machine.name}: CSJ {machine.shift_percent('csj_Nm'):+.1f} %, BLK {machine.shift_percent('blk_mm'):+.1f} %"
        for machine in MACHINES
    )
    return f"""# Spoilt records

Written by a command; do not edit. To write it again, after `cmake --workflow --preset test`:

    build/venv/bin/python -m benchmarks.faults -o docs/FAULTS.md

Records of the truth plant, spoilt as a sensor, a clock, a cable or a mistake would, and read by `ema_identify`: the onboard module alone, with nothing of the tools behind it.
{machines}. Noise is {1000.0 * NOISE_MM:g} um rms on the rod position. A value counts as right within {TOLERANCE_PERCENT["csj_Nm"]:g} % (CSJ) and {TOLERANCE_PERCENT["blk_mm"]:g} % (BLK) of
its healthy value besides what the module states itself: three standard errors and the bias.

**{counted(rows)}**

| outcome | means |
|---|---|
{chr(10).join(f"| {word} | {text} |" for word, text in _KEY.items())}

| what is wrong | how much | {head} |
|---|---|{"---|" * len(places)}
{chr(10).join(lines)}

What moves the rod's reading by less than the noise, and for as long as a motion lasts, cannot be seen in a single record and shifts the estimates: a sensor that saturates at
99.6 % of the stroke or a lag of 0.1 ms moves BLK by 3 to 6 %. The module counts a third of what lasts in the residual as if it lay along the parameter's signature, and tells
a fault or a healthy machine only beyond that: `bias` in `ema_sensitivity.h`.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the whole table; 0 when no row is wrong."""
    parser = argparse.ArgumentParser(description="what the onboard module makes of spoilt records")
    parser.add_argument("-o", "--output", type=Path, help="write the document here")
    options = parser.parse_args(arguments)
    rows = table()
    for row in rows:
        if not row.good:
            print(
                f"wrong: {row.fault.kind}, {row.fault.strength}, {row.machine.name}, noise {row.noise_mm:g} mm: {row.verdict} {row.shift_percent}",
                file=sys.stderr,
            )
    if options.output is not None:
        options.output.write_text(document(rows), encoding="utf-8")
    print(counted(rows))
    return 0 if all(row.good for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
