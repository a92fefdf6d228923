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
from ema_tools.data.tables.table_map import NUMBERS, OPEN, QUANTITIES
from ema_tools.data.tables.units import EXAMPLES, KINDS, NOMINAL, SHARES, Units, plain_unit, suffix_of

# What names of signals look like, in the languages that makers write; the first that fits is taken. A column that is asked for is no measurement of it.
_WORDS: Sequence[tuple[str, str]] = (
    ("time", r"\b(time|t|zeit|timestamp|temps|tiempo|clock|seconds|datetime)\b"),
    ("disturbance", r"disturb|external|st(ö|oe)r"),
    ("temperature", r"temp(?!s)|t ?mot\b|wicklung|winding.*t"),
    ("torque", r"torque|moment|drehmoment|couple|\btr?q\b|^m( ?(ist|act|mot))? *$|\btau\b"),
    ("force", r"force|kraft|thrust|load ?cell|\bf ?(ist|act)\b"),
    ("current", r"current(?! (pos|vel|speed))|strom|courant|\bi ?[aq]\b|\bi ?(mot|act|ist)\b|\bamps?\b|\bcurr?\b|\bi\b|corriente"),
    ("voltage", r"volt|spannung|tension|\bu ?(mot|[aq])?\b|\bv ?(mot|q)\b|\bpwm\b"),
    ("speed", r"speed|veloc|drehzahl|geschw|\bn ?(ist|act|mot)?\b|vitesse|omega|\brpm\b|\bvel\b|\bw\b|\bv ?(ist|act|rod)\b"),
    ("angle", r"angle|winkel|theta|\bphi\b|rotor"),
    ("position", r"pos|weg|stroke|travel|displac|lage|encoder|\bx\b|\bq\b|\bqm\b|\by\b|deplac"),
)
_ASKED = re.compile(r"command|demand|refer|\bref\b|target|set.?point|soll|\bcmd\b|desired|\bqg\b|asked|setpoint|consigne", re.IGNORECASE)
_TERMINAL = re.compile(r"terminal|measured|klemme|meas", re.IGNORECASE)
_AT_MOTOR = re.compile(r"motor|encoder|rotor|drehzahl|shaft|\bmot\b|cnt|counts?\b|\binc(rement)?s?\b", re.IGNORECASE)
_OF_WORD: Mapping[str, tuple[str, ...]] = {
    "disturbance": ("disturbance_N", "disturbance_Nm"),
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


# Steps from row to row by which a clock without a unit is taken for one of seconds, milliseconds or microseconds. [judgement]
_USUAL_STEPS: Mapping[str, tuple[float, float]] = {"s": (1e-5, 0.09), "ms": (0.09, 90.0), "us": (90.0, 1e6)}


@dataclass(frozen=True)
class Guess:
    """What a column may be: its name in a record (empty where nothing is known), its unit as the map writes it (`?` where it is not known), and of what either is guessed."""

    column: RawColumn
    target: str = ""
    unit: str = OPEN
    by: str = ""
    unit_by: str = ""


@dataclass(frozen=True)
class Draft:
    """A map to complete: its text, what was guessed, and the entries that are left open."""

    text: str
    guesses: tuple[Guess, ...]
    open_entries: tuple[str, ...] = field(default=())


def draft_map(table: RawTable, units: Units) -> Draft:
    """Look at a table and write the map to complete."""
    guesses = _with_time(_distinct([_guess(column, table, units) for column in table.columns]))
    lines = [*_head(table), ""]
    opened: list[str] = []
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
            lines += [
                f"[columns.{name}]  # no {kind} was recognised, and a record needs one: {', '.join(names)}",
                f'from = "{OPEN}"  # the name or the number of its column',
                f'unit = "{OPEN}"  # {EXAMPLES[suffix_of(name)]}',
                "",
            ]
            opened += [f"columns.{name}.from", f"columns.{name}.unit"]
    lines += _unused([one for one in guesses if not one.target])
    machine, machine_open = _machine_lines(used)
    return Draft("\n".join([*lines, *machine]) + "\n", tuple(guesses), (*opened, *machine_open))


def _words_of(name: str) -> str:
    """The first kind of signal that a name speaks of."""
    text = re.sub(r"([a-z])([A-Z])", r"\1 \2", name)
    text = re.sub(r"[\[(].*?[\])]", " ", text).replace("_", " ").replace(".", " ").casefold()
    return next((word for word, pattern in _WORDS if re.search(pattern, text)), "")


def _guess(column: RawColumn, table: RawTable, units: Units) -> Guess:
    """What one column may be."""
    name = column.name
    if name in ("time_s", *COLUMNS):
        return Guess(column, name, _pint_spelling(name), "its name", "its name")
    # a share of a nominal value, of whatever kind: "% MN" is no force
    share = column.unit.strip().startswith("%")
    if share:
        column = replace(column, unit="%")
    word, suffix = _words_of(name), units.suffix(column.unit) if column.unit and not share else ""
    # T is a torque in Nm and a time without a unit
    word = "" if word == "time" and suffix not in ("", "s") else word
    unit, unit_by = (column.unit, "the file") if column.unit and units.is_unit(column.unit) else (OPEN, "")
    if len(column.texts) > table.rows.size // 2:
        moments = any(":" in text for text in list(column.texts.values())[:3])
        return Guess(column, "time_s", MOMENTS, "dates or times of day in it", "its cells") if moments else Guess(column)
    if suffix == "s" or (word == "time" and not suffix):
        return Guess(column, "time_s", unit, "its unit" if suffix else "its name", unit_by)
    if not suffix and not word and column.number == 1 and even(column.values[np.isfinite(column.values)]) is not None:
        return Guess(column, "time_s", unit, "it rises by the same step in every row", unit_by)
    if _ASKED.search(name) and word != "voltage":
        if suffix == "mm" or (word == "position" and not suffix):
            return Guess(column, "command_mm", unit, "its name", unit_by)
        return Guess(column)
    names = [one for one in _OF_WORD.get(word, ()) if not suffix or suffix_of(one) == suffix]
    if unit.lower() in SHARES:
        names = [one for one in names if suffix_of(one) in NOMINAL]
    if names:
        return Guess(column, _which(names, name), unit, "its name" + (" and unit" if suffix else ""), unit_by)
    if suffix in _OF_SUFFIX and not word:
        return Guess(column, _which(list(_OF_SUFFIX[suffix]), name), unit, "its unit", unit_by)
    return Guess(column)


def _which(names: Sequence[str], name: str) -> str:
    """Of several columns the one that a name fits: at the motor, or measured at its terminals."""
    if "terminal_voltage_V" in names and _TERMINAL.search(name):
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
    """Each column of the record once: the surest guess, then the first; a column without any change comes last."""

    def rank(one: Guess) -> tuple[bool, bool, bool]:
        values = one.column.values[np.isfinite(one.column.values)]
        still = one.target != "time_s" and (values.size == 0 or float(np.ptp(values)) == 0.0)
        return still, one.unit == OPEN, one.by == "its unit"

    best: dict[str, Guess] = {}
    for one in guesses:
        if one.target and (one.target not in best or rank(one) < rank(best[one.target])):
            best[one.target] = one
    return [one if not one.target or best[one.target] is one else Guess(one.column) for one in guesses]


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
    lines = [f"[columns.{one.target}]  # {COLUMNS[one.target]}", f"from = {_source(one)}  # guessed by {one.by}; {_shown(one)}"]
    suffix = suffix_of(one.target)
    if one.unit == OPEN:
        lines.append(f'unit = "{OPEN}"  # {KINDS[suffix]}: {EXAMPLES[suffix]}')
    else:
        share = f", a share of [machine] {NOMINAL[suffix]}" if one.unit.lower() in SHARES else ""
        lines.append(f"unit = {json.dumps(one.unit, ensure_ascii=False)}  # from {one.unit_by}{share}")
    if one.target != "temperature_C":
        lines.append("sign = 1  # guessed: write -1 where the file counts against the machine's positive direction")
    return lines


def _unused(guesses: Sequence[Guess]) -> list[str]:
    if not guesses:
        return []
    lines = [f"# Not used: to use one, write [columns.<name>] with from and unit; names are {', '.join(COLUMNS)}."]
    return [
        *lines,
        *(f"#   {_source(one)}, column {one.column.number}: {one_line(one.column.unit) or 'no unit'}, {_shown(one)}" for one in guesses),
        "",
    ]


def _machine_lines(used: Sequence[Guess]) -> tuple[list[str], list[str]]:
    """[machine]: what the columns need is left open, what helps is there as a comment."""
    targets = {one.target for one in used}
    needed = ["mass" if "force_N" in targets and not any(name.startswith("motor_") for name in targets) else "inertia"]
    for one in used:
        if one.unit.lower() in SHARES:
            needed.append(NOMINAL[suffix_of(one.target)])
        elif "encoder_count" in plain_unit(one.unit):
            needed.append("counts_per_turn")
    at_rod = {"position_mm", "motor_position_mm", "speed_mm_s", "force_N", "disturbance_N", "command_mm"} & targets
    if at_rod:
        needed += ["lead", "ratio"]
    if not targets & {"torque_Nm", "force_N"} and targets & {"current_A", *VOLTAGES}:
        needed.append("torque_constant")
    if not targets & set(DRIVES) and targets & set(VOLTAGES):
        needed += ["back_emf", "resistance"]
    lines = ["[machine]  # numbers with their unit, as data sheets have them"]
    opened = []
    for key in ("name", "source"):
        lines.append(f'{key} = ""')
    for key, meaning in (*NUMBERS.items(), *((name, one.meaning) for name, one in QUANTITIES.items())):
        example = f'"{QUANTITIES[key].example}"' if key in QUANTITIES else "4096" if key == "counts_per_turn" else "1"
        if key in needed:
            lines.append(f'{key} = "{OPEN}"  # {meaning}; such as {example}')
            opened.append(f"machine.{key}")
        elif key in ("lead", "ratio", "inertia", "mass", "torque_constant", "friction", "viscous"):
            lines.append(f"# {key} = {example}  # {meaning}")
    return lines, opened
