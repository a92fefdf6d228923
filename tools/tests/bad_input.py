"""The table of bad inputs of the program `ema_identify`: what is wrong, the line it prints, its exit code.

Every entry is tried by test_bad_input.py. `python tools/tests/bad_input.py` writes docs/BAD_INPUT.md from it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

PAGE = Path(__file__).resolve().parents[2] / "docs" / "BAD_INPUT.md"
HEADER = "time_s,command_mm,position_mm"
_ROWS = 120


def rows(count: int = _ROWS, step_s: float = 0.001, command: float = 1.0, position: float = 1.0, offset_mm: float = 0.0) -> list[str]:
    """Rows of a 2 mm sine that the rod follows, lengths multiplied by the factors; row k stands in line k + 2 of the file."""
    lines = []
    for k in range(count):
        command_mm = 2.0 * math.sin(0.1 * k) * command
        position_mm = 1.9 * math.sin(0.1 * k - 0.1) * position + offset_mm
        lines.append(f"{k * step_s:.9g},{command_mm:.9g},{position_mm:.9g}")
    return lines


def text(lines: list[str], header: str = HEADER) -> bytes:
    """A file with line ends behind every line."""
    return "".join(line + "\n" for line in [header, *lines]).encode()


def with_row(number: int, line: str | None) -> bytes:
    """The good file with row `number` (from 0) written as `line`, or left out."""
    lines = rows()
    lines[number : number + 1] = [] if line is None else [line]
    return text(lines)


@dataclass(frozen=True)
class Case:
    """One bad input. `files` are made beside the program's working folder; `arguments` follow the program's name."""

    what: str
    message: str
    files: dict[str, Callable[[], bytes]] = field(default_factory=dict)
    arguments: tuple[str, ...] = ("rec.csv",)
    exit_code: int = 1


def _record(what: str, content: Callable[[], bytes], message: str, *options: str) -> Case:
    return Case(what, "rec.csv: " + message, {"rec.csv": content}, (*options, "rec.csv"))


def _config(what: str, content: str, message: str) -> Case:
    return Case(
        what, "act.txt: " + message, {"rec.csv": lambda: text(rows()), "act.txt": content.encode}, ("--config", "act.txt", "rec.csv")
    )


def _usage(what: str, message: str, *arguments: str) -> Case:
    return Case(what, message, {"rec.csv": lambda: text(rows())}, arguments, 2)


_ROUNDED = "record at a constant rate, or write time_s with more digits if it was rounded"

RECORDINGS = (
    Case("a file that is not there", "none.csv: there is no such file; check the path", {}, ("none.csv",)),
    Case("a folder", ".: cannot be read; name a CSV file, not a folder or a device", {}, (".",)),
    _record("an empty file", lambda: b"", "the file is empty; record or export it again"),
    _record("comments alone", lambda: b"# chirp\n\n", "the file holds no header and no rows; record or export it again"),
    _record("a header alone", lambda: text([]), "there are no rows of samples; record or export it again"),
    _record(
        "fewer than 100 rows",
        lambda: text(rows(99)),
        "row 100: the recording ends after 99 samples and needs at least 100; record for longer",
    ),
    _record(
        "no header",
        lambda: text(rows()[1:], rows()[0]),
        "row 1: numbers where the header must be; add a row such as time_s,command_mm,position_mm above them",
    ),
    _record(
        "a required column missing",
        lambda: text(rows(), "time_s,command_mm,position"),
        'row 1, position_mm: the header has no such column: "time_s,command_mm,position"; give the rod position in millimetres this name',
    ),
    _record(
        "a column twice",
        lambda: text([f"{line},0" for line in rows()], HEADER + ",command_mm"),
        "row 1, command_mm: the column stands there twice; rename or remove one of them",
    ),
    _record(
        "semicolons between the columns",
        lambda: text(rows()).replace(b",", b";"),
        "row 1: no commas between the columns; write commas between fields and a point in numbers",
    ),
    _record(
        "decimal commas",
        lambda: with_row(40, "0,04,1,1"),
        "row 42: 4 fields where the header has 3; remove what is too much (numbers have a decimal point, not a comma)",
    ),
    _record("UTF-16", lambda: text(rows()).decode().encode("utf-16"), "the text is UTF-16; save the recording as CSV in UTF-8"),
    _record(
        "zero bytes",
        lambda: text(rows()).decode().encode("utf-16-le"),
        "row 1: this is no UTF-8 text (it holds zero bytes); save the recording as CSV in UTF-8",
    ),
    _record(
        "carriage returns alone as line ends",
        lambda: text(rows()).replace(b"\n", b"\r"),
        "row 1: a carriage return inside the line; save the file with LF or CRLF line ends",
    ),
    _record(
        "a line without end",
        lambda: HEADER.encode() + b"\n# " + b"x" * 70000,
        "row 2: the line is longer than 65535 bytes; save the file as CSV text with LF or CRLF line ends",
    ),
    _record(
        "text in a number",
        lambda: with_row(40, "0.04,1.2mm,1"),
        'row 42, command_mm: "1.2mm" is not a number; write digits with a decimal point',
    ),
    _record(
        "NaN",
        lambda: with_row(40, "0.04,1,NaN"),
        'row 42, position_mm: "NaN" is not a finite number; fill in the measured value or record again',
    ),
    _record(
        "infinity",
        lambda: with_row(40, "0.04,-inf,1"),
        'row 42, command_mm: "-inf" is not a finite number; fill in the measured value or record again',
    ),
    _record(
        "a number beyond every number",
        lambda: with_row(40, "0.04,1,1e999"),
        'row 42, position_mm: "1e999" is larger than any number can be; correct it',
    ),
    _record(
        "an empty field",
        lambda: with_row(40, "0.04,,1"),
        "row 42, command_mm: the field is empty; fill in the measured value or record again",
    ),
    _record(
        "too few fields",
        lambda: with_row(40, "0.04,1"),
        "row 42, position_mm: 2 fields where the header has 3; write every field of the row",
    ),
    _record(
        "a quote that is not closed",
        lambda: with_row(40, '0.04,"1,1'),
        "row 42: a double quote is opened and not closed on this line; close or remove it",
    ),
    _record(
        "text behind a quote",
        lambda: with_row(40, '0.04,"1"2,1'),
        "row 42: text stands between a closing double quote and the next comma; remove it",
    ),
    _record(
        "a file cut off inside a row",
        lambda: text(rows()) + b"0.12,0.3",
        "row 122, position_mm: 2 fields where the header has 3 and no line end: the file is cut off here; copy or record it again",
    ),
    _record(
        "a file cut off inside a number",
        lambda: text(rows()) + b"0.12,0.3,-",
        "row 122, position_mm: the file is cut off inside this number; copy or record it again",
    ),
    _record(
        "a last number that lost its end",
        lambda: text(rows()) + b"0.12,0.3,39",
        "row 122, position_mm: the last number has no line end behind it and does not fit those before it: it is cut off;"
        " copy or record the file again",
    ),
    _record(
        "a time that repeats",
        lambda: with_row(40, "0.039,1,1"),
        "row 42, time_s: 0.039 s does not come after 0.039 s; sort the rows by time and remove doubles,"
        " or write time_s with more digits if it was rounded",
    ),
    _record(
        "a row missing",
        lambda: with_row(40, None),
        "row 42, time_s: a step of 0.002 s where the first rows have 0.001 s, rows missing before it: 1; record again without gaps",
    ),
    _record(
        "an uneven step",
        lambda: with_row(110, "0.1103,1,1"),
        f"row 112, time_s: a step of 0.0013 s where the first rows have 0.001 s; {_ROUNDED}",
    ),
    _record(
        "time in milliseconds",
        lambda: text(rows(step_s=1.0)),
        "time_s: a row every 1 s, and the actuator records one every 0.001 s: looks like milliseconds; divide the column by 1000",
    ),
    _record(
        "another rate than the actuator's",
        lambda: text(rows(step_s=0.002)),
        "time_s: a row every 0.002 s, and the actuator records one every 0.001 s; set the actuator's step_s and record_every_steps"
        " to this recording, or resample it",
    ),
    _record(
        "all lengths in metres",
        lambda: text(rows(command=0.001, position=0.001)),
        "command_mm: travels 0.003999 mm where at least 0.05 mm are expected of this actuator: looks like metres;"
        " multiply the column by 1000",
    ),
    _record(
        "the position in metres",
        lambda: text(rows(position=0.001)),
        "position_mm: travels 0.003799 mm along with a command over 3.999 mm: looks like metres; multiply the column by 1000",
    ),
    _record(
        "the position in micrometres",
        lambda: text(rows(position=1000.0)),
        "position_mm: travels 3799 mm and the actuator's stroke is 50 mm: looks like micrometres; divide the column by 1000",
    ),
    _record(
        "all lengths in micrometres",
        lambda: text(rows(command=1000.0, position=1000.0)),
        "command_mm: travels 3999 mm and the actuator's stroke is 50 mm: looks like micrometres; divide the column by 1000",
    ),
    _record(
        "a position with an offset",
        lambda: text(rows(offset_mm=40.0)),
        "position_mm: reaches 41.9 mm from the middle and the actuator's travel ends at 25 mm;"
        " take the sensor's offset off command and position, or correct travel_mm",
    ),
    _record(
        "a command that rests",
        lambda: text(rows(command=0.0)),
        "command_mm: the command never changes; record a command that moves the rod",
    ),
    _record(
        "a sample outside the scale of 16-bit integers",
        lambda: with_row(40, "0.04,1,26.3"),
        "row 42: command_mm or position_mm lies outside the actuator's travel of plus and minus 25 mm;"
        " correct the unit of the column, or the actuator's travel_mm",
        "--int16",
    ),
    _record(
        "a sample outside the scale that is stated",
        lambda: with_row(40, "0.04,1,4.3"),
        "row 42: command_mm or position_mm lies outside --full-scale 4;"
        " correct the unit of the column, or give the scale that the firmware states",
        "--int16",
        "--full-scale",
        "4",
    ),
    _record(
        "a value that 32 bits cannot hold", lambda: with_row(40, "0.04,1,1e40"), "row 42: a value is NaN or infinite; correct the sample"
    ),
    _record(
        "more rows than fit",
        lambda: text(rows(120001)),
        "row 120002: the recording goes on, and this program has room for 120000 samples; shorten it, or build with a larger EMA_IDENTIFY_ROWS",
    ),
)

ACTUATORS = (
    Case(
        "an actuator file that is not there",
        "none.txt: file: cannot be opened; check the path",
        {"rec.csv": lambda: text(rows())},
        ("--config", "none.txt", "rec.csv"),
    ),
    Case(
        "a folder",
        ".: file: cannot be read; name a text file, not a folder",
        {"rec.csv": lambda: text(rows())},
        ("--config", ".", "rec.csv"),
    ),
    _config("an empty file", "", "file: empty; write it with `ema export --flat`"),
    _config(
        "a name that no actuator has",
        "# mine\nmotor.resistance = 1\n",
        "row 2, motor.resistance: an actuator has no such value; take the names from a file that `ema export --flat` wrote",
    ),
    _config(
        "a line without `=`", "motor.resistance_ohm 1\n", "row 1, motor.resistance_ohm 1: no `=` in the line; write `section.field = value`"
    ),
    _config(
        "a value twice",
        "screw.csj_Nm = 0.1\nscrew.csj_Nm = 0.2\n",
        "row 2, screw.csj_Nm: the value stands there twice; remove one of the lines",
    ),
    _config(
        "text in a number",
        "motor.resistance_ohm = 1 ohm\n",
        'row 1, motor.resistance_ohm: "1 ohm" is no number from 0.0001 to 1000; correct it',
    ),
    _config("no value", "motor.resistance_ohm =\n", 'row 1, motor.resistance_ohm: "" is no number from 0.0001 to 1000; correct it'),
    _config(
        "a value outside its range", "drive.supply_V = -24\n", 'row 1, drive.supply_V: "-24" is no number from 0.1 to 2000; correct it'
    ),
    _config("NaN", "drive.supply_V = nan\n", 'row 1, drive.supply_V: "nan" is no number from 0.1 to 2000; correct it'),
    _config(
        "a fraction for a whole number",
        "control.every_steps = 1.5\n",
        'row 1, control.every_steps: "1.5" is no whole number from 1 to 1000; correct it',
    ),
    _config(
        "a word that is no choice",
        "drive.mode = torque\n",
        'row 1, drive.mode: "torque" is none of voltage|current; write one of these words',
    ),
    _config(
        "an effect's value outside its range",
        "effects.stribeck_friction.rise = 99\n",
        'row 1, effects.stribeck_friction.rise: "99" is no number from 0 to 3; correct it',
    ),
    _config(
        "a line without end",
        "#" + "x" * 2000 + "\n",
        "row 1, line: longer than 1022 bytes, or not text; write one `section.field = value` per line",
    ),
    _config(
        "a healthy value outside its search bounds",
        "screw.csj_Nm = 5\n",
        "a value is outside its range; let the bounds of [search] hold the healthy screw.csj_Nm and screw.blk_mm, neither of them zero,"
        " and correct its other settings",
    ),
    _config(
        "a mass on the spring that the inertia does not hold",
        "screw.inertia_kgm2 = 1e-5\neffects.transmission_compliance.period_s = 0.02\neffects.transmission_compliance.mass_kg = 500\n",
        "the mass on the spring is heavier than the total inertia allows; correct the actuator",
    ),
    _config(
        "more delay than the model holds",
        "encoder.delay_s = 0.012\neffects.feedback_delay.delay_s = 0.006\n",
        "a value is outside its range; keep encoder.delay_s and effects.feedback_delay.delay_s together within 12 model steps",
    ),
    _config(
        "search bounds the wrong way round",
        "search.blk_lower_mm = 0.2\n",
        "a lower bound is not below its upper bound; let the bounds of [search] hold the healthy screw.csj_Nm and screw.blk_mm, neither of them"
        " zero, and correct its other settings",
    ),
)

USAGES = (
    _usage("no recording", "ema_identify: no recording given; name a CSV file, or see ema_identify --help"),
    _usage("two recordings", "ema_identify: rec.csv: a second recording; give one at a time", "rec.csv", "rec.csv"),
    _usage("an unknown option", "ema_identify: --fast: no such option; see ema_identify --help", "--fast", "rec.csv"),
    _usage("a value missing", "ema_identify: --seed: a value is missing behind this option; see ema_identify --help", "rec.csv", "--seed"),
    _usage(
        "a seed that is no number", "ema_identify: -1: --seed takes a whole number from 0 to 9007199254740991", "--seed", "-1", "rec.csv"
    ),
    _usage(
        "a seed that is too large",
        "ema_identify: 9007199254740992: --seed takes a whole number from 0 to 9007199254740991",
        "--seed",
        "9007199254740992",
        "rec.csv",
    ),
    _usage("slices of no steps", "ema_identify: 0: --slice takes a whole number from 1 to 1000000000", "--slice", "0", "rec.csv"),
    _usage(
        "a full scale of zero",
        "ema_identify: 0: --full-scale takes a number of millimetres above 0, at most 100000",
        "--int16",
        "--full-scale",
        "0",
        "rec.csv",
    ),
    *(
        _usage(
            what,
            f"ema_identify: {value}: --full-scale takes a number of millimetres above 0, at most 100000",
            "--int16",
            "--full-scale",
            value,
            "rec.csv",
        )
        for what, value in (("a full scale in words", "wide"), ("a full scale beyond every actuator", "100001"))
    ),
    _usage(
        "a full scale of 32-bit reals",
        "ema_identify: --full-scale: the record is kept in 32-bit reals, which have no scale; give --int16 or leave it out",
        "--full-scale",
        "4",
        "rec.csv",
    ),
    _usage(
        "two actuators",
        "ema_identify: act.txt: --config and --reference exclude each other; give one of them",
        "--reference",
        "--config",
        "act.txt",
        "rec.csv",
    ),
    _usage(
        "--force without a file",
        "ema_identify: --force: there is no --json FILE to replace; give one or leave --force out",
        "--force",
        "rec.csv",
    ),
    Case(
        "a result that exists",
        "old.json: the file exists and is not overwritten; name another one or give --force",
        {"rec.csv": lambda: text(rows()), "old.json": lambda: b"mine"},
        ("--json", "old.json", "rec.csv"),
        2,
    ),
    _usage(
        "a result in the place of the recording",
        "./rec.csv: --json names a file that is read; give the result another name",
        "--force",
        "--json",
        "./rec.csv",
        "rec.csv",
    ),
    Case(
        "a result in the place of the actuator",
        "act.txt: --json names a file that is read; give the result another name",
        {"rec.csv": lambda: text(rows()), "act.txt": lambda: b"screw.csj_Nm = 0.15\n"},
        ("--config", "act.txt", "--json", "act.txt", "--force", "rec.csv"),
        2,
    ),
    Case(
        "a result where nothing can be written",
        "none/new.json: the file cannot be written; check its folder and permissions",
        {"rec.csv": lambda: text(rows())},
        ("--json", "none/new.json", "rec.csv"),
        1,
    ),
)

CASES = (*RECORDINGS, *ACTUATORS, *USAGES)


def _table(cases: tuple[Case, ...]) -> str:
    lines = ["| input | message | exit code |", "|---|---|---|"]
    for case in cases:
        message = case.message.replace("|", "\\|")
        lines.append(f"| {case.what} | ``{message}`` | {case.exit_code} |")
    return "\n".join(lines) + "\n"


def page() -> str:
    """The text of docs/BAD_INPUT.md."""
    return f"""# Bad input

What `ema_identify` says to input that it refuses. Nothing is printed as a result then, no file is written, and the one line goes to standard error. Exit code 1
is bad input, 2 is wrong usage. Rows are numbered as lines of the file, from 1, comments and the header included.

This page is made from the list that the tests try, entry by entry: `python tools/tests/bad_input.py`.

## Recordings

{_table(RECORDINGS)}
A recording may have a byte order mark, LF or CRLF line ends, `#` comments, blank lines, fields in double quotes, columns in any order, further columns, and no line end
behind its last row: all of these give the same result. A rod that does not follow its command is no bad input; what that means is for the
verdict to say.

## Actuators (`--config`)

{_table(ACTUATORS)}
## Usage

{_table(USAGES)}"""


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8", newline="\n")
