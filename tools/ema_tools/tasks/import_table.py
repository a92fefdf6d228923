"""Files of any maker as records and an actuator to start from: what `ema import table` does; and the map to complete, what `ema import draft` does."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ema_tools.balances.filtering import Smoother
from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError, MissingSignal
from ema_tools.base.files import keep_apart, may_write, write_text
from ema_tools.data.actuator import FROM_RECORDS, NONE_TAKEN, Actuator, reference_actuator
from ema_tools.data.incomplete import NONE_OF_IT
from ema_tools.data.motion_records import DRIVES, VOLTAGES, MotionRecord, same_samples, write_motion_record
from ema_tools.data.motion_signals import Origin, Train, drive_torque, integrated, motor_speed, origins
from ema_tools.data.tables import doubts
from ema_tools.data.tables.convert import Converted, convert
from ema_tools.data.tables.draft import Draft, draft_map
from ema_tools.data.tables.rate import TableRemark
from ema_tools.data.tables.read import files_of, read_table
from ema_tools.data.tables.table_map import TableMap, read_map
from ema_tools.data.tables.units import Units

Tell = Callable[[float, str], None]
ACTUATOR = "actuator.toml"
_DIGITS = 6  # of the values that are written: more than any data sheet states [precision]
_ERRORS = 5.0  # standard errors by which an inertia must exceed zero before records are said to show it [chance]
_PADDING = 15  # rows that the smoother mirrors at each end [precision]
_MOVES_SHARE = 0.05  # of the largest speed: slower rows say nothing about the friction [judgement]
# Entries of the map and the values of the actuator that they are, besides the inertia.
_VALUES: Mapping[str, str] = {
    "lead": "screw.lead_mm",
    "ratio": "gearbox.ratio",
    "torque_constant": "motor.torque_constant_Nm_per_A",
    "back_emf": "motor.back_emf_V_s_per_rad",
    "resistance": "motor.resistance_ohm",
    "inductance": "motor.inductance_H",
}
# Sections of values of a machine.
_MACHINE = ("control", "drive", "motor", "gearbox", "screw", "encoder", "timing")
# What every machine has, and what a record shows of it.
LOAD = "screw.load_torque_Nm"
_STATED = ("screw.inertia_kgm2", "screw.viscous_Nm_s_per_rad", "screw.csj_Nm", LOAD)


@dataclass(frozen=True)
class TablesImported:
    """What an import wrote: the records of each file with their places, the actuator, and of what motion and drive at the shaft are made.

    `estimated`: values that are not from the map but from the records.
    """

    mapped: TableMap
    files: tuple[Converted, ...]
    places: tuple[tuple[Path, ...], ...]
    actuator_path: Path
    actuator: Actuator
    estimated: tuple[str, ...]
    signals: Mapping[str, tuple[Origin, str]]
    remarks: tuple[TableRemark, ...]

    @property
    def records(self) -> tuple[MotionRecord, ...]:
        """Of all files, in order."""
        return tuple(record for one in self.files for record in one.records)


def write_draft(path: str | Path, target: str | Path, force: bool = False) -> Draft:
    """Look at a file, of a folder at its first, and write its map to complete. Raises InputError."""
    units = Units()
    draft = draft_map(read_table(files_of([path])[0], None, units), units)
    write_text(target, draft.text, force)
    return draft


def import_tables(names: Sequence[str | Path], map_path: str | Path, folder: str | Path, force: bool, tell: Tell) -> TablesImported:
    """Convert all files by the map and write their records and an actuator into `folder`. Nothing is written when anything is wrong. Raises InputError."""
    mapped = read_map(map_path)
    units = mapped.units
    paths = files_of(names)
    files = []
    for number, path in enumerate(paths):
        tell(number / len(paths), path.name)
        files.append(convert(path, mapped, units))
    files = _said_once(_named_apart(files))
    records = [record for one in files for record in one.records]
    unnamed = {name: column for one in files for name, column in one.unnamed.items()}
    remarks = (*_assumed(unnamed, mapped), *doubts.check(records, mapped, unnamed))
    actuator, estimated = start_machine(records, mapped)
    remarks = (*remarks, *_frictionless(records, actuator, estimated))
    target = Path(folder)
    places = tuple(tuple(target / record.file for record in one.records) for one in files)
    every = [target / ACTUATOR, *(place for part in places for place in part)]
    keep_apart(every, [*paths, map_path])
    for place in every:
        may_write(place, force)
    for one, part in zip(files, places, strict=True):
        for record, place in zip(one.records, part, strict=True):
            write_motion_record(place, record, (f"From {one.path.name} by {mapped.file}.",), force)
    actuator.write(target / ACTUATOR, force)
    remarks = (*remarks, *_others(target, {place for part in places for place in part}))
    return TablesImported(mapped, tuple(files), places, target / ACTUATOR, actuator, estimated, _signals(records, mapped), remarks)


def _others(folder: Path, written: Collection[Path]) -> tuple[TableRemark, ...]:
    """That a folder holds records beside those that were written."""
    count = sum(1 for one in folder.glob("*.csv") if one not in written)
    return (TableRemark("others", None, {"count": float(count)}, "", str(folder)),) if count else ()


def _named_apart(files: Sequence[Converted]) -> list[Converted]:
    """With the folder before the names of files that are named alike. Raises InputError when that does not tell them apart."""
    stems = Counter(_stem(one.path) for one in files)

    def renamed(one: Converted) -> Converted:
        before = f"{one.path.resolve().parent.name}_" if stems[_stem(one.path)] > 1 else ""
        return replace(one, records=tuple(replace(record, file=before + record.file) for record in one.records))

    found = [renamed(one) for one in files]
    seen: dict[str, Path] = {}
    for one in found:
        for record in one.records:
            if record.file in seen:
                raise InputError(
                    f"{one.path}: would become {record.file} as {seen[record.file]} does: rename one of the two, or import them into two folders"
                )
            seen[record.file] = one.path
    return found


def _said_once(files: Sequence[Converted]) -> list[Converted]:
    """With a word to every file whose records came before, by another name."""
    found: list[Converted] = []
    for one in files:
        earlier = [record for other in found for record in other.records]
        twins = [next((other.file for other in earlier if same_samples(record, other)), None) for record in one.records]
        copies = tuple(TableRemark("copy", None, None, twin) for twin in twins if twin is not None)
        found.append(replace(one, remarks=one.remarks + copies))
    return found


def _assumed(unnamed: Mapping[str, str], mapped: TableMap) -> tuple[TableRemark, ...]:
    """That units were taken from the map alone."""
    told = ", ".join(f'"{column}" in {mapped.columns[name].unit}' for name, column in unnamed.items() if not mapped.columns[name].sure)
    return (TableRemark("assumed", None, None, told, mapped.file),) if told else ()


def _frictionless(records: Sequence[MotionRecord], actuator: Actuator, estimated: Sequence[str]) -> tuple[TableRemark, ...]:
    """That a drive overcomes no friction, which no machine is without."""
    frictions = _STATED[1:3]
    if any(name not in estimated or actuator[name] > 0.0 for name in frictions):
        return ()
    drive = next(name for name in (*DRIVES, *VOLTAGES) if any(name in record.present for record in records))
    return (TableRemark("frictionless", None, None, drive),)


def _stem(path: Path) -> str:
    return path.name.removesuffix(path.suffix)


def _signals(records: Sequence[MotionRecord], mapped: TableMap) -> dict[str, tuple[Origin, str]]:
    return origins(records[0], Train(mapped.mm_per_rad), mapped.machine.get("torque_constant"))


def start_machine(records: Sequence[MotionRecord], mapped: TableMap) -> tuple[Actuator, tuple[str, ...]]:
    """An actuator without controller, with what the map states, and friction and, where it is not stated, inertia by least squares on all records.

    Raises InputError when the records do not show what is not stated.
    """
    machine = mapped.machine
    train = Train(mapped.mm_per_rad)
    inertia = mapped.inertia_kgm2
    rows = _shaft_rows(records, mapped, train)
    known = inertia > 0.0
    found, std = _least_squares(rows, inertia if known else None)
    estimated = [name for name, entry in zip(_STATED[1:3], ("viscous", "friction"), strict=True) if entry not in machine]
    if not known:
        if not found[0] > _ERRORS * std[0]:
            raise InputError(
                f'{mapped.file}: machine.inertia: is not stated, and the speed does not change enough to show it: write inertia = "21.9 g cm^2" with your machine\'s number, or mass and lead'
            )
        inertia = float(found[0])
        estimated.insert(0, _STATED[0])
    values = {
        _STATED[0]: inertia,
        _STATED[1]: machine.get("viscous", max(0.0, float(found[1]))),
        _STATED[2]: machine.get("friction", max(0.0, float(found[2]))),
        # fitted only beside the others: a load that pulls one way is for a diagnosis to name
        LOAD: 0.0,
        **{value: machine[entry] for entry, value in _VALUES.items() if entry in machine},
    }
    about = {"name": "a machine", **{key: text for key, text in mapped.about.items() if text}}
    about["notes"] = (
        f"To start from: by {mapped.file}; {', '.join(estimated)} by least squares on the imported records. The controller is not known, so it is not here."
    )
    remarks = {**dict.fromkeys(estimated, FROM_RECORDS), LOAD: NONE_TAKEN}
    reference = reference_actuator()
    stated = {**reference.values, **NONE_OF_IT}
    absent = frozenset(row for row in reference.values if row not in values and row not in NONE_OF_IT and row.partition(".")[0] in _MACHINE)
    try:
        return Actuator(values=stated, about=about, file=ACTUATOR, absent=absent).changed(
            {name: float(f"{number:.{_DIGITS}g}") for name, number in values.items()}, remarks=remarks
        ), tuple(estimated)
    except InputError as error:
        raise InputError(f"{mapped.file}: gives {error}, or correct the units of the columns") from None


def _shaft_rows(records: Sequence[MotionRecord], mapped: TableMap, train: Train) -> tuple[Reals, Reals, Reals, Reals]:
    """Drive torque, speed, acceleration and angle, from the middle of each record's own, at the shaft in all rows of all records, smoothed. Raises InputError when they cannot be had."""
    parts = []
    for record in records:
        try:
            speed = motor_speed(record, train).values
            torque = _torque(record, mapped, train, speed)
        except MissingSignal as error:
            entry = "torque_constant" if "torque_constant" in str(error) else "lead"
            example = (
                '"25.9 mNm/A"' if entry == "torque_constant" else '"2 mm" (and ratio; where nothing turns any lead serves, such as "1 mm")'
            )
            raise InputError(f"{mapped.file}: machine.{entry}: is needed, {error}: write {entry} = {example}") from None
        smoother = Smoother.of(record.period_s)
        if record.rows >= smoother.least_rows + 4 * _PADDING:
            speed, torque = smoother.smooth(speed), smoother.smooth(torque)
        angle = integrated(speed, record.period_s)
        parts.append((torque, speed, np.gradient(speed, record.period_s), angle - float(np.mean(angle))))
    torque, speed, acceleration, angle = (np.concatenate([part[k] for part in parts]) for k in range(4))
    return torque, speed, acceleration, angle


def _torque(record: MotionRecord, mapped: TableMap, train: Train, speed_rad_s: Reals) -> Reals:
    """Torque of the drive, [rows]; from a voltage by the winding at rest of its current."""
    voltage = record.motor_voltage_V
    machine = mapped.machine
    if voltage is not None and record.current_A is None and record.torque_Nm is None and record.force_N is None:
        return machine["torque_constant"] * (voltage - machine["back_emf"] * speed_rad_s) / machine["resistance"]
    return drive_torque(record, train, machine.get("torque_constant")).values


def _least_squares(rows: tuple[Reals, Reals, Reals, Reals], inertia: float | None) -> tuple[Reals, Reals]:
    """Inertia, viscous friction, dry friction and load, and their standard errors, [4]; the inertia as given where it is, else told from a spring or a weight that goes with the place."""
    torque, speed, acceleration, angle = rows
    moves = np.abs(speed) > _MOVES_SHARE * float(np.max(np.abs(speed), initial=0.0))
    direction = np.sign(speed)
    columns = np.column_stack([acceleration, speed, direction, np.ones_like(speed), angle])[moves]
    target = torque[moves] - (inertia * columns[:, 0] if inertia is not None else 0.0)
    free = [0, 1, 2, 3, 4] if inertia is None else [1, 2, 3]
    # one way alone friction and load are one: the friction then takes it, and no load is claimed
    if np.unique(direction[moves]).size < 2:
        free = [k for k in free if k < 3]
    found, std = np.zeros(5), np.zeros(5)
    if inertia is not None:
        found[0] = inertia
    matrix = columns[:, free]
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale == 0.0] = 1.0
    solved, *_ = np.linalg.lstsq(matrix / scale, target, rcond=None)
    residual = target - (matrix / scale) @ solved
    spread = np.linalg.pinv((matrix / scale).T @ (matrix / scale)) * float(residual @ residual) / max(1, target.size - len(free))
    found[free], std[free] = solved / scale, np.sqrt(np.diag(spread)) / scale
    return found[:4], std[:4]
