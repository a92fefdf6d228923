"""What stands in which column of a maker's file: the map, a TOML file that `ema import draft` writes and its user completes.

`[file]`: the layout, where it is not to be found out. `[columns.<name>]`: one table for each column of the record. `[machine]`: numbers with their units as texts ("9.84 mNm").
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

from ema_tools.base.errors import InputError
from ema_tools.base.files import read_text, readable
from ema_tools.data.actuator import nearest
from ema_tools.data.motion_records import COLUMNS, DRIVES, MOTIONS, VOLTAGES
from ema_tools.data.tables.text import Stated
from ema_tools.data.tables.units import EXAMPLES, NOMINAL, Units, suffix_of

OPEN = "?"  # what the draft writes where only its user knows
AUTO = "auto"
TABLES = ("file", "columns", "machine")
COLUMN_KEYS = ("from", "unit", "sign", "scale", "offset", "delay", "period", "sure")


@dataclass(frozen=True)
class Quantity:
    """One entry of [machine]: the unit that it becomes, an example, what it is.

    `along`: the unit that it has for what moves along a line, as a linear motor; the rod's travel in m per rad, so many times (`turns`), makes it that at a shaft.
    """

    unit: str
    example: str
    meaning: str
    along: str = ""
    along_example: str = ""
    turns: int = 1

    @property
    def examples(self) -> str:
        """What to write, in quotes."""
        return f'"{self.example}"' + (f', or along a line "{self.along_example}"' if self.along else "")


# Entries of [machine] that are numbers with a unit.
QUANTITIES: Mapping[str, Quantity] = {
    "lead": Quantity("mm", "2 mm", "rod travel per turn of the screw; leave it out for a bare motor"),
    "inertia": Quantity("kg m^2", "21.9 g cm^2", "everything that turns, at the motor shaft"),
    "mass": Quantity("kg", "0.18 kg", "everything that moves with the rod"),
    "torque_constant": Quantity("Nm/A", "25.9 mNm/A", "motor torque per current, or force per current along a line", "N/A", "40 N/A"),
    "back_emf": Quantity("V s/rad", "2.7 V/krpm", "voltage per speed of the motor", "V s/m", "32 V s/m"),
    "resistance": Quantity("ohm", "1.2 ohm", "winding, terminal to terminal"),
    "inductance": Quantity("H", "0.56 mH", "winding, terminal to terminal"),
    "friction": Quantity("Nm", "3 mNm", "dry friction at the motor shaft or along the line, a start", "N", "12 N"),
    "viscous": Quantity(
        "Nm s/rad", "1e-5 Nm s/rad", "viscous friction at the motor shaft or along the line, a start", "N s/m", "20 N s/m", 2
    ),
    "nominal_torque": Quantity("Nm", "9.84 mNm", "what 100 % of a torque is"),
    "nominal_current": Quantity("A", "1.2 A", "what 100 % of a current is"),
    "nominal_force": Quantity("N", "2 kN", "what 100 % of a force is"),
    "nominal_speed": Quantity("rad/s", "3000 rpm", "what 100 % of a speed is"),
    "nominal_voltage": Quantity("V", "24 V", "what 100 % of a voltage is"),
}
# Entries that are plain numbers.
NUMBERS: Mapping[str, str] = {
    "ratio": "motor turns per turn of the screw, 1 for direct drive; leave it out for a bare motor",
    "counts_per_turn": "encoder counts per turn of the motor: four times the lines of an incremental encoder",
}
WORDS = ("name", "source")


@dataclass(frozen=True)
class ColumnMap:
    """Where a column of the record comes from: the file's own name or the number of the column, value = sign (scale raw + offset) in `unit`; `period_s` for a time that is not in the file.

    `delay_s`: by so much it was recorded later than it was. `sure`: its user says that it is right as it is, whatever it looks like.
    """

    source: str | int | None
    unit: str = ""
    sign: float = 1.0
    scale: float = 1.0
    offset: float = 0.0
    period_s: float | None = None
    sure: bool = False
    delay_s: float = 0.0


@dataclass(frozen=True)
class TableMap:
    """A map as it was read; `file` is its own name, for messages. `machine` in SI units (lead in mm) by name, without the entries that are left out; `about`: name and source of the machine."""

    file: str
    columns: Mapping[str, ColumnMap]
    stated: Stated = field(default_factory=Stated)
    machine: Mapping[str, float] = field(default_factory=dict)
    about: Mapping[str, str] = field(default_factory=dict)

    @property
    def units(self) -> Units:
        """Units with this machine's counts and nominal values."""
        nominal = {name: self.machine[name] for name in NOMINAL.values() if name in self.machine}
        return Units(self.machine.get("counts_per_turn", 0.0), nominal, self.machine.get("lead", 0.0))

    @property
    def mm_per_rad(self) -> float | None:
        """Rod travel per motor angle; None for a bare motor."""
        if "lead" not in self.machine:
            return None
        return self.machine["lead"] / (2.0 * math.pi * self.machine["ratio"])

    @property
    def inertia_kgm2(self) -> float:
        """Everything that moves, at the motor shaft; 0 where it is not stated."""
        moved = self.machine.get("mass", 0.0) * (1e-3 * (self.mm_per_rad or 0.0)) ** 2
        return self.machine.get("inertia", 0.0) + moved


def read_map(path: str | Path) -> TableMap:
    """Read a map. Raises InputError in one line that names file and entry and says what to write."""
    file = readable(Path(path).name)
    try:
        content = tomllib.loads(read_text(path))
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{file}: not TOML: {str(error)[:1].lower()}{str(error)[1:]}: correct that line") from None
    for name in content:
        if name not in TABLES:
            raise InputError(f"{file}: [{name}]: unknown table{nearest(name, TABLES)}: tables are [file], [columns.<name>], [machine]")
    stated = _stated(_table(content, "file", file), file)
    machine, about = _machine(_table(content, "machine", file), file)
    columns = {name: _column(name, table, file) for name, table in _table(content, "columns", file).items()}
    _complete(columns, machine, file)
    return TableMap(file, columns, stated, machine, about)


def _table(content: Mapping[str, Any], name: str, file: str) -> Mapping[str, Any]:
    table = content.get(name, {})
    if not isinstance(table, dict):
        raise InputError(f"{file}: {name}: not a table: write [{name}] with its entries below")
    return table


def _stated(table: Mapping[str, Any], file: str) -> Stated:
    known = tuple(one.name for one in fields(Stated))
    found: dict[str, Any] = {}
    for key, value in table.items():
        if key not in known:
            raise InputError(f"{file}: file.{key}: unknown entry{nearest(key, known)}: [file] holds {', '.join(known)}")
        if value == AUTO:
            continue
        wants_row = key.endswith("_row")
        if isinstance(value, bool) or not isinstance(value, int if wants_row else str) or (isinstance(value, int) and value < 1):
            raise InputError(f'{file}: file.{key} = {value}: not {"a row, from 1" if wants_row else "a text"}: correct it or write "auto"')
        found[key] = value
    return Stated(**found)


def _machine(table: Mapping[str, Any], file: str) -> tuple[dict[str, float], dict[str, str]]:
    numbers: dict[str, float] = {}
    along: dict[str, float] = {}
    about: dict[str, str] = {}
    known = (*WORDS, *NUMBERS, *QUANTITIES)
    units = Units()
    for key, value in table.items():
        where = f"{file}: machine.{key}"
        if key not in known:
            raise InputError(f"{where}: unknown entry{nearest(key, known)}: [machine] holds {', '.join(known)}")
        if value == OPEN:
            meaning = QUANTITIES[key].meaning if key in QUANTITIES else NUMBERS.get(key, "a text")
            example = QUANTITIES[key].examples if key in QUANTITIES else "4096" if key in NUMBERS else '"..."'
            raise InputError(f"{where}: is still to be filled in ({meaning}): write for example {key} = {example}, or delete the line")
        if key in WORDS:
            if not isinstance(value, str):
                raise InputError(f"{where} = {value}: not a text: put it in quotes")
            about[key] = value
        elif key in NUMBERS:
            if isinstance(value, bool) or not isinstance(value, int | float) or not value > 0:
                raise InputError(f"{where} = {value}: not a positive number: {NUMBERS[key]}")
            numbers[key] = float(value)
        else:
            if not isinstance(value, str):
                raise InputError(
                    f"{where} = {value}: has no unit: write it as a text with its unit, for example {key} = {QUANTITIES[key].examples}"
                )
            quantity = QUANTITIES[key]
            if quantity.along and units.number_fits(value, quantity.along):
                read, unit = along, quantity.along
            else:
                read, unit = numbers, quantity.unit
            read[key] = units.value(value, unit, where, quantity.examples)
            if not read[key] > 0.0:
                raise InputError(f"{where} = {value}: not positive: {quantity.meaning}")
    if "mass" in numbers and "lead" not in numbers:
        raise InputError(f"{file}: machine.mass: counts at the motor shaft by the lead: write lead as well, or put the mass into inertia")
    if "lead" in numbers and "ratio" not in numbers:
        raise InputError(
            f"{file}: machine.ratio: is not stated beside lead: write ratio = 1 for direct drive, else the motor's turns per turn of the screw"
        )
    for key, value_along in along.items():
        if "lead" not in numbers:
            raise InputError(
                f'{file}: machine.{key} = {table[key]}: counts along a line, and no lead says how far a turn goes: write lead and ratio; where nothing turns any serve, "32 mm" and 1'
            )
        numbers[key] = value_along * (1e-3 * numbers["lead"] / (2.0 * math.pi * numbers["ratio"])) ** QUANTITIES[key].turns
    return numbers, about


def _column(name: str, table: object, file: str) -> ColumnMap:
    known = ("time_s", *COLUMNS)
    where = f"{file}: columns.{name}"
    if name not in known:
        raise InputError(f"{where}: unknown column{nearest(name, known)}: columns of a record are {', '.join(known)}")
    if not isinstance(table, dict):
        raise InputError(f"{where}: not a table: write [columns.{name}] with from and unit below")
    for key, value in table.items():
        if key not in COLUMN_KEYS:
            raise InputError(f"{where}.{key}: unknown entry{nearest(key, COLUMN_KEYS)}: a column has {', '.join(COLUMN_KEYS)}")
        if value == OPEN:
            raise InputError(f"{where}.{key}: is still to be filled in: {_wanted(key, name)}")
    period = table.get("period")
    if (period is None) == ("from" not in table) or (period is not None and name != "time_s"):
        raise InputError(
            f"{where}: {_wanted('from', name)}" + (', or period = "1 ms" where the file has no time' if name == "time_s" else "")
        )
    source = table.get("from")
    if source is not None and (
        isinstance(source, bool) or not isinstance(source, int | str) or source == "" or (isinstance(source, int) and source < 1)
    ):
        raise InputError(f"{where}.from = {source}: {_wanted('from', name)}")
    unit = table.get("unit", "s" if period is not None else None)
    if not isinstance(unit, str) or not unit.strip():
        raise InputError(f"{where}.unit: {_wanted('unit', name)}")
    numbers = {}
    for key, usual in (("sign", 1.0), ("scale", 1.0), ("offset", 0.0)):
        value = table.get(key, usual)
        if (
            isinstance(value, bool)
            or not isinstance(value, int | float)
            or (key == "sign" and value not in (1, -1))
            or (key == "scale" and value == 0)
        ):
            raise InputError(f"{where}.{key} = {value}: {_wanted(key, name)}")
        numbers[key] = float(value)
    sure = table.get("sure", False)
    if not isinstance(sure, bool):
        raise InputError(f"{where}.sure = {sure}: {_wanted('sure', name)}")
    delay, delay_s = table.get("delay"), 0.0
    if delay is not None:
        if not isinstance(delay, str) or name == "time_s":
            raise InputError(f"{where}.delay = {delay}: {_wanted('delay', name)}")
        delay_s = Units().value(delay, "s", f"{where}.delay", '"24 ms"')
    period_s = None
    if period is not None:
        if not isinstance(period, str):
            raise InputError(f'{where}.period = {period}: has no unit: write for example period = "1 ms"')
        period_s = Units().value(period, "s", f"{where}.period", '"1 ms"')
    return ColumnMap(source, unit, period_s=period_s, sure=sure, delay_s=delay_s, **numbers)


def _wanted(key: str, name: str) -> str:
    """What to write for an entry of a column."""
    return {
        "from": 'write from = "the name of the column in the file", or its number from 1',
        "unit": f"write unit as one of {EXAMPLES[suffix_of(name)]}",
        "sign": "write 1, or -1 where the file counts against the machine's positive direction",
        "scale": "write the number by which the file's values are multiplied before their unit counts, not 0",
        "offset": "write the number that is added to the file's values, in their unit",
        "delay": 'write for example delay = "24 ms", by which the column is recorded later than the others; of time there is none',
        "period": 'write for example period = "1 ms"',
        "sure": "write true where the column is right whatever it looks like",
    }[key]


def _complete(columns: Mapping[str, ColumnMap], machine: Mapping[str, float], file: str) -> None:
    """Raises InputError when time, motion or drive is missing."""
    if "time_s" not in columns:
        raise InputError(f'{file}: no time: write [columns.time_s] with from and unit, or with period = "1 ms" where the file has none')
    if not any(name in columns for name in MOTIONS):
        raise InputError(f"{file}: no motion: write one of {', '.join(f'[columns.{name}]' for name in MOTIONS)}")
    if not any(name in columns for name in DRIVES):
        if not any(name in columns for name in VOLTAGES):
            raise InputError(
                f"{file}: no drive: write one of {', '.join(f'[columns.{name}]' for name in DRIVES)}, or [columns.voltage_V] and the motor's data"
            )
        for entry in ("torque_constant", "back_emf", "resistance"):
            if entry not in machine:
                raise InputError(
                    f"{file}: machine.{entry}: a voltage is a drive with the motor's data alone: write {entry} = \"{QUANTITIES[entry].example}\" with your motor's number"
                )
