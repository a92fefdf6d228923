"""What in converted records cannot be right: drives that drive nothing, signals that contradict each other, a sign against the other, sizes that no machine has."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError, MissingSignal
from ema_tools.data.motion_records import DRIVES, MOTIONS, VOLTAGES, MotionRecord
from ema_tools.data.motion_signals import Train, drive_torque, integrated, motor_speed
from ema_tools.data.tables.drives_agree import check_drives
from ema_tools.data.tables.lost_signs import check_signs
from ema_tools.data.tables.motions_agree import check_motions
from ema_tools.data.tables.plausible_units import check_speeds
from ema_tools.data.tables.rate import TableRemark
from ema_tools.data.tables.signal_names import spoken
from ema_tools.data.tables.table_map import TableMap
from ema_tools.data.tables.units import EXAMPLES, suffix_of

_EXPLAINS = 0.3  # share of the drive's variance that a term must explain before its sign is believed [judgement]
_MOVES_SHARE = 0.05  # of the largest speed: slower rows say nothing about the direction [judgement]
_CHANGES_SHARE = 0.2  # of the largest speed: where it varies by less it is held and not changed [judgement]
_INERTIA_TIMES = 5.0  # times the stated inertia, or its inverse, that is still a load that nobody counted: minutes for seconds are 9.5, percent 100 [judgement]
_INERTIA_WITHIN = 0.3  # of the stated inertia: data sheets and a first look at records are off by less together [judgement]
_MEAN_S = (
    0.02  # over which drive and speed are averaged before they are compared: shorter than what moves a machine with its load [judgement]
)
_MANY_TIMES = 10.0  # nominal values: motors give three to five times of it for a moment [physics]
# Larger than what any machine of this kind has: 200000 turns a minute, and what the lists of parameters allow. [physics]
_LARGEST = {
    "motor_speed_rad_s": 2.1e4,
    "speed_mm_s": 1e5,
    "position_mm": 1e5,
    "motor_position_mm": 1e5,
    "torque_Nm": 1e4,
    "current_A": 5e3,
    "force_N": 1e8,
}


def check(records: Sequence[MotionRecord], mapped: TableMap, unnamed: Mapping[str, str]) -> tuple[TableRemark, ...]:
    """Looks at all records of an import together. Raises InputError for what cannot be right; answers what is only odd, and by which factor signals of one motion agree.

    `unnamed`: the file's names of the columns whose unit no file names, by the record's.
    """
    train = Train(mapped.mm_per_rad)
    for name in dict.fromkeys(name for record in records for name in record.present):
        if not mapped.columns[name].sure:
            _sizes(name, records, mapped)
    _standing(records, mapped)
    check_signs(records, mapped)
    told = check_motions(records, mapped)
    check_drives(records, mapped)
    check_speeds(records, mapped, unnamed)
    return (*told, *_asked(records, mapped), *_held(records, mapped), *_power(records, mapped, train))


def _asked(records: Sequence[MotionRecord], mapped: TableMap) -> list[TableRemark]:
    """What the machine is asked for, by its name in the file, in the place of what it does."""
    names = dict.fromkeys(name for record in records for name in record.present if name in (*MOTIONS, *DRIVES))
    taken = [(name, mapped.columns[name]) for name in names if not mapped.columns[name].sure]
    return [
        TableRemark("setpoint", None, None, name, entry.source)
        for name, entry in taken
        if isinstance(entry.source, str) and spoken(entry.source, suffix_of(name), mapped.units).role == "asked"
    ]


def _all_of(records: Sequence[MotionRecord]) -> str:
    """Several records by the first of them."""
    return records[0].file + (f" and {len(records) - 1} more" if len(records) > 1 else "")


def _sizes(name: str, records: Sequence[MotionRecord], mapped: TableMap) -> None:
    nominal = {
        "torque_Nm": "nominal_torque",
        "current_A": "nominal_current",
        "force_N": "nominal_force",
        "motor_speed_rad_s": "nominal_speed",
    }.get(name, "")
    for record in records:
        values = record.channel(name)
        if values is None:
            continue
        size = float(np.median(np.abs(values)))
        if size > _LARGEST.get(name, math.inf):
            raise InputError(f"{record.file}: {name}: is {size:.3g} in its middle, more than any machine has: {_correct(name, mapped)}")
        if size > _MANY_TIMES * mapped.machine.get(nominal, math.inf):
            raise InputError(
                f"{record.file}: {name}: is {size / mapped.machine[nominal]:.3g} times {nominal} of [machine] in its middle: {_correct(name, mapped)}, or correct {nominal}"
            )


def _correct(name: str, mapped: TableMap) -> str:
    entry = mapped.columns[name]
    return f'correct unit = "{entry.unit}" (others are {EXAMPLES[suffix_of(name)]}) or scale in [columns.{name}] of {mapped.file}'


def _standing(records: Sequence[MotionRecord], mapped: TableMap) -> None:
    """Raises InputError for a motion or a drive that is the same number in all rows of all records."""
    for name in dict.fromkeys(name for record in records for name in record.present if name in (*MOTIONS, *DRIVES)):
        values = [record.recorded(name) for record in records if name in record.present]
        if not mapped.columns[name].sure and len({float(one) for part in values for one in (part.min(), part.max())}) == 1:
            raise InputError(
                f"{_all_of(records)}: {name}: is {values[0][0]:g} in all rows: correct from in [columns.{name}] of {mapped.file}, or write sure = true there"
            )


def _held(records: Sequence[MotionRecord], mapped: TableMap) -> list[TableRemark]:
    """A voltage as the only drive that is the same number in all rows: a supply's, or that of a machine which is switched on and off."""
    if any(name in record.present for record in records for name in DRIVES):
        return []
    names = dict.fromkeys(name for record in records for name in record.present if name in VOLTAGES and not mapped.columns[name].sure)
    values = {name: [record.recorded(name) for record in records if name in record.present] for name in names}
    return [
        TableRemark("held", None, {"value": float(parts[0][0])}, name)
        for name, parts in values.items()
        if len({float(one) for part in parts for one in (part.min(), part.max())}) == 1
    ]


@dataclass(frozen=True)
class _Rows:
    """Drive, speed, acceleration and place, from the middle of each record's own, of all records."""

    drive: Reals
    speed: Reals
    acceleration: Reals
    place: Reals


def _rows(records: Sequence[MotionRecord], mapped: TableMap, train: Train) -> tuple[_Rows, str, str] | None:
    """All rows in one, and the names of drive and motion; None when there is none to compare."""
    parts: list[tuple[Reals, Reals, Reals, Reals]] = []
    drive_name = motion_name = ""
    for record in records:
        try:
            drive = drive_torque(record, train, mapped.machine.get("torque_constant", 1.0))
            speed = motor_speed(record, train)
        except MissingSignal:
            # without a lead a force still goes with the rod's own motion
            names = [name for name in ("position_mm", "speed_mm_s") if name in record.present]
            drives = [name for name in DRIVES if name in record.present]
            if not names or not drives:
                continue
            values = record.recorded(names[0])
            rod = values if names[0] == "speed_mm_s" else np.gradient(values, record.period_s)
            parts.append(_meant(record.recorded(drives[0]), rod, record.period_s))
            drive_name, motion_name = drives[0], names[0]
            continue
        parts.append(_meant(drive.values, speed.values, record.period_s))
        drive_name, motion_name = drive.column, speed.column
    if not parts or mapped.columns[drive_name].sure or mapped.columns[motion_name].sure:
        return None
    return _Rows(*(np.concatenate([part[k] for part in parts]) for k in range(4))), drive_name, motion_name


def _meant(drive: Reals, speed: Reals, period_s: float) -> tuple[Reals, Reals, Reals, Reals]:
    """Drive, speed, acceleration and place without the noise of a position that was differentiated: moving means."""
    width = min(max(1, round(_MEAN_S / period_s)), drive.size // 8)
    if width > 1:
        window = np.full(width, 1.0 / width)
        drive, speed = np.convolve(drive, window, mode="valid"), np.convolve(speed, window, mode="valid")
    place = integrated(speed, period_s)
    return drive, speed, _acceleration(speed, period_s), place - float(np.mean(place))


def _acceleration(speed: Reals, period_s: float) -> Reals:
    """Of a record that changes its speed, [rows]; zero where a controller only holds it, whose ripple is no push of the drive."""
    held = float(np.std(speed)) < _CHANGES_SHARE * float(np.max(np.abs(speed), initial=0.0))
    return np.zeros_like(speed) if held else np.asarray(np.gradient(speed, period_s))


def _power(records: Sequence[MotionRecord], mapped: TableMap, train: Train) -> tuple[TableRemark, ...]:
    """Drive against motion: a drive overcomes friction and speeds up the mass. Raises InputError where it does neither but the reverse, in all records or in one of them."""
    found = _rows(records, mapped, train)
    if found is None:
        return ()
    every, drive_name, motion_name = found
    _one_sign(records, mapped, train, (drive_name, motion_name))
    rows, columns, along, against = _ways(every)
    told: list[TableRemark] = []
    if against and not along:
        raise InputError(
            f"{_all_of(records)}: {drive_name} {_reversed(against)}, as {motion_name} has it: write sign = {-mapped.columns[drive_name].sign:g} in [columns.{drive_name}] of {mapped.file},"
            f" or the other sign in [columns.{motion_name}]"
        )
    if "inertia" in along and mapped.inertia_kgm2 > 0.0 and (drive_name != "current_A" or "torque_constant" in mapped.machine):
        told += _inertia(columns, rows.drive, records, mapped, (drive_name, motion_name))
    if "friction" not in columns and not along and float(np.mean(rows.drive * rows.speed)) < 0.0:
        told.append(TableRemark("one_way", None, None, drive_name))
    return tuple(told)


def _one_sign(records: Sequence[MotionRecord], mapped: TableMap, train: Train, names: tuple[str, str]) -> None:
    """Raises InputError for the records in which drive and motion go together other than in most of them."""
    ways: dict[bool, list[str]] = {True: [], False: []}
    for record in records:
        own = _rows([record], mapped, train)
        if own is not None:
            _, _, along, against = _ways(own[0])
            if bool(along) is not bool(against):
                ways[bool(along)].append(record.file)
    if ways[True] and ways[False]:
        odd = min(ways.values(), key=len)
        raise InputError(
            f"{', '.join(odd)}: {names[0]} goes {'along with' if odd is ways[True] else 'against'} {names[1]}, unlike the other records: its sign is another there:"
            f" import {'these files' if len(odd) > 1 else 'this file'} by a map of {'their' if len(odd) > 1 else 'its'} own, with the other sign in [columns.{names[0]}] than in {mapped.file}"
        )


def _ways(every: _Rows) -> tuple[_Rows, dict[str, Reals], list[str], list[str]]:
    """The rows that move, their columns, and what of inertia and friction the drive surely goes along with and against; friction is there where the motion goes both ways."""
    # at rest friction answers whatever the drive does
    moves = np.abs(every.speed) > _MOVES_SHARE * float(np.max(np.abs(every.speed), initial=0.0))
    rows = _Rows(every.drive[moves], every.speed[moves], every.acceleration[moves], every.place[moves])
    direction = np.sign(rows.speed)
    columns = {"inertia": rows.acceleration, "one": np.ones_like(rows.drive)}
    if np.any(direction > 0.0) and np.any(direction < 0.0):
        # beside what a spring or the weight of an arm does, which is no inertia
        columns.update({"friction": direction, "place": rows.place})
    signs: dict[str, float] = {name: _signed_share(columns, name, rows.drive) for name in ("inertia", "friction") if name in columns}
    along = [name for name, share in signs.items() if share > _EXPLAINS]
    return rows, columns, along, [name for name, share in signs.items() if share < -_EXPLAINS]


def _reversed(against: Sequence[str]) -> str:
    return " and ".join("brakes in both directions" if name == "friction" else "slows down while the speed rises" for name in against)


def _inertia(
    columns: dict[str, Reals], drive: Reals, records: Sequence[MotionRecord], mapped: TableMap, names: tuple[str, str]
) -> list[TableRemark]:
    """What the records show of the inertia where it is not what the map states. Raises InputError where it is far from that: a unit of either signal is then wrong, or the inertia."""
    matrix = np.column_stack(list(columns.values()))
    scale = np.maximum(np.linalg.norm(matrix, axis=0), np.finfo(np.float64).tiny)
    times = float(np.linalg.lstsq(matrix / scale, drive, rcond=None)[0][0] / scale[0]) / mapped.inertia_kgm2
    if not 1.0 / _INERTIA_TIMES < times < _INERTIA_TIMES:
        raise InputError(
            f"{_all_of(records)}: {names[0]} speeds up {times:.3g} times the inertia of [machine]: correct unit or scale in [columns.{names[0]}] or [columns.{names[1]}]"
            f" of {mapped.file}, or inertia and mass{', lead or ratio' if mapped.mm_per_rad else ''} in [machine]"
        )
    differs = not 1.0 / (1.0 + _INERTIA_WITHIN) <= times <= 1.0 + _INERTIA_WITHIN
    return [TableRemark("inertia", None, {"times": times}, *names)] if differs else []


def _signed_share(columns: dict[str, Reals], name: str, drive: Reals) -> float:
    """Share of the drive's variance that one column explains beside the others, with the sign of its coefficient."""
    others = np.column_stack([values for key, values in columns.items() if key != name])
    scale = float(np.std(columns[name]))
    if scale == 0.0:
        return 0.0
    own = columns[name] / scale
    rest = drive - others @ np.linalg.lstsq(others, drive, rcond=None)[0]
    apart = own - others @ np.linalg.lstsq(others, own, rcond=None)[0]
    size = float(apart @ apart) * float(rest @ rest)
    along = float(apart @ rest)
    return math.copysign(along * along / size, along) if size > 0.0 and float(apart @ apart) > 1e-9 * own.size else 0.0
