"""An actuator as a TOML file: read with exact complaints, changed, written back with the user's comments.

Tables are the sections of `ema_params.def`; `[effects.<name>]` holds the optional effects, `[scatter]` how the unit differs from run to run. `[actuator]` may hold name, notes and source.
"""

from __future__ import annotations

import copy
import difflib
import math
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit
from tomlkit.exceptions import TOMLKitError

from ema_tools.base.arrays import Integers, Reals
from ema_tools.base.errors import InputError, MissingSignal
from ema_tools.base.files import one_line, read_text, readable, write_text
from ema_tools.data.incomplete import NONE_OF_IT, WITHOUT, absent_sections, forgotten, is_incomplete, left_out
from ema_tools.data.machine_state import BASELINE, BaselineRecords, RecordFinding, from_folder, taken_state, update_state
from ema_tools.library.definitions import Definitions, EffectParameter, Parameter, defaults, load_definitions, shipped_folder
from ema_tools.library.one_at_a_site import clash, taken_out

ABOUT = ("name", "notes", "source", "command_acts")
# A key of [actuator]: the time constant by which a drive records its current or torque late, where that is known.
DRIVE_LAG, DRIVE_LAG_MAX_S = "drive_lag_s", 0.1
# These sections are settings of the method, not of the machine: what is absent takes its nominal value.
SETTINGS = ("search", "verdict")
# How the unit differs from run to run: rows such as screw.csj_Nm = 0.006 below [scatter].
SCATTER = "scatter"

# The comments behind values that nobody stated: an import put them there to start from.
FROM_RECORDS, NONE_TAKEN = "a start, by least squares on the imported records", "a start, none is taken"
STARTS = (FROM_RECORDS, NONE_TAKEN)

Row = Parameter | EffectParameter


def nearest(name: str, known: Iterable[str]) -> str:
    """The one of `known` that begins so, or the most similar, as a hint; or an empty text."""
    names = list(known)
    begun = [one for one in names if name and one.startswith(name)]
    found = begun[:1] or difflib.get_close_matches(name, names, n=1, cutoff=0.5)
    return f" (did you mean {found[0]}?)" if found else ""


def alike(name: str, known: Iterable[str], count: int = 3) -> list[str]:
    """The few of `known` that are most like it, best first; none where none is."""
    names = list(known)
    begun = [one for one in names if name and one.startswith(name)]
    return [*dict.fromkeys([*begun, *difflib.get_close_matches(name, names, n=count, cutoff=0.4)])][:count]


def all_rows() -> tuple[Row, ...]:
    """Every row of both lists: parameters and options, then the effects' values."""
    known = load_definitions()
    rows: list[Row] = [*known.parameters, *known.effect_values]
    return tuple(rows)


def row_of(name: str) -> Row:
    """The row of a value given as `section.field`, `effect.field` or `effects.effect.field`.

    Raises InputError with the nearest known name.
    """
    known = load_definitions()
    short = name.removeprefix("effects.")
    row = known.by_name.get(short)
    if row is not None:
        return row
    names = [row.name for row in known.parameters] + ["effects." + row.name for row in known.effect_values]
    near = nearest(name, names) or nearest(short, (row.name for row in known.effect_values))
    raise InputError(f"{name}: unknown value{near}: values are named section.field or effects.name.field")


def path_of(row: Row) -> tuple[str, ...]:
    """Keys that lead to a value in the file."""
    return ("effects", row.effect, row.field) if isinstance(row, EffectParameter) else (row.section, row.field)


def shown(row: Row) -> str:
    """Name of a value as it stands in the file."""
    return ".".join(path_of(row))


def scattering_rows() -> dict[str, Parameter]:
    """Rows of what may scatter from run to run, by name: the real values of the machine, neither settings nor choices."""
    fixed = (*SETTINGS, "timing")
    return {row.name: row for row in load_definitions().parameters if row.section not in fixed and not row.is_option}


def scatters_by_share(row: Row) -> bool:
    """Whether a value scatters by a share of itself; one that the data sheet has as zero does so in its unit."""
    return row.nominal != 0.0


def _range(row: Row) -> str:
    return f"{row.lower:g} .. {row.upper:g}{' ' + row.unit if row.unit else ''}"


def parsed(row: Row, value: object, where: str = "") -> float:
    """`value` (TOML value or text) as the number of `row`: choices become their place, whole numbers stay whole.

    Raises InputError that begins with `where` and names value, range and what to do.
    """
    name = where + shown(row)
    choices = row.choices if isinstance(row, Parameter) else ()
    if choices:
        if isinstance(value, bool) and choices == ("no", "yes"):
            return float(value)
        text = {"true": "yes", "false": "no"}.get(str(value), str(value)) if choices == ("no", "yes") else str(value)
        if isinstance(value, str) and text in choices:
            return float(choices.index(text))
        raise InputError(f"{name} = {value}: not a choice{nearest(str(value), choices)}: use one of {', '.join(choices)}")
    if isinstance(value, str):
        try:
            value = float(value)
        except ValueError:
            raise InputError(f"{name} = {value}: not a number: give one in {_range(row)}") from None
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{name} = {value}: not a number: give one in {_range(row)}")
    try:
        number = float(value)
    except OverflowError:
        raise InputError(f"{name}: a number of more digits than any value has: give one in {_range(row)}") from None
    if isinstance(row, Parameter) and row.is_option and not number.is_integer():
        raise InputError(f"{name} = {value}: not a whole number: give one in {_range(row)}")
    if not (row.lower <= number <= row.upper):
        raise InputError(f"{name} = {value}: outside {_range(row)}: give a value inside")
    return number


def written(row: Row, number: float) -> Any:
    """The number of `row` as its TOML value."""
    choices = row.choices if isinstance(row, Parameter) else ()
    if choices == ("no", "yes"):
        return bool(number)
    if choices:
        return choices[int(number)]
    return int(number) if isinstance(row, Parameter) and row.is_option else float(number)


# A key of [actuator], and its value for a model that leaves out that a command is held from row to row.
COMMAND_ACTS, AT_ROW = "command_acts", "at its row"


@dataclass(frozen=True)
class Actuator:
    """One actuator: every value by `section.field` and `effect.field`, choices as their place in the list.

    `document` is the file's text with its comments, from which `written_text` starts; `file` is where it came from. `remarks`: comments behind values, by their names, that replace those
    of the file. `absent`: values that the file leaves out, as that of a machine whose controller is not known may: what stands for them in `values` fills the module's arrays and is
    never a value of this machine. `scatter`: what the file states of how the unit differs from run to run, one standard deviation by name: relative, or in the value's unit where
    `scatters_by_share` says no; zero for what does not scatter. `baseline`: records of the healthy machine, and `findings`: what was found on later ones; a changed actuator has neither.
    `drive_lag_s`: time constant by which the drive's current or torque was recorded late, negative where the motion was; None where nothing is stated.
    """

    values: Mapping[str, float]
    document: tomlkit.TOMLDocument | None = field(default=None, compare=False, repr=False)
    file: str = field(default="", compare=False)
    about: Mapping[str, str] = field(default_factory=dict, compare=False)
    remarks: Mapping[str, str] = field(default_factory=dict, compare=False)
    absent: frozenset[str] = frozenset()
    scatter: Mapping[str, float] = field(default_factory=dict)
    baseline: BaselineRecords | None = field(default=None, compare=False)
    findings: tuple[RecordFinding, ...] = field(default=(), compare=False)
    drive_lag_s: float | None = None

    def __getitem__(self, name: str) -> float:
        if name in self.absent:
            raise MissingSignal(f"{self.file or self.name}: {name} is not stated: add it to the file, or use what does without: {WITHOUT}")
        return self.values[name]

    def has(self, name: str) -> bool:
        """Whether a value is stated, or is one of something that there is none of."""
        return name not in self.absent

    @property
    def name(self) -> str:
        """The actuator's own name in one line, else its file's."""
        return one_line(self.about.get("name", "")) or one_line(Path(self.file).stem) or "reference actuator"

    @property
    def command_at_row(self) -> bool:
        """Whether the model takes what a row asks of the drive as acting at that row, as published models of sampled drives do, and not held until the next."""
        return self.about.get(COMMAND_ACTS) == AT_ROW

    @property
    def record_period_s(self) -> float:
        """Time between two rows of a record, s."""
        return self["timing.step_s"] * self["timing.record_every_steps"]

    @property
    def lead_mm_per_rad(self) -> float:
        """Rod travel per motor angle, mm/rad."""
        return self["screw.lead_mm"] / (2.0 * math.pi * self["gearbox.ratio"])

    @property
    def active_effects(self) -> tuple[str, ...]:
        """Names of the effects whose size is not zero."""
        return tuple(name for name, size, zero in load_definitions().sizes if self.values[size] != zero)

    @property
    def effects_in_motion(self) -> tuple[str, ...]:
        """Those of them that act during a run; the others change the model's values before it."""
        before = {effect.name for effect in load_definitions().effects if effect.site == "PARAMETER"}
        return tuple(name for name in self.active_effects if name not in before)

    @property
    def healthy(self) -> tuple[str, ...]:
        """The files of the baseline records."""
        return self.baseline.files if self.baseline is not None else ()

    def before_baseline(self) -> Actuator:
        """The model with the effects that began or grew after the baseline records as these have them; itself where the file names none."""
        if self.baseline is None or not self.baseline.before:
            return self
        return replace(self.changed(dict(self.baseline.before)), baseline=replace(self.baseline, before=()), findings=self.findings)

    def keeping(self, healthy: Actuator, names: Iterable[str]) -> Actuator:
        """The actuator with the values `names` that `healthy` has: CSJ and BLK of today are not written as those of the healthy machine."""
        return self.changed({name: healthy[name] for name in names if healthy.has(name)})

    def changed(
        self, changes: Mapping[str, float], about: Mapping[str, str] | None = None, remarks: Mapping[str, str] | None = None
    ) -> Actuator:
        """A copy with some values (by any name that `row_of` takes; numbers as in `values`), parts of [actuator] and comments behind values replaced.

        An effect that comes where one stands of which it is the general case takes its place.

        Raises InputError for an unknown name or a value out of range.
        """
        values = dict(self.values)
        for name, number in changes.items():
            row = row_of(name)
            if not (math.isfinite(number) and row.lower <= number <= row.upper):
                raise InputError(f"{shown(row)} = {number:g}: outside {_range(row)}: give a value inside")
            values[row.name] = float(number)
        rows = {row_of(name).name for name in changes}
        values |= taken_out(values, rows)
        stated = self.absent - rows
        return replace(
            self,
            values=values,
            about={**self.about, **(about or {})},
            remarks={**self.remarks, **(remarks or {})},
            absent=stated,
            baseline=None,
            findings=(),
        )

    def with_drive_lag(self, lag_s: float | None) -> Actuator:
        """A copy whose drive records so late."""
        return replace(self, drive_lag_s=lag_s)

    def remark(self, name: str) -> str:
        """The comment behind a value, where it is not the one that every file has."""
        row = row_of(name)
        text = self.remarks.get(name) or _comment(self.document, row)
        return "" if text == _remark(row) else text

    def arrays(self) -> tuple[Reals, Integers]:
        """Values [value count] and options [option count] in the order of the C module."""
        known, own = load_definitions(), self.values
        values = np.array([own[name] for name in known.value_names], dtype=np.float64)
        options = np.array([own[name] for name in known.option_names], dtype=np.int32)
        return values, options

    def written_text(self) -> str:
        """The file's text: the document with the present values, comments kept; a fresh one when there was none."""
        document = copy.deepcopy(self.document) if self.document is not None else _fresh_document(self)
        _update_about(document, self.about)
        _update_drive_lag(document, self.drive_lag_s)
        for row in all_rows():
            if self.has(row.name) and not (self.absent and self[row.name] == NONE_OF_IT.get(row.name) and not _stands(document, row)):
                _update(document, row, self[row.name])
        for name, text in self.remarks.items():
            trivia = _item_of(document, row_of(name)).trivia
            trivia.comment, trivia.comment_ws = f"# {text}", trivia.comment_ws or " "
        _update_scatter(document, self.scatter)
        update_state(document, self.baseline, self.findings)
        return tomlkit.dumps(document).rstrip("\n") + "\n"

    def write(self, path: str | Path, force: bool = False) -> None:
        """Write the TOML file. Raises InputError when it exists and `force` is not set, or cannot be written."""
        folder = Path(path).parent
        files = tuple(from_folder(file, folder) for file in self.healthy)
        baseline = None if self.baseline is None else replace(self.baseline, files=files)
        findings = tuple(replace(finding, record=from_folder(finding.record, folder)) for finding in self.findings)
        write_text(path, replace(self, baseline=baseline, findings=findings).written_text(), force)


def _update_about(document: tomlkit.TOMLDocument, about: Mapping[str, str]) -> None:
    if not about:
        return
    if "actuator" not in document:
        document.add("actuator", tomlkit.table())
    table: Any = document["actuator"]
    for key, text in about.items():
        if table.get(key) != text:
            table[key] = text


def _update_drive_lag(document: tomlkit.TOMLDocument, lag_s: float | None) -> None:
    """State a lag where there is one; what the file says is left where it is the same."""
    if lag_s is None or (not lag_s and DRIVE_LAG not in document.get("actuator", {})):
        return
    if "actuator" not in document:
        document.add("actuator", tomlkit.table())
    table: Any = document["actuator"]
    if _plain(table.get(DRIVE_LAG)) != lag_s:
        table[DRIVE_LAG] = lag_s


def _update(document: tomlkit.TOMLDocument, row: Row, number: float) -> None:
    """Set one value where it differs; add it where it is absent and not nominal."""
    *tables, key = path_of(row)
    table: Any = document
    for name in tables:
        if name not in table:
            if number == row.nominal:
                return
            table.add(name, tomlkit.table(is_super_table=name == "effects"))
        table = table[name]
    if key in table:
        if parsed(row, _plain(table[key])) != number:
            table[key] = written(row, number)
    elif number != row.nominal or isinstance(row, Parameter):
        table.add(key, _item(row, number))


def _update_scatter(document: tomlkit.TOMLDocument, scatter: Mapping[str, float]) -> None:
    """Set what differs from what stands below [scatter], and add what does not stand there."""
    if scatter and SCATTER not in document:
        document.add(SCATTER, tomlkit.table())
    for name, std in scatter.items():
        table: Any = document[SCATTER]
        section, key = name.split(".")
        if key not in table.get(section, {}):
            row = row_of(name)
            item = tomlkit.item(float(std))
            item.comment(f"from run to run, one standard deviation, {_scatter_unit(row)}")
            item.trivia.comment_ws = " " * max(1, _REMARK_COLUMN - len(f"{name} = {item.as_string()}"))
            table.append(tomlkit.key([section, key]), item)
        elif _plain(table[section][key]) != std:
            table[section][key] = float(std)


def _scatter_unit(row: Row) -> str:
    return "as a share of the value" if scatters_by_share(row) else f"in {row.unit}" if row.unit else "as a plain number"


def _item(row: Row, number: float) -> Any:
    """A TOML value with the row's text as its comment."""
    item = tomlkit.item(written(row, number))
    item.comment(_remark(row))
    item.trivia.comment_ws = " " * max(1, _REMARK_COLUMN - len(f"{row.field} = {item.as_string()}"))
    return item


def _item_of(document: tomlkit.TOMLDocument, row: Row) -> Any:
    """The item of a value that stands in the file."""
    found: Any = document
    for key in path_of(row):
        found = found[key]
    return found


def _stands(document: tomlkit.TOMLDocument, row: Row) -> bool:
    """Whether a value stands in the file."""
    try:
        _item_of(document, row)
    except KeyError:
        return False
    return True


def _comment(document: tomlkit.TOMLDocument | None, row: Row) -> str:
    """The comment behind a value in a file; empty where there is none."""
    try:
        item = _item_of(document, row) if document is not None else None
    except KeyError:
        return ""
    return str(item.trivia.comment).lstrip("#").strip() if item is not None else ""


def _plain(value: object) -> object:
    return value.unwrap() if hasattr(value, "unwrap") else value


def _remark(row: Row) -> str:
    """What stands behind a value: its choices, its text, its unit."""
    names = row.choices if isinstance(row, Parameter) else ()
    choices = f"{' or '.join(names)}; " if names and names != ("no", "yes") else ""
    return f"{choices}{row.text}" + (f" [{row.unit}]" if row.unit else "")


_REMARK_COLUMN = 36
_SECTION_TITLES = {
    "control": "PID control logic",
    "drive": "Controller and drive electronics",
    "motor": "Motor",
    "gearbox": "Gearbox",
    "screw": "Ball screw",
    "encoder": "Encoder network",
    "timing": "Time",
    "search": "What the identification may do",
    "verdict": "What counts as a fault",
}


def _fresh_document(actuator: Actuator) -> tomlkit.TOMLDocument:
    """A document with every parameter, its text as comment, and the effects that are present."""
    known = load_definitions()
    document = tomlkit.document()
    if actuator.about:
        about = tomlkit.table()
        for key in ABOUT:
            if key in actuator.about:
                about.add(key, actuator.about[key])
        document.add("actuator", about)
    for section, rows in known.sections.items():
        table = tomlkit.table()
        table.add(tomlkit.comment(_SECTION_TITLES.get(section, section)))
        stated = [row for row in rows if actuator.has(row.name)]
        # of a machine that is not known in full no section of mere absences, and nothing of what a search may do
        if actuator.absent and (section in SETTINGS or all(row.name in NONE_OF_IT for row in stated)):
            continue
        for row in stated:
            table.add(row.field, _item(row, actuator[row.name]))
        document.add(section, table)
    active = actuator.active_effects
    if active:
        effects = tomlkit.table(is_super_table=True)
        for effect in known.effects:
            if effect.name in active:
                table = tomlkit.table()
                table.add(tomlkit.comment(effect.equation))
                for value in effect.parameters:
                    table.add(value.field, _item(value, actuator[value.name]))
                effects.add(effect.name, table)
        document.add("effects", effects)
    return document


def reference_actuator() -> Actuator:
    """The reference actuator: the nominal column of the list, no effects."""
    return Actuator(values=defaults(), about={"name": "reference actuator"})


def read_actuator(path: str | Path, complete: bool = True) -> Actuator:
    """Read an actuator. With `complete` off [control] and [drive] may be absent, as may lead and ratio, and with them whatever no balance of forces needs.

    `reference` is the actuator that ships with the tools, where no file is called so. Raises InputError in one line that names file, section.field, range and
    the nearest known name.
    """
    if str(path) == "reference" and not Path(path).exists():
        path = shipped_folder() / "actuators" / "reference.toml"
    found = actuator_of(read_text(path), readable(Path(path).name), complete)
    folder = Path(path).parent
    baseline = None if found.baseline is None else replace(found.baseline, files=tuple(str(folder / file) for file in found.healthy))
    return replace(
        found, baseline=baseline, findings=tuple(replace(finding, record=str(folder / finding.record)) for finding in found.findings)
    )


def actuator_of(text: str, file: str, complete: bool = True) -> Actuator:
    """The actuator whose file, called `file`, holds `text`; as `read_actuator`."""
    try:
        document = tomlkit.parse(text)
    except TOMLKitError as error:
        if Path(file).suffix.lower() == ".csv":
            raise InputError(
                f"{file}: a recording where an actuator is wanted: give the actuator's TOML file first, then the recording"
            ) from None
        raise InputError(f"{file}: not TOML: {_reason(error, text)}: correct that line") from None
    known = load_definitions()
    values = defaults()
    content = document.unwrap()
    own = content.pop("actuator", {})
    lag_s = _drive_lag(own, file)
    about = _about(own, file)
    _take_effects(content.pop("effects", {}), known, values, file)
    if two := clash(values):
        raise InputError(f"{file}: [effects]: {two}")
    scatter = _scatter(content.pop(SCATTER, {}), file)
    baseline, findings = taken_state(content, file)
    sections = known.sections
    for section, table in content.items():
        if section not in sections:
            near = nearest(section, [*sections, "effects", "actuator", SCATTER, BASELINE])
            raise InputError(
                f"{file}: [{section}]: unknown table{near}: tables are {', '.join(sections)}, {SCATTER}, {BASELINE}, effects.<name>"
            )
        _take(table, {row.field: row for row in sections[section]}, section, values, file)
    found = Actuator(values, document, file, about, scatter=scatter, baseline=baseline, findings=findings, drive_lag_s=lag_s)
    if not complete and is_incomplete(content):
        machine = [row for section, rows in sections.items() if section not in SETTINGS for row in rows]
        _complain(forgotten(content, machine), file)
        absent, nothing = left_out(content, machine)
        return replace(found, values={**values, **nothing}, absent=absent)
    _require(content, sections, file)
    return found


def _reason(error: TOMLKitError, text: str) -> str:
    """The parser's reason, with the place, which it leaves out for a key that is given twice."""
    reason = f"{str(error)[:1].lower()}{str(error)[1:]}".rstrip(".")
    if " line " in reason:
        return reason
    try:
        tomllib.loads(text)
    except tomllib.TOMLDecodeError as placed:
        at = re.search(r"at line \d+", str(placed))
        return f"{reason} {at[0]}" if at else reason
    return reason


def _drive_lag(table: object, file: str) -> float | None:
    """What the file states of a drive that records late, taken out of `table`. Raises InputError."""
    if not isinstance(table, dict) or DRIVE_LAG not in table:
        return None
    value = table.pop(DRIVE_LAG)
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= DRIVE_LAG_MAX_S:
        raise InputError(
            f"{file}: actuator.{DRIVE_LAG} = {value}: not a time: give one in {-DRIVE_LAG_MAX_S:g} .. {DRIVE_LAG_MAX_S:g} s, 0 where the drive records at once"
        )
    return float(value)


def _about(table: object, file: str) -> dict[str, str]:
    if not isinstance(table, dict):
        raise InputError(f"{file}: actuator: not a table: write [actuator] with {', '.join(ABOUT)}")
    for key, text in table.items():
        if key not in ABOUT:
            raise InputError(f"{file}: actuator.{key}: unknown key{nearest(key, ABOUT)}: [actuator] holds {', '.join((*ABOUT, DRIVE_LAG))}")
        if not isinstance(text, str):
            raise InputError(f"{file}: actuator.{key} = {text}: not a text: put it in quotes")
    return dict(table)


def _take(table: object, rows: Mapping[str, Row], title: str, values: dict[str, float], file: str) -> None:
    if not isinstance(table, dict):
        raise InputError(f"{file}: {title}: not a table: write [{title}] with its values below")
    for key, value in table.items():
        if key not in rows:
            raise InputError(f"{file}: {title}.{key}: unknown key{nearest(key, rows)}: keys are {', '.join(rows)}")
        row = rows[key]
        if isinstance(value, str) and not (isinstance(row, Parameter) and row.choices):
            raise InputError(f'{file}: {shown(row)} = "{value}": not a number: give one in {_range(row)}, without quotes')
        values[row.name] = parsed(row, value, f"{file}: ")


def _take_effects(table: object, known: Definitions, values: dict[str, float], file: str) -> None:
    if not isinstance(table, dict):
        raise InputError(f"{file}: effects: not a table: write [effects.<name>] with its values below")
    effects = {effect.name: effect for effect in known.effects}
    for name, inner in table.items():
        if name not in effects:
            raise InputError(f"{file}: effects.{name}: unknown effect{nearest(name, effects)}: effects are {', '.join(effects)}")
        _take(inner, {value.field: value for value in effects[name].parameters}, f"effects.{name}", values, file)


def _scatter(table: object, file: str) -> dict[str, float]:
    """What stands below [scatter], by name. Raises InputError."""
    if not isinstance(table, dict):
        raise InputError(f"{file}: {SCATTER}: not a table: write [{SCATTER}] with rows such as screw.csj_Nm = 0.006 below")
    found: dict[str, float] = {}
    for section, inner in table.items():
        if "." in section:
            raise InputError(f'{file}: {SCATTER}."{section}": a name in quotes: write {section} = ... without quotes')
        rows = inner if isinstance(inner, dict) else {"": inner}
        for key, value in rows.items():
            name = f"{section}.{key}".rstrip(".")
            found[name] = _std(_scattering_row(name, file), value, f"{file}: {SCATTER}.{name}")
    return found


def _scattering_row(name: str, file: str) -> Parameter:
    """The row of a name below [scatter]. Raises InputError with the nearest known name."""
    rows = scattering_rows()
    if name in rows:
        return rows[name]
    where = f"{file}: {SCATTER}.{name}"
    if name in load_definitions().by_name or name.startswith("effects"):
        raise InputError(f"{where}: no value that scatters: leave it out, [{SCATTER}] holds numbers of {_scattering_sections()}")
    same = [known for known, row in rows.items() if name in (row.field, row.section)]
    near = nearest(name, same or rows)
    raise InputError(f"{where}: unknown value{near}: rows are named section.field, of {_scattering_sections()}")


def _scattering_sections() -> str:
    return ", ".join(dict.fromkeys(row.section for row in scattering_rows().values()))


def _std(row: Parameter, value: object, where: str) -> float:
    """A standard deviation from run to run. Raises InputError that begins with `where`."""
    upper = 1.0 if scatters_by_share(row) else row.upper
    wanted = f"give one standard deviation from run to run, {_scatter_unit(row)}"
    if isinstance(value, str):
        raise InputError(f'{where} = "{value}": not a number: {wanted}, without quotes')
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{where} = {value}: not a number: {wanted}")
    # compared before it is a float: a whole number may have more digits than any float
    if not 0 <= value <= upper:
        raise InputError(
            f"{where}{f' = {value}' if isinstance(value, float) or abs(value) < 1e9 else ''}: outside 0 .. {upper:g}: {wanted}"
        )
    return float(value)


def _require(content: Mapping[str, Any], sections: Mapping[str, tuple[Parameter, ...]], file: str) -> None:
    """Every value of the machine must stand in the file, so that none is taken silently from another machine."""
    unknown = absent_sections(content)
    if unknown:
        both = " and ".join(f"[{section}]" for section in unknown)
        raise InputError(f"{file}: {both} absent: this command simulates the machine and needs them; {WITHOUT}")
    _complain(
        [row for section, rows in sections.items() if section not in SETTINGS for row in rows if row.field not in content.get(section, {})],
        file,
    )


def _complain(missing: Sequence[Parameter], file: str) -> None:
    """Raises InputError for the first value that is missing."""
    if missing:
        row = missing[0]
        more = f" (and {len(missing) - 1} more)" if len(missing) > 1 else ""
        example = tomlkit.item(written(row, row.nominal)).as_string()
        raise InputError(
            f"{file}: {shown(row)} is missing{more}: add it, in the reference actuator it is {row.field} = {example} ({_remark(row)})"
        )
