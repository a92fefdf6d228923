"""What the terminal shows of an import."""

from __future__ import annotations

import math
import shlex
from pathlib import Path

from rich.console import Console
from rich.text import Text

from ema_tools.data.actuator import row_of
from ema_tools.results.files import DraftResult, TableImportResult
from ema_tools.words.sentences.importing import origin_text
from ema_tools.words.sentences.machine_units import TURNING, MachineUnits
from ema_tools.words.terminal.console import number, table
from ema_tools.words.terminal.show import say

_MOTIONS = ("motor_angle_rad", "motor_speed_rad_s", "position_mm", "speed_mm_s")
LOAD = "screw.load_torque_Nm"
_VALUES = ("screw.inertia_kgm2", "screw.viscous_Nm_s_per_rad", "screw.csj_Nm", LOAD)


def print_draft(console: Console, found: DraftResult) -> None:
    """What was guessed, and what is left to fill in."""
    say(console, f"{found.map}, guessed of {Path(found.source).name}")
    guessed = table("", "column of the record", "column of the file", text_columns=2)
    for target, name in found.guessed.items():
        guessed.add_row(target, Text(name))
    console.print(guessed)
    console.print()
    for remark in found.remarks:
        say(console, remark)
    if found.open:
        say(console, f"still to be filled in: {', '.join(found.open)}")
    command = shlex.join(["ema", "import", "table", found.source, "--map", found.map, "-o", "DIR"])
    say(console, f"next: check units and signs in {found.map}, then {command}")


def print_tables(console: Console, found: TableImportResult) -> None:
    """The records, what was done to the files, and the machine to start from."""
    shown = table("Records", "record", "rows", "step ms", "length s", "of")
    for one in found.files:
        for record in one.records:
            seconds = record.rows * record.period_s
            shown.add_row(
                Text(Path(record.record).name),
                str(record.rows),
                number(1e3 * record.period_s),
                number(seconds),
                Text(Path(one.source).name),
            )
    console.print(shown)
    console.print()
    for one in found.files:
        for remark in one.remarks:
            say(console, f"{Path(one.source).name}: {remark}")
    for remark in found.remarks:
        say(console, remark)
    made = table("What they say of the machine", "signal", "made of", text_columns=2)
    for name, source in found.signals.items():
        made.add_row(name, origin_text(source.origin, source.column))
    console.print(made)
    console.print()
    say(console, f"{found.actuator}, to start from")
    values = table("", "value", "number", "from", text_columns=1)
    for name in _VALUES:
        values.add_row(
            name,
            number(found.values[name]),
            "the records" if name in found.estimated else "nothing: none is taken" if name == LOAD else Text(found.map),
        )
    console.print(values)
    units = units_along(found)
    if units.m_per_rad is not None:
        told = (units.told(found.values[name], row_of(name).unit) for name in _VALUES[:-1])
        parts = (f"{units.title(name)} {number(value)} {unit}" for name, (value, unit) in zip(_VALUES, told, strict=False))
        say(console, f"along the line: {', '.join(parts)}")


def units_along(found: TableImportResult) -> MachineUnits:
    """How the numbers of an imported machine are told: along a line where force and motion are recorded there alone."""
    drive, motions = found.signals.get("torque_Nm"), {found.signals[name].column for name in _MOTIONS if name in found.signals}
    if drive is None or drive.column != "force_N" or not motions <= {"position_mm", "speed_mm_s"}:
        return TURNING
    ratio = found.values["gearbox.ratio"]
    return MachineUnits(ratio, 1e-3 * found.values["screw.lead_mm"] / (2.0 * math.pi * ratio))
