"""Recordings of a machine whose controller is not known: a motion and a drive, each in whatever form was recorded, and what follows of them for the motor shaft.

Beside the columns of `ema_tools.data.records` they have the motor's own angle and speed, torque or force in place of a current, the voltage at the motor's terminals, known
disturbances and the temperature. Steps from 10 us to 1 s.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.base.files import one_line, readable, write_text
from ema_tools.data.records import Record

# Any of these is a motion, any of those a drive; with the motor's data the voltage is one too.
MOTIONS = ("position_mm", "motor_position_mm", "speed_mm_s", "motor_angle_rad", "motor_speed_rad_s")
# What helps with a file that has other columns, or other names for them.
FOREIGN = "; of a file as another maker's drive wrote it: ema import draft FILE -o MAP.toml, then ema import table"
DRIVES = ("torque_Nm", "force_N", "current_A")
VOLTAGES = ("voltage_V", "terminal_voltage_V")
COLUMNS: Mapping[str, str] = {
    "command_mm": "asked position of the rod",
    "position_mm": "position of the rod",
    "motor_position_mm": "the motor encoder's reading expressed at the rod",
    "speed_mm_s": "speed of the rod",
    "motor_angle_rad": "angle of the motor shaft",
    "motor_speed_rad_s": "speed of the motor shaft",
    "current_A": "motor current",
    "torque_Nm": "torque of the motor at its shaft",
    "force_N": "force of the drive at the rod",
    "voltage_V": "motor voltage that is asked for",
    "terminal_voltage_V": "voltage measured at the motor's terminals",
    "disturbance_Nm": "known torque against the motion's positive direction, at the motor shaft",
    "disturbance_N": "known force against the motion's positive direction, at the rod",
    "temperature_C": "temperature of the machine",
}
PERIOD_MIN_S = 1e-5  # the shortest step of a record [layout]
PERIOD_MAX_S = 1.0  # the longest [layout]
ROWS_MIN = 8  # fewer rows show no motion [judgement]
_UNEVEN_SHARE = 0.01  # share of a step by which a row's time may be off an even rate: as many percent of the speed at most are then an error of the clock [precision]


@dataclass(frozen=True)
class MotionRecord:
    """One recording; every array has shape [rows], what is not recorded is None. `file` is shown in messages.

    `start_rad`: what the motor's angle is taken to be in the first row where only a speed is recorded, and nobody knows it.
    """

    period_s: float
    file: str = "record"
    first_time_s: float = 0.0
    start_rad: float = 0.0
    command_mm: Reals | None = None
    position_mm: Reals | None = None
    motor_position_mm: Reals | None = None
    speed_mm_s: Reals | None = None
    motor_angle_rad: Reals | None = None
    motor_speed_rad_s: Reals | None = None
    current_A: Reals | None = None
    torque_Nm: Reals | None = None
    force_N: Reals | None = None
    voltage_V: Reals | None = None
    terminal_voltage_V: Reals | None = None
    disturbance_Nm: Reals | None = None
    disturbance_N: Reals | None = None
    temperature_C: Reals | None = None

    @property
    def present(self) -> tuple[str, ...]:
        """Names of the recorded columns except time."""
        return tuple(name for name in COLUMNS if getattr(self, name) is not None)

    @property
    def rows(self) -> int:
        """Number of samples."""
        return int(self.recorded(self.present[0]).size)

    @property
    def time_s(self) -> Reals:
        """Time of each row, [rows]."""
        return self.first_time_s + self.period_s * np.arange(self.rows, dtype=np.float64)

    @property
    def motor_voltage_V(self) -> Reals | None:
        """The voltage at the motor's terminals, else that which is asked for, [rows]; None without either."""
        return self.terminal_voltage_V if self.terminal_voltage_V is not None else self.voltage_V

    def channel(self, name: str) -> Reals | None:
        """A recorded column by name, None when it is absent."""
        found: Reals | None = getattr(self, name)
        return found

    def recorded(self, name: str) -> Reals:
        """A column that is there. Raises KeyError when it is not."""
        values = self.channel(name)
        if values is None:
            raise KeyError(name)
        return values

    def with_columns(self, columns: Mapping[str, Reals | None]) -> MotionRecord:
        """A copy with some columns replaced."""
        changed: dict[str, Any] = dict(columns)
        return replace(self, **changed)


# A recording of any machine.
AnyRecord = Record | MotionRecord


def same_samples(one: AnyRecord, other: AnyRecord) -> bool:
    """Whether two records are one, however their files are called."""
    names = [name for name in one.present if name in other.present]
    return bool(names) and one.rows == other.rows and all(np.array_equal(one.recorded(name), other.recorded(name)) for name in names)


def of_controlled(record: Record) -> MotionRecord:
    """A record of a machine whose controller is known, as one of any machine."""
    return MotionRecord(record.period_s, record.file, record.first_time_s).with_columns(
        {name: record.recorded(name) for name in record.present}
    )


def _no_motion(record: AnyRecord) -> InputError:
    return InputError(f"{record.file}: no motion: needs one of the columns {', '.join(MOTIONS)}{FOREIGN}")


def motion_signal(record: AnyRecord) -> Reals:
    """The first of the recorded motions, [rows]. Raises InputError where there is none."""
    for name in MOTIONS:
        values: Reals | None = getattr(record, name, None)
        if values is not None:
            return values
    raise _no_motion(record)


def mean_speed(record: AnyRecord) -> float:
    """Of the first of the recorded motions, in its unit per second."""
    name = next(name for name in MOTIONS if getattr(record, name, None) is not None)
    values = motion_signal(record)
    return float(np.mean(values)) if name.endswith("_s") else float(values[-1] - values[0]) / (record.period_s * (values.size - 1))


def check_signals(record: MotionRecord, voltage_serves: bool = False) -> None:
    """Raises InputError when a motion or a drive is missing; a voltage is a drive where `voltage_serves`."""
    if not any(name in record.present for name in MOTIONS):
        raise _no_motion(record)
    drives = (*DRIVES, *VOLTAGES) if voltage_serves else DRIVES
    if not any(name in record.present for name in drives):
        more = "" if voltage_serves else ", or voltage_V and an actuator with the motor's resistance_ohm and back_emf_V_s_per_rad"
        raise InputError(f"{record.file}: no drive: needs one of the columns {', '.join(drives)}{more}{FOREIGN}")


def read_motion_record(path: str | Path) -> MotionRecord:
    """Read a recording: CSV with `#` comments and one header row, MATLAB .mat, or Parquet; other columns are ignored.

    Raises InputError in one line that names file, row and field.
    """
    from ema_tools.data.tables.read import read_table
    from ema_tools.data.tables.text import Stated

    table = read_table(
        path,
        Stated(encoding="utf-8-sig", delimiter="comma", decimal="point")
        if Path(path).suffix.lower() not in (".mat", ".parquet", ".pq")
        else None,
    )
    file = readable(Path(path).name)
    if table.cut_row is not None:
        raise InputError(f"{file}: row {table.cut_row}: ends before its last field: delete it or record again")
    columns: dict[str, Reals] = {}
    for column in table.columns:
        if column.name != "time_s" and column.name not in COLUMNS:
            continue
        bad = np.flatnonzero(~np.isfinite(column.values))
        if bad.size:
            what = f'"{column.texts[int(bad[0])]}" is not a finite number' if int(bad[0]) in column.texts else "holds no finite number"
            raise InputError(
                f"{file}: row {table.rows[bad[0]]}, {column.name}: {what}: correct it, or use ema import table, which cuts the record there"
            )
        columns[column.name] = column.values
    if "time_s" not in columns:
        raise InputError(
            f"{file}: time_s: column missing: rename the column with the time, or use ema import table for a file of another maker"
        )
    time_s = columns.pop("time_s")
    if not columns:
        raise InputError(
            f"{file}: none of the columns {', '.join(COLUMNS)} is there: rename them, or use ema import table for a file of another maker"
        )
    period_s = _period(time_s, table.rows, file)
    record = MotionRecord(period_s, file, float(time_s[0])).with_columns(
        {name: np.ascontiguousarray(values) for name, values in columns.items()}
    )
    check_signals(record, voltage_serves=True)
    return record


def _period(time_s: Reals, rows: Any, file: str) -> float:
    """The step of an even time. Raises InputError that names the first row that is off."""
    if time_s.size < ROWS_MIN:
        raise InputError(f"{file}: has {time_s.size} rows: at least {ROWS_MIN} are needed: record longer")
    period_s = float((time_s[-1] - time_s[0]) / (time_s.size - 1))
    even = time_s[0] + period_s * np.arange(time_s.size)
    off = np.flatnonzero(np.abs(time_s - even) > _UNEVEN_SHARE * abs(period_s) + 1e-9)
    steps = np.diff(time_s)
    if off.size or period_s <= 0.0:
        common = float(np.median(steps))
        wrong = np.flatnonzero(np.abs(steps - common) > _UNEVEN_SHARE * abs(common) + 1e-9)
        row = rows[int(wrong[0]) + 1] if wrong.size else rows[int(off[0])]
        raise InputError(
            f"{file}: row {row}, time_s: the rate is not constant, {common:g} s before: resample it, or use ema import table, which does"
        )
    if not PERIOD_MIN_S * (1.0 - 1e-9) <= period_s <= PERIOD_MAX_S * (1.0 + 1e-9):
        raise InputError(
            f"{file}: time_s: steps of {period_s:g} s: records have {PERIOD_MIN_S:g} to {PERIOD_MAX_S:g} s: give the time in seconds"
        )
    return float(f"{period_s:.12g}")


def write_motion_record(path: str | Path, record: MotionRecord, comments: tuple[str, ...] = (), force: bool = False) -> None:
    """Write a CSV with `#` comments, one header row and the recorded columns, 12 digits each: more than any sensor has.

    Raises InputError when the file exists and `force` is not set, or cannot be written.
    """
    names = record.present
    numbers = np.column_stack([record.recorded(name) for name in names])
    lines = [f"# {one_line(line)}" for line in comments]
    lines.append(",".join(("time_s", *names)))
    row = ",".join(["%.12g"] * (1 + len(names)))
    lines.extend(row % (time, *values) for time, values in zip(record.time_s.tolist(), numbers.tolist(), strict=True))
    write_text(path, "\n".join(lines) + "\n", force)
