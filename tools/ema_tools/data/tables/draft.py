"""A map to complete: what a file's names, units and numbers say of its columns, each guess marked as one, each thing that only the user knows left open."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ema_tools.base.files import one_line
from ema_tools.data.motion_records import COLUMNS, DRIVES, MOTIONS, VOLTAGES
from ema_tools.data.tables.convert import MOMENTS
from ema_tools.data.tables.rate import even
from ema_tools.data.tables.raw import RawColumn, RawTable
from ema_tools.data.tables.signal_names import Special, SpokenName, is_setpoint_symbol, is_value_symbol, phases_of, spoken
from ema_tools.data.tables.table_map import NUMBERS, OPEN, QUANTITIES
from ema_tools.data.tables.units import EXAMPLES, KINDS, NOMINAL, SHARES, Units, plain_unit, suffix_of

_TERMINAL = re.compile(r"terminal|klemme", re.IGNORECASE)
_AT_MOTOR = re.compile(r"motor|encoder|rotor|drehzahl|shaft|\bmot\b|cnt|counts?\b|\binc(rement)?s?\b", re.IGNORECASE)
_OF_WORD: Mapping[str, tuple[str, ...]] = {
    "temperature": ("temperature_C",),
    "torque": ("torque_Nm",),
    "force": ("force_N",),
    "current": ("current_A",),
    "voltage": ("voltage_V", "terminal_voltage_V"),
    "speed": ("motor_speed_rad_s", "speed_mm_s"),
    "angle": ("motor_angle_rad",),
    "position": ("position_mm", "motor_position_mm", "motor_angle_rad"),
}
_OF_SUFFIX: Mapping[str, tuple[str, ...]] = {
    "rad_s": ("motor_speed_rad_s",),
    "mm_s": ("speed_mm_s",),
    "rad": ("motor_angle_rad",),
    "mm": ("position_mm", "motor_position_mm"),
    "Nm": ("torque_Nm",),
    "N": ("force_N",),
    "A": ("current_A",),
    "V": ("voltage_V",),
    "C": ("temperature_C",),
}
# What turns behind a gear is by the lead a column of the rod.
_BEHIND_GEAR: Mapping[str, str] = {"motor_angle_rad": "position_mm", "motor_speed_rad_s": "speed_mm_s"}
_TURNS_BEHIND = "CHECK: it turns behind the gear, by its name: with ratio and lead in [machine] it is a way; of the motor itself it is motor_angle_rad or motor_speed_rad_s"
_ONE_DEGREE_MM = '"360 mm"  # nothing moves along a line: a millimetre of every degree'
# Drives at the shaft: beside one of them a force that a cell measures is a load.
_AT_SHAFT = frozenset({"torque_Nm", "current_A"})
# Steps from row to row by which a clock without a unit is taken for one of seconds, milliseconds or microseconds. [judgement]
_USUAL_STEPS: Mapping[str, tuple[float, float]] = {"s": (1e-5, 0.09), "ms": (0.09, 90.0), "us": (90.0, 1e6)}


# Why a column that looks like one is left out, by what its name says it is.
_LEFT_OUT: Mapping[Special, str] = {
    "supply": "of the supply and not of the motor: it is no drive",
    "phase": "of one phase: it goes round with the motor's angle and is no drive; the torque-forming current Iq is one",
    "field": "along the field: it makes no torque",
    "error": "what a controller has still to make good: no motion and no drive",
    "duty": "a duty cycle: of nominal_voltage it is voltage_V, where no other drive is recorded",
}
_SETPOINT = "a setpoint, which the machine follows more or less"
_ONLY_SETPOINT = "CHECK: a setpoint, and no actual value of it was recognised: right only where the drive follows it closely; name the actual value where there is one"
_ARMATURE = "CHECK: the current of a motor with brushes, or of one motor of several; where it is one phase of several it is no drive, which is the torque-forming current Iq"
_PULSE = "how long a pulse is: asked of a servo or of a bridge, and no drive"
_CELL_LOAD = "CHECK: a load that another sensor measures, beside the drive: positive where it holds back a motion in the positive direction, else sign = -1"
_CELL_DRIVE = "CHECK: a load cell, and no current or torque was recognised: a drive only where it measures all that the drive does; a load is disturbance_N"
_BESIDE = (
    "CHECK: a force beside another drive, and it is the force that counts then: measured between drive and load it is a load, disturbance_N"
)
_STILL = "DOUBTFUL: the same number in all rows: name the column that drives the machine, or a file in which it moves"
_PHASES_ONLY = "only phases are there, and none of them is the drive: the torque-forming current Iq is needed, or the phases' amplitude with the sign of the torque"
# A duty cycle within one is a share, within a hundred percent; with some room for its noise. [judgement]
_DUTY_SHARE, _DUTY_PERCENT = 1.05, 105.0


@dataclass(frozen=True)
class Guess:
    """What a column may be: its name in a record (empty where nothing is known), its unit as the map writes it (`?` where it is not known), and of what either is guessed.

    `name_says`: what its name was read as; `instead`: what it could be where nothing better is found; `said`: a remark at its line; `scale`: other than one where the map must state it.
    """

    column: RawColumn
    target: str = ""
    unit: str = OPEN
    by: str = ""
    unit_by: str = ""
    name_says: SpokenName = field(default_factory=SpokenName)
    instead: str = ""
    said: str = ""
    scale: float = 1.0


@dataclass(frozen=True)
class Draft:
    """A map to complete: its text, what was guessed, the entries that are left open, and what is said of one of these."""

    text: str
    guesses: tuple[Guess, ...]
    open_entries: tuple[str, ...] = field(default=())
    remarks: tuple[str, ...] = field(default=())


def draft_map(table: RawTable, units: Units) -> Draft:
    """Look at a table and write the map to complete."""
    read = _without_phases([_guess(column, table, units) for column in table.columns])
    guesses = _remarked(_in_place_of_none(_with_time(_distinct(_loads_told(_setpoints_told(read, units))))))
    lines = [*_head(table), ""]
    opened: list[str] = []
    remarks: list[str] = []
    used = sorted((one for one in guesses if one.target), key=lambda one: ("time_s", *COLUMNS).index(one.target))
    lines += _time_lines(used, table)
    for one in used:
        if one.target != "time_s":
            lines += [*_column_lines(one), ""]
        opened += [f"columns.{one.target}.unit"] if one.unit == OPEN else []
    if not any(one.target == "time_s" for one in used):
        opened.append("columns.time_s.period")
    for kind, names in (("motion", MOTIONS), ("drive", DRIVES)):
        if not any(one.target in (*names, *(VOLTAGES if kind == "drive" else ())) for one in used):
            name = names[0] if kind == "drive" else "motor_speed_rad_s"
            phases = kind == "drive" and any(one.name_says.special == "phase" for one in guesses)
            name = "current_A" if phases else name
            remarks += [f"{name}: {_PHASES_ONLY}"] if phases else []
            lines += [
                *((f"# {_PHASES_ONLY}",) if phases else ()),
                f"[columns.{name}]  # no {kind} was recognised, and a record needs one: {', '.join(names)}",
                f'from = "{OPEN}"  # the name or the number of its column',
                f'unit = "{OPEN}"  # {EXAMPLES[suffix_of(name)]}',
                "",
            ]
            opened += [f"columns.{name}.from", f"columns.{name}.unit"]
    lines += _unused([one for one in guesses if not one.target])
    named = {*(one.target for one in used), *(entry.split(".")[1] for entry in opened)}
    machine, machine_open = _machine_lines(used, named, _supply_V(guesses))
    return Draft("\n".join([*lines, *machine]) + "\n", tuple(guesses), (*opened, *machine_open), tuple(remarks))


def _guess(column: RawColumn, table: RawTable, units: Units) -> Guess:
    """What one column may be."""
    name = column.name
    if name in ("time_s", *COLUMNS):
        return Guess(column, name, _pint_spelling(name), "its name", "its name")
    # a share of a nominal value, of whatever kind: "% MN" is no force
    share = column.unit.strip().startswith("%")
    if share:
        column = replace(column, unit="%")
    suffix = units.suffix(column.unit) if column.unit and not share else ""
    says = spoken(name, suffix, units, share or column.unit.strip().lower() in SHARES)
    # T is a torque in Nm and a time without a unit
    word = "" if says.kind == "time" and suffix not in ("", "s") else says.kind
    unit, unit_by = (column.unit, "the file") if column.unit and units.is_unit(column.unit) else (OPEN, "")
    if len(column.texts) > table.rows.size // 2:
        moments = any(":" in text for text in list(column.texts.values())[:3])
        return Guess(column, "time_s", MOMENTS, "dates or times of day in it", "its cells") if moments else Guess(column)
    bare = Guess(column, "", unit, "its name" + (" and unit" if suffix else ""), unit_by, says)
    if says.special == "duty" and suffix:
        return replace(bare, said=_PULSE)
    if says.special == "duty":
        return replace(bare, instead="voltage_V", said=_LEFT_OUT["duty"])
    if suffix == "s" or (word == "time" and not suffix):
        return Guess(column, "time_s", unit, "its unit" if suffix else "its name", unit_by)
    if not suffix and not word and column.number == 1 and even(column.values[np.isfinite(column.values)]) is not None:
        return Guess(column, "time_s", unit, "it rises by the same step in every row", unit_by)
    if says.special in _LEFT_OUT:
        return replace(bare, said=_LEFT_OUT[says.special])
    if says.special in ("load", "cell"):
        load = "disturbance_Nm" if suffix == "Nm" or (word == "torque" and not suffix) else "disturbance_N"
        return replace(bare, target=load, said=_CELL_LOAD if says.special == "cell" else "")
    names = [one for one in _OF_WORD.get(word, ()) if not suffix or suffix_of(one) == suffix]
    if unit.lower() in SHARES:
        names = [one for one in names if suffix_of(one) in NOMINAL]
    found = bare
    behind = _BEHIND_GEAR.get(names[0] if names else "", "")
    if behind and suffix and says.behind:
        found = replace(bare, target=behind, said=_TURNS_BEHIND)
    elif names:
        found = replace(bare, target=_which(names, name, says.role))
    elif suffix in _OF_SUFFIX and not word:
        found = replace(bare, target=_which(list(_OF_SUFFIX[suffix]), name, says.role), by="its unit")
    return _asked(found) if says.role == "asked" else found


def _asked(one: Guess) -> Guess:
    """A setpoint: one of the position along a line is the command, any other is used only where nothing better is there."""
    if one.target in VOLTAGES:
        return one
    if one.target in ("position_mm", "motor_position_mm") or (
        one.target == "motor_angle_rad" and one.unit == OPEN and one.name_says.kind == "position"
    ):
        return replace(one, target="command_mm", by="its name")
    instead = one.target if one.target in (*MOTIONS, *DRIVES) else ""
    return replace(one, target="", instead=instead, said=_SETPOINT)


def _setpoints_told(guesses: Sequence[Guess], units: Units) -> list[Guess]:
    """A w beside an x is its setpoint, as controllers call them."""
    value = next((one for one in guesses if is_value_symbol(one.column.name, units) and one.target), None)
    if value is None:
        return list(guesses)

    def told(one: Guess) -> Guess:
        if not is_setpoint_symbol(one.column.name, units) or one.unit != value.unit:
            return one
        return _asked(replace(one, target=value.target, name_says=replace(one.name_says, kind=value.name_says.kind, role="asked")))

    return [told(one) for one in guesses]


def _without_phases(guesses: Sequence[Guess]) -> list[Guess]:
    """Currents of phases are no drive; the current of an armature is one, and is to be looked at."""
    phases = phases_of({one.column.number: one.name_says for one in guesses})

    def told(one: Guess) -> Guess:
        if one.column.number in phases:
            says = replace(one.name_says, special="phase")
            return replace(one, target="", instead="", said=_LEFT_OUT["phase"], name_says=says)
        return replace(one, said=_ARMATURE) if one.target == "current_A" and one.name_says.phase else one

    return [told(one) for one in guesses]


def _loads_told(guesses: Sequence[Guess]) -> list[Guess]:
    """What a load cell measures is a load where a current, a torque or another force is recorded beside it, else it may be the drive."""

    def drives(one: Guess) -> bool:
        return one.name_says.special == "phase" or one.target in (*_AT_SHAFT, "force_N") or one.instead in _AT_SHAFT

    if any(drives(one) for one in guesses):
        return list(guesses)
    to_drive = {"disturbance_N": "force_N", "disturbance_Nm": "torque_Nm"}
    return [
        replace(one, target=to_drive[one.target], said=_CELL_DRIVE) if one.name_says.special == "cell" and one.target else one
        for one in guesses
    ]


def _in_place_of_none(guesses: Sequence[Guess]) -> list[Guess]:
    """Where no motion or no drive is recorded, a setpoint of one, or a duty cycle."""
    found = list(guesses)
    for names in (MOTIONS, (*DRIVES, *VOLTAGES)):
        if any(one.target in names for one in found):
            continue
        asked = [one for one in found if one.instead in names and one.name_says.special != "duty"]
        duty = [one for one in found if one.instead in names and one.name_says.special == "duty"]
        phases = names is not MOTIONS and any(one.name_says.special == "phase" for one in found)
        chosen = asked[:1] or ([] if phases else duty[:1])
        for one in chosen:
            taken = replace(one, target=one.instead, said=_ONLY_SETPOINT) if asked else _proposed(one)
            found[found.index(one)] = taken
    return found


def _proposed(one: Guess) -> Guess:
    """A duty cycle as the voltage that it makes of the supply's: of its numbers percent or a share of one, else left open."""
    said = "PROPOSED, to be checked: a duty cycle makes the motor's voltage, its share of the supply's, which is nominal_voltage in [machine]; its sign must be the torque's direction"
    if one.unit.lower() in SHARES:
        return replace(one, target="voltage_V", said=said)
    values = one.column.values[np.isfinite(one.column.values)]
    most = float(np.max(np.abs(values), initial=0.0))
    if most > _DUTY_PERCENT:
        return replace(one, target="voltage_V", unit=OPEN, said=f'{said}; unit = "%" with scale = 100 over the number of a full cycle')
    return replace(
        one, target="voltage_V", unit="%", unit_by="its numbers, a guess", said=said, scale=100.0 if most <= _DUTY_SHARE else 1.0
    )


def _remarked(guesses: Sequence[Guess]) -> list[Guess]:
    """With what is odd about the drive."""
    targets = {one.target for one in guesses}
    drives = (*DRIVES, *(VOLTAGES if not targets & set(DRIVES) else ()))

    def told(one: Guess) -> Guess:
        values = one.column.values[np.isfinite(one.column.values)]
        if one.target in drives and values.size and float(np.ptp(values)) == 0.0:
            return replace(one, said=_STILL)
        return replace(one, said=_BESIDE) if one.target == "force_N" and not one.said and targets & _AT_SHAFT else one

    return [told(one) for one in guesses]


def _supply_V(guesses: Sequence[Guess]) -> float:
    """The supply's voltage in the middle of its rows, for an example; 0 where none is recorded in V."""
    for one in guesses:
        values = one.column.values[np.isfinite(one.column.values)]
        if one.name_says.special == "supply" and one.unit == "V" and values.size:
            return float(np.median(values))
    return 0.0


def _which(names: Sequence[str], name: str, role: str) -> str:
    """Of several columns the one that a name fits: at the motor, or measured at its terminals."""
    if "terminal_voltage_V" in names and (_TERMINAL.search(name) or role == "actual"):
        return "terminal_voltage_V"
    if _AT_MOTOR.search(name):
        return next((one for one in ("motor_angle_rad", "motor_speed_rad_s", "motor_position_mm") if one in names), names[0])
    return names[0]


def _pint_spelling(name: str) -> str:
    return {"mm_s": "mm/s", "rad_s": "rad/s", "C": "degC"}.get(suffix_of(name), suffix_of(name))


def _with_time(guesses: Sequence[Guess]) -> list[Guess]:
    """Where no column is the time, the first that rises by the same step in every row and does not count rows is; without a unit the one in which the step is usual."""
    found = list(guesses)
    if not any(one.target == "time_s" for one in found):
        for place, one in enumerate(found):
            rate = even(one.column.values) if not one.target and np.isfinite(one.column.values).all() else None
            if rate is not None and rate[1] != 1.0:
                found[place] = replace(one, target="time_s", by="it rises by the same step in every row")
                break
    return [_with_time_unit(one) if one.target == "time_s" and one.unit == OPEN else one for one in found]


def _with_time_unit(one: Guess) -> Guess:
    steps = np.diff(one.column.values[np.isfinite(one.column.values)])
    step = float(np.median(steps)) if steps.size else 0.0
    for unit, (shortest, longest) in _USUAL_STEPS.items():
        if shortest <= step < longest:
            return replace(one, unit=unit, unit_by="its step alone, a guess")
    return one


def _distinct(guesses: Sequence[Guess]) -> list[Guess]:
    """Each column of the record once: the surest guess, what is called the actual value, then the first; a column without any change comes last."""

    def rank(one: Guess) -> tuple[bool, bool, bool, bool]:
        values = one.column.values[np.isfinite(one.column.values)]
        still = one.target != "time_s" and (values.size == 0 or float(np.ptp(values)) == 0.0)
        return still, one.name_says.role != "actual" and one.target != "command_mm", one.unit == OPEN, one.by == "its unit"

    best: dict[str, Guess] = {}
    for one in guesses:
        if one.target and (one.target not in best or rank(one) < rank(best[one.target])):
            best[one.target] = one
    return [one if not one.target or best[one.target] is one else replace(one, target="", said="") for one in guesses]


def _head(table: RawTable) -> list[str]:
    layout = table.layout
    lines = [
        f"# What stands in which column of {one_line(table.file)}, for `ema import table`. A draft: check every line, most of all units and signs.",
        f'# An entry "{OPEN}" is one that only you know. What is recorded with the same drive and settings can share one map.',
        "",
        "[file]",
    ]
    if layout.kind != "text":
        return [*lines, f"# a {layout.kind} file: nothing to state here"]
    rows = ", ".join(map(str, layout.header_rows)) or "none"
    return [
        *lines,
        "# found anew in each file, however long its preamble is; state what is found wrong",
        f'encoding = "auto"   # here {layout.encoding}; "utf-8", "utf-16", "cp1252"',
        f'delimiter = "auto"  # here {layout.delimiter}; "semicolon", "comma", "tab", "bar", "spaces"',
        f'decimal = "auto"    # here {layout.decimal}; "point", "comma"',
        f'names_row = "auto"  # rows of names and units here: {rows}; a number from 1',
        'units_row = "auto"',
        f'first_row = "auto"  # here {layout.first_row}: the first row of numbers',
    ]


def _source(one: Guess) -> str:
    """The name, or the number for a column without a name."""
    return str(one.column.number) if re.fullmatch(r"column \d+", one.column.name) else json.dumps(one.column.name, ensure_ascii=False)


def _shown(one: Guess) -> str:
    """Some numbers of a column, for a comment."""
    values = one.column.values[np.isfinite(one.column.values)]
    if not values.size:
        return f"{one_line(next(iter(one.column.texts.values())))} ..." if one.column.texts else "empty"
    return f"{values.min():.6g} .. {values.max():.6g}"


def _time_lines(used: Sequence[Guess], table: RawTable) -> list[str]:
    found = next((one for one in used if one.target == "time_s"), None)
    if found is None:
        return [
            "[columns.time_s]",
            f'period = "{OPEN}"  # no time was recognised: the step from row to row, such as "1 ms", or from and unit',
            "",
        ]
    lines = ["[columns.time_s]", f"from = {_source(found)}  # guessed by {found.by}; {_shown(found)}"]
    if found.unit == OPEN:
        return [*lines, f'unit = "{OPEN}"  # {EXAMPLES["s"]}', ""]
    return [*lines, f"unit = {json.dumps(found.unit, ensure_ascii=False)}  # from {found.unit_by}", ""]


def _column_lines(one: Guess) -> list[str]:
    lines = [
        f"[columns.{one.target}]  # {COLUMNS[one.target]}",
        *([f"# {one.said}"] if one.said else []),
        f"from = {_source(one)}  # guessed by {one.by}; {_shown(one)}",
    ]
    suffix = suffix_of(one.target)
    if one.unit == OPEN:
        lines.append(f'unit = "{OPEN}"  # {KINDS[suffix]}: {EXAMPLES[suffix]}')
    else:
        share = f", a share of [machine] {NOMINAL[suffix]}" if one.unit.lower() in SHARES else ""
        lines.append(f"unit = {json.dumps(one.unit, ensure_ascii=False)}  # from {one.unit_by}{share}")
    if one.scale != 1.0:
        lines.append(f"scale = {one.scale:g}  # guessed: its numbers are a share of one")
    if one.target != "temperature_C":
        lines.append("sign = 1  # guessed: write -1 where the file counts against the machine's positive direction")
    return lines


def _unused(guesses: Sequence[Guess]) -> list[str]:
    if not guesses:
        return []
    lines = [f"# Not used: to use one, write [columns.<name>] with from and unit; names are {', '.join(COLUMNS)}."]
    return [
        *lines,
        *(
            f"#   {_source(one)}, column {one.column.number}: {one_line(one.column.unit) or 'no unit'}, {_shown(one)}{f' ({one.said})' if one.said else ''}"
            for one in guesses
        ),
        "",
    ]


def _machine_lines(used: Sequence[Guess], named: set[str], supply_V: float) -> tuple[list[str], list[str]]:
    """[machine]: what the columns need is left open, what helps is there as a comment."""
    targets = {one.target for one in used}
    needed = ["mass" if "force_N" in targets and not any(name.startswith("motor_") for name in targets) else "inertia"]
    for one in used:
        if one.unit.lower() in SHARES:
            needed.append(NOMINAL[suffix_of(one.target)])
        elif "encoder_count" in plain_unit(one.unit):
            needed.append("counts_per_turn")
    behind = any(one.said == _TURNS_BEHIND for one in used)
    at_rod = {"position_mm", "motor_position_mm", "speed_mm_s", "force_N", "disturbance_N", "command_mm"} & targets
    if at_rod:
        needed += ["lead", "ratio"]
    if not targets & {"torque_Nm", "force_N"} and named & {"current_A", *VOLTAGES}:
        needed.append("torque_constant")
    if not targets & set(DRIVES) and targets & set(VOLTAGES):
        needed += ["back_emf", "resistance"]
    lines = ["[machine]  # numbers with their unit, as data sheets have them"]
    opened = []
    for key in ("name", "source"):
        lines.append(f'{key} = ""')
    for key, meaning in (*NUMBERS.items(), *((name, one.meaning) for name, one in QUANTITIES.items())):
        example = f'"{QUANTITIES[key].example}"' if key in QUANTITIES else "4096" if key == "counts_per_turn" else "1"
        if key == "nominal_voltage" and supply_V:
            example = f'"{supply_V:.3g} V", the supply\'s in the middle of this file'
        if key == "lead" and behind:
            lines.append(f"lead = {_ONE_DEGREE_MM}")
        elif key in needed:
            lines.append(f'{key} = "{OPEN}"  # {meaning}; such as {example}')
            opened.append(f"machine.{key}")
        elif key in ("lead", "ratio", "inertia", "mass", "torque_constant", "friction", "viscous"):
            lines.append(f"# {key} = {example}  # {meaning}")
    return lines, opened
