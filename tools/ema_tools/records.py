"""Recordings: read from CSV (by the C reader, so that there is one parser), MATLAB .mat or Parquet, and written as CSV.

A recording has one row per sample at a constant rate. `time_s`, `command_mm` and `position_mm` (rod) are required;
`motor_position_mm`, `current_A`, `voltage_V` (applied over the interval that starts at the row) and `speed_mm_s` are used when present.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np

from ema_tools.errors import InputError
from ema_tools.files import read_text, reason, write_text
from ema_tools.native import CHANNELS, Reals, Simulation

REQUIRED = ("time_s", "command_mm", "position_mm")
OPTIONAL = ("motor_position_mm", "current_A", "voltage_V", "speed_mm_s")
COLUMNS = REQUIRED + OPTIONAL
# Rows by which a record must be longer than nothing: the fewest that the onboard session identifies from.
ROWS_MIN = 100
_UNEVEN = 0.01  # share of the period by which a step may differ


@dataclass(frozen=True)
class Record:
    """One recording; every array has shape [rows], absent signals are None. `file` is shown in messages."""

    period_s: float
    command_mm: Reals
    position_mm: Reals
    motor_position_mm: Reals | None = None
    current_A: Reals | None = None
    voltage_V: Reals | None = None
    speed_mm_s: Reals | None = None
    file: str = "record"
    first_time_s: float = 0.0

    @property
    def rows(self) -> int:
        """Number of samples."""
        return int(self.command_mm.size)

    @property
    def time_s(self) -> Reals:
        """Time of each row, [rows]."""
        return self.first_time_s + self.period_s * np.arange(self.rows)

    @property
    def start_mm(self) -> float:
        """Where a simulation of this record starts from rest: the first rod position."""
        return float(self.position_mm[0])

    @property
    def present(self) -> tuple[str, ...]:
        """Names of the recorded columns except time."""
        return tuple(name for name in COLUMNS[1:] if getattr(self, name) is not None)

    def channel(self, name: str) -> Reals | None:
        """A recorded column by name, None when it is absent."""
        found: Reals | None = getattr(self, name)
        return found

    def table(self) -> Reals:
        """The channels of the C module, [rows, 4], NaN where not recorded."""
        return np.column_stack([np.full(self.rows, np.nan) if self.channel(name) is None else self.channel(name) for name in CHANNELS])

    def with_noise(self, std: Mapping[str, float], seed: int) -> Record:
        """A copy with white Gaussian noise of standard deviation `std[column]` added, the same for the same seed."""
        random = np.random.default_rng(seed)
        changed = {}
        for name in COLUMNS[1:]:
            if name in std:
                values = self.channel(name)
                if values is None:
                    raise InputError(f"{self.file}: noise on {name}: the column is not there: name one of {', '.join(self.present)}")
                changed[name] = values + random.normal(0.0, std[name], self.rows)
        return replace(self, **changed)


def from_simulation(simulation: Simulation, command_mm: Reals, period_s: float, file: str = "simulated") -> Record:
    """The record that a simulated run would have left."""
    return Record(
        period_s=period_s,
        command_mm=np.asarray(command_mm, dtype=np.float64),
        file=file,
        **{name: getattr(simulation, name) for name in COLUMNS if name not in ("time_s", "command_mm")},
    )


def write_record(path: str | Path, record: Record, comments: tuple[str, ...] = (), force: bool = False, digits: int = 17) -> None:
    """Write a CSV with `#` comments, one header row and the recorded columns; `digits` 17 keeps a float64 exactly, 9 a float32.

    Raises InputError when the file exists and `force` is not set, or cannot be written.
    """
    names = record.present
    shape = f"%.{digits}g"
    numbers = np.column_stack([record.channel(name) for name in names])
    lines = [f"# {line}" for line in comments]
    lines.append(",".join(("time_s", *names)))
    row = "%.12g," + ",".join([shape] * len(names))
    lines.extend(row % (time, *values) for time, values in zip(record.time_s.tolist(), numbers.tolist(), strict=True))
    write_text(path, "\n".join(lines) + "\n", force)


def read_record(path: str | Path) -> Record:
    """Read a recording; the ending decides the format (.mat, .parquet, else CSV).

    Raises InputError in one line that names file, row and field.
    """
    ending = Path(path).suffix.lower()
    if ending == ".mat":
        return _from_columns(_mat_columns(Path(path)), Path(path).name)
    if ending in (".parquet", ".pq"):
        return _from_columns(_parquet_columns(Path(path)), Path(path).name)
    return _from_columns(_csv_columns(Path(path)), Path(path).name)


def _record(columns: Mapping[str, Reals], period_s: float, file: str) -> Record:
    allowed = {entry.name for entry in fields(Record)}
    arrays = {name: np.ascontiguousarray(values) for name, values in columns.items() if name in allowed}
    return Record(period_s=period_s, first_time_s=float(columns["time_s"][0]), file=file, **arrays)


def _exists(path: Path) -> None:
    try:
        path.open("rb").close()
    except OSError as error:
        raise InputError(f"{path}: {reason(error)}: check the path") from None


def _csv_columns(path: Path) -> dict[str, Reals]:
    lines = [line for line in read_text(path).splitlines() if line.strip() and not line.startswith("#")]
    names = lines[0].split(",") if lines else []
    table = np.loadtxt(lines[1:], delimiter=",", ndmin=2)
    return _numbers({name: table[:, names.index(name)] for name in COLUMNS if name in names}, path.name, names)


def _mat_columns(path: Path) -> dict[str, Reals]:
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    _exists(path)
    try:
        content = loadmat(path)
    except (MatReadError, ValueError, TypeError, NotImplementedError, EOFError, OSError) as error:
        hint = "save it with -v7" if isinstance(error, NotImplementedError) else "save it again from MATLAB"
        raise InputError(f"{path.name}: not a readable .mat file: {hint}") from None
    return _numbers({name: content[name] for name in COLUMNS if name in content}, path.name, [name for name in content if not name.startswith("__")])


def _parquet_columns(path: Path) -> dict[str, Reals]:
    import pyarrow
    import pyarrow.parquet

    _exists(path)
    try:
        names = pyarrow.parquet.read_schema(path).names
        table = pyarrow.parquet.read_table(path, columns=[name for name in COLUMNS if name in names])
    except (pyarrow.ArrowException, OSError):
        raise InputError(f"{path.name}: not a readable Parquet file: write it again") from None
    return _numbers({name: table.column(name).to_numpy() for name in table.column_names}, path.name, names)


def _numbers(columns: Mapping[str, object], file: str, found: list[str]) -> dict[str, Reals]:
    for name in REQUIRED:
        if name not in columns:
            there = f" (found: {', '.join(found)})" if found else ""
            raise InputError(f"{file}: {name}: column missing{there}: add it")
    numbers = {}
    for name, values in columns.items():
        try:
            numbers[name] = np.asarray(values, dtype=np.float64).ravel()
        except (TypeError, ValueError):
            raise InputError(f"{file}: {name}: holds something that is not a number: correct it") from None
    return numbers


def _from_columns(columns: dict[str, Reals], file: str) -> Record:
    """A record after the checks that the C reader makes on a CSV. Rows are counted from 1."""
    rows = columns["time_s"].size
    for name, values in columns.items():
        if values.size != rows:
            raise InputError(f"{file}: {name}: {values.size} rows, time_s has {rows}: give every column the same length")
        bad = np.flatnonzero(~np.isfinite(values))
        if bad.size:
            raise InputError(f"{file}, row {bad[0] + 1}: {name}: not a finite number: correct or remove the row")
    if rows < ROWS_MIN:
        raise InputError(f"{file}: {rows} rows: at least {ROWS_MIN} are needed: record longer")
    steps = np.diff(columns["time_s"])
    period_s = float(np.median(steps))
    back = np.flatnonzero(steps <= 0.0)
    if back.size:
        raise InputError(f"{file}, row {back[0] + 2}: time_s: does not increase: sort the rows or correct the clock")
    uneven = np.flatnonzero(np.abs(steps - period_s) > _UNEVEN * period_s)
    if uneven.size:
        place = uneven[0]
        raise InputError(f"{file}, row {place + 2}: time_s: step of {steps[place]:.6g} s where {period_s:.6g} s is usual: sample evenly")
    mean_s = float((columns["time_s"][-1] - columns["time_s"][0]) / (rows - 1))
    return _record(columns, mean_s, file)
