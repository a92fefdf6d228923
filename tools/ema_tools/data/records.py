"""Recordings: read from CSV (by the C reader, so that there is one parser), MATLAB .mat or Parquet, and written as CSV.

A recording has one row per sample at a constant rate. `time_s`, `command_mm` and `position_mm` (rod) are required;
`motor_position_mm`, `current_A`, `voltage_V` (applied over the interval that starts at the row) and `speed_mm_s` are used when present.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.base.files import one_line, read_again, readable, reason, write_text
from ema_tools.data.actuator import Actuator
from ema_tools.data.machine_state import digest
from ema_tools.plant.native import CHANNELS, RECORD_COLUMNS, Simulation, library

COLUMNS = RECORD_COLUMNS


@dataclass(frozen=True)
class Record:
    """One recording; every array has shape [rows], absent signals are None. `file` is shown in messages.

    `path` and `sha256`: the file that it was read from and the digest of its content; empty for what was not read from a file.
    """

    period_s: float
    command_mm: Reals
    position_mm: Reals
    motor_position_mm: Reals | None = None
    current_A: Reals | None = None
    voltage_V: Reals | None = None
    speed_mm_s: Reals | None = None
    file: str = "record"
    first_time_s: float = 0.0
    path: str = ""
    sha256: str = ""

    @property
    def rows(self) -> int:
        """Number of samples."""
        return int(self.command_mm.size)

    @property
    def time_s(self) -> Reals:
        """Time of each row, [rows]."""
        return self.first_time_s + self.period_s * np.arange(self.rows, dtype=np.float64)

    @property
    def present(self) -> tuple[str, ...]:
        """Names of the recorded columns except time."""
        return tuple(name for name in COLUMNS[1:] if getattr(self, name) is not None)

    def on_supply(self, share: float) -> Record:
        """The same with the voltage of a supply that gives more, by a share, than the one of which it was asked."""
        return self if self.voltage_V is None else replace(self, voltage_V=(1.0 + share) * self.voltage_V)

    def channel(self, name: str) -> Reals | None:
        """A recorded column by name, None when it is absent."""
        found: Reals | None = getattr(self, name)
        return found

    def table(self) -> Reals:
        """The channels of the C module, [rows, 4], NaN where not recorded."""
        absent = np.full(self.rows, np.nan)
        return np.column_stack([self.recorded(name) if name in self.present else absent for name in CHANNELS])

    def recorded(self, name: str) -> Reals:
        """A column that is there. Raises KeyError when it is not."""
        values = self.channel(name)
        if values is None:
            raise KeyError(name)
        return values

    def with_columns(self, columns: Mapping[str, Reals]) -> Record:
        """A copy with some columns replaced."""
        changed: dict[str, Any] = dict(columns)
        return replace(self, **changed)

    def with_noise(self, std: Mapping[str, float], seed: int) -> Record:
        """A copy with white Gaussian noise of standard deviation `std[column]` added, the same for the same seed."""
        random = np.random.default_rng(seed)
        changed = {}
        for name in COLUMNS[1:]:
            if name in std:
                if name not in self.present:
                    raise InputError(f"{self.file}: noise on {name}: the column is not there: name one of {', '.join(self.present)}")
                changed[name] = self.recorded(name) + random.normal(0.0, std[name], self.rows)
        return self.with_columns(changed)


# How many standard deviations of sensor noise, besides half the play, the first position may be off a command at which the rod rests: as
# the onboard session [chance]
_START_NOISE = 4.0


def start_of(actuator: Actuator, record: Record) -> float:
    """Where a simulation of the record starts from rest, mm; the onboard session's rule: at the command where the rod may rest there, else
    at the first rod position."""
    command, position = float(record.command_mm[0]), float(record.position_mm[0])
    doubt = 0.5 * actuator["search.blk_upper_mm"] + _START_NOISE * actuator["verdict.position_noise_mm"]
    return command if abs(position - command) <= doubt else position


def simulated(actuator: Actuator, record: Record, bits: int = 64) -> Simulation:
    """The actuator under the record's command, every array [rows]. Raises InputError when the model refuses."""
    values, options = actuator.arrays()
    return library(bits).simulate(values, options, record.command_mm, start_of(actuator, record))


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
    numbers = np.column_stack([record.recorded(name) for name in names])
    lines = [f"# {one_line(line)}" for line in comments]
    lines.append(",".join(("time_s", *names)))
    row = "%.12g," + ",".join([shape] * len(names))
    lines.extend(row % (time, *values) for time, values in zip(record.time_s.tolist(), numbers.tolist(), strict=True))
    write_text(path, "\n".join(lines) + "\n", force)


def read_record(path: str | Path, actuator: Actuator | None = None) -> Record:
    """Read a recording; the ending decides the format (.mat, .parquet, else CSV). With `actuator`, units and rate are checked against it.

    Raises InputError in one line that names file, row and field.
    """
    with read_again(Path(path)) as place:
        ending = place.suffix.lower()
        if ending in (".mat", ".parquet", ".pq"):
            columns = _mat_columns(place) if ending == ".mat" else _parquet_columns(place)
            table, mask = _table(columns, str(path))
            period_s = library().check_table(str(path), table, mask)
        else:
            table, mask, period_s = library().read_csv(place)
        sha256 = digest(place)
    if actuator is not None:
        library().check_fit(str(path), table, actuator["screw.travel_mm"], actuator.record_period_s)
    arrays = {name: np.ascontiguousarray(table[:, place]) for place, name in enumerate(COLUMNS) if mask >> place & 1 and name != "time_s"}
    return Record(
        period_s=period_s, first_time_s=float(table[0, 0]), file=readable(Path(path).name), path=str(path), sha256=sha256, **arrays
    )


def _table(columns: Mapping[str, object], file: str) -> tuple[Reals, int]:
    """Columns by name as one table [rows, 7] and the bits of those that are there. Raises InputError that names the column."""
    numbers = {}
    for name, values in columns.items():
        try:
            numbers[name] = np.asarray(values, dtype=np.float64).ravel()
        except (TypeError, ValueError):
            raise InputError(f"{file}: {name}: holds something that is not a number: correct it") from None
    rows = max((values.size for values in numbers.values()), default=0)
    for name, values in numbers.items():
        if values.size != rows:
            raise InputError(f"{file}: {name}: {values.size} rows where another column has {rows}: give every column the same length")
    table = np.full((rows, len(COLUMNS)), np.nan)
    mask = 0
    for place, name in enumerate(COLUMNS):
        if name in numbers:
            table[:, place] = numbers[name]
            mask |= 1 << place
    return table, mask


def _exists(path: Path) -> None:
    try:
        path.open("rb").close()
    except OSError as error:
        raise InputError(f"{path}: {reason(error)}: check the path") from None


def _mat_columns(path: Path) -> dict[str, object]:
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    _exists(path)
    try:
        content = loadmat(path)
    except (MatReadError, ValueError, TypeError, NotImplementedError, EOFError, OSError) as error:
        hint = "save it with -v7" if isinstance(error, NotImplementedError) else "save it again from MATLAB"
        raise InputError(f"{path.name}: not a readable .mat file: {hint}") from None
    return {name: content[name] for name in COLUMNS if name in content}


def _parquet_columns(path: Path) -> dict[str, object]:
    import pyarrow
    import pyarrow.parquet

    _exists(path)
    try:
        # Arrow takes no name that is not UTF-8, but any file that is open.
        with path.open("rb") as stream:
            names = pyarrow.parquet.read_schema(stream).names
            table = pyarrow.parquet.read_table(stream, columns=[name for name in COLUMNS if name in names])
    except (pyarrow.ArrowException, OSError):
        raise InputError(f"{path.name}: not a readable Parquet file: write it again") from None
    return {name: table.column(name).to_numpy() for name in table.column_names}
