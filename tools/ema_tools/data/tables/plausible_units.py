"""Units that a file does not name: nobody but its user knows them, so a clock, an angle or a speed that would be odd by the map and usual in another unit is asked about."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError, MissingSignal
from ema_tools.data.motion_records import COLUMNS, MotionRecord
from ema_tools.data.motion_signals import Train, motor_speed, rod_speed
from ema_tools.data.tables.raw import RawColumn
from ema_tools.data.tables.table_map import ColumnMap, TableMap
from ema_tools.data.tables.units import Units

# Steps from row to row of what records machines: a step outside, in a unit that nobody named, is asked about [judgement]
_USUAL_STEP_S = (5e-5, 0.1)
# Steps that another unit must give before it is proposed [judgement]
_LIKELY_STEP_S = (1e-4, 0.1)
_CLOCKS: Mapping[str, float] = {"ms": 1e-3, "s": 1.0, "us": 1e-6, "ns": 1e-9}
# After so much an angle starts again, by its unit.
_TURNS: Mapping[str, float] = {"deg": 360.0, "rad": 2.0 * math.pi, "turn": 1.0}
_WHOLE = (0.9, 1.0001)  # of a turn that an angle spans when it starts again at each [judgement]
_JUMP, _SMALL = 0.5, 0.25  # of a turn: a step back that is a new turn, and steps as they are between [judgement]
# Of a motor 20000 turns a minute, of a rod 20 m/s: faster ones are rare enough to be asked about where no unit is named [judgement]
_FAST_RAD_S, _FAST_MM_S = 2.1e3, 2e4
_MOST = 95.0  # % of the rows that are slower: a spike is no speed [judgement]
# Units that are taken for another one by whoever reads a column of numbers.
_OTHERS: Mapping[str, str] = {"rad": "deg", "rad/s": "rpm", "turn": "rad", "turn/s": "rpm", "m": "mm", "m/s": "mm/s"}
# How far apart two signals are when one of them is in another unit, and how near to it, relative, a factor is taken for it.
_FACTORS: Mapping[float, str] = {
    1000.0: "milliseconds and seconds in [columns.time_s], or m and mm",
    180.0 / math.pi: "degrees and radians",
    30.0 / math.pi: "turns a minute and rad/s",
    2.0 * math.pi: "turns and radians",
    60.0: "minutes and seconds",
    25.4: "inches and mm",
}
_NEAR = 0.03  # an encoder's factor is not known better from a record with noise [judgement]


def is_named(column: RawColumn, units: Units) -> bool:
    """Whether the file says the unit of a column: beside it, in its name, or by a name of this project's records."""
    return column.name in ("time_s", *COLUMNS) or (bool(column.unit) and units.is_unit(column.unit))


def check_step(period_s: float, rows: int, column: RawColumn, entry: ColumnMap, file: str, map_file: str) -> None:
    """Raises InputError for a clock without a named unit whose steps are odd by the map and usual in another unit."""
    own = _CLOCKS.get(entry.unit.strip())
    if own is None or entry.sure or entry.scale != 1.0 or _USUAL_STEP_S[0] <= period_s <= _USUAL_STEP_S[1]:
        return
    fits = [unit for unit, one in _CLOCKS.items() if _LIKELY_STEP_S[0] <= period_s / own * one <= _LIKELY_STEP_S[1]]
    if fits:
        step_s = period_s / own * _CLOCKS[fits[0]]
        raise InputError(
            f'{file}: "{column.name}": no unit is named in the file, and in {entry.unit} its steps are {period_s:g} s and the record is {rows * period_s:.3g} s long:'
            f' write unit = "{fits[0]}" in [columns.time_s] of {map_file} (steps of {step_s:g} s), or sure = true there'
        )


def check_turn(values: Reals, column: RawColumn, entry: ColumnMap, name: str, file: str, map_file: str) -> None:
    """Raises InputError for an angle without a named unit that starts again where a turn ends in another unit than the map's. `values` [rows], as the file has them."""
    own = entry.unit.strip()
    if own not in _TURNS or entry.sure or entry.scale != 1.0:
        return
    seen = values[np.isfinite(values)]
    span, steps = float(np.ptp(seen)) if seen.size else 0.0, np.abs(np.diff(seen))
    for unit, turn in _TURNS.items():
        new = steps > _JUMP * turn
        if unit == own or not _WHOLE[0] * turn <= span <= _WHOLE[1] * turn or not new.any():
            continue
        if float(np.max(np.minimum(steps, np.abs(turn - steps)))) < _SMALL * turn:
            raise InputError(
                f'{file}: "{column.name}": no unit is named in the file, and it starts again after {turn:.4g}, as an angle in {unit} does:'
                f' write unit = "{unit}" in [columns.{name}] of {map_file}, or sure = true there'
            )


def check_speeds(records: Sequence[MotionRecord], mapped: TableMap, unnamed: Mapping[str, str]) -> None:
    """Raises InputError for a machine that would be faster than machines are, where the unit of its motion is not named. `unnamed`: the file's names of such columns, by the record's."""
    train = Train(mapped.mm_per_rad)
    for record in records:
        for way, most, said in ((motor_speed, _FAST_RAD_S, "turns a minute"), (rod_speed, _FAST_MM_S, "m/s")):
            try:
                speed = way(record, train)
            except MissingSignal:
                continue
            name = speed.column
            at_motor = name.startswith("motor_")
            if name not in unnamed or mapped.columns[name].sure or at_motor != (way is motor_speed):
                continue
            fast = float(np.percentile(np.abs(speed.values), _MOST))
            if fast > most:
                entry = mapped.columns[name]
                shown = fast * 30.0 / math.pi if at_motor else 1e-3 * fast
                other = _OTHERS.get(entry.unit.strip())
                better = f'write unit = "{other}" in [columns.{name}]' if other else f"correct unit in [columns.{name}]"
                raise InputError(
                    f'{record.file}: "{unnamed[name]}": no unit is named in the file, and in {entry.unit} the machine does {shown:.3g} {said}:'
                    f" {better} of {mapped.file}, or in [columns.time_s], or write sure = true there where it is so"
                )


def looks_like(times: float) -> str:
    """What a factor between two signals is when units are taken for each other; empty for any other."""
    size = times if times > 1.0 else 1.0 / times
    return next((text for factor, text in _FACTORS.items() if abs(size / factor - 1.0) < _NEAR), "")
