"""What the file of one machine holds beside its model: the baseline records, and findings of later records.

`[baseline]` names records of the healthy machine from the file's folder, each with the SHA-256 of its content, and in `before` what effects of the model were like then. `[[findings]]`
holds static friction torque (CSJ) and backlash (BLK) that a command found on a later record. Neither changes a value of the model: the CSJ and BLK of [screw] are those of the healthy machine.
"""

from __future__ import annotations

import hashlib
import math
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import tomlkit

from ema_tools.base.errors import InputError
from ema_tools.library.definitions import load_definitions

BASELINE, FINDINGS = "baseline", "findings"
# The table of files of earlier versions, and its key.
_CALIBRATION, _HEALTHY = "calibration", "healthy"
# Values that a finding states, in the unit of their names.
FOUND = {"screw.csj_Nm": "csj_Nm", "screw.blk_mm": "blk_mm"}
_BASELINE_KEYS = ("records", "sha256")
# Values of effects that began or grew after the baseline records, as these have them; the list of effects of an earlier version, which none of them has.
_BEFORE, _WITHOUT = "before", "without"
_FINDING_KEYS = ("record", "sha256", "command", *FOUND.values())


def digest(path: str | Path) -> str:
    """SHA-256 of a file's content, 64 hexadecimal digits. Raises OSError."""
    with Path(path).open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


class _File(Protocol):
    """A record with the file that it was read from."""

    @property
    def path(self) -> str: ...

    @property
    def sha256(self) -> str: ...


@dataclass(frozen=True)
class BaselineRecords:
    """Records of the healthy machine: `files`, and the SHA-256 of each where it is known.

    `before`: values, by full name, of the effects that began or grew since, as these records have them, where the model with these values was fitted to the records; None where it was not.
    """

    files: tuple[str, ...]
    sha256: tuple[str, ...] = ()
    before: tuple[tuple[str, float], ...] | None = None

    @classmethod
    def of(cls, records: Iterable[_File], before: Mapping[str, float] | None = None) -> BaselineRecords | None:
        """The baseline that `records` make; None where there are none, or one was not read from a file."""
        given = list(records)
        if not given or not all(record.sha256 for record in given):
            return None
        return cls(
            tuple(record.path for record in given),
            tuple(record.sha256 for record in given),
            None if before is None else tuple(before.items()),
        )

    @property
    def since(self) -> tuple[str, ...]:
        """Effects of the model that began or grew after these records."""
        return tuple(dict.fromkeys(name.split(".")[1] for name, _ in self.before or ()))

    def covers(self, records: Iterable[_File]) -> bool:
        """Whether all of `records` are among these."""
        return all(record.sha256 in self.sha256 for record in records)


@dataclass(frozen=True)
class RecordFinding:
    """What `command` found on a later record of the machine; `values`: today's CSJ and BLK by full name."""

    record: str
    sha256: str
    command: str
    values: tuple[tuple[str, float], ...]


def taken_state(content: dict[str, Any], file: str) -> tuple[BaselineRecords | None, tuple[RecordFinding, ...]]:
    """BaselineRecords and findings of a parsed file, taken out of `content`. Raises InputError that begins with `file`."""
    old = content.pop(_CALIBRATION, None)
    baseline = _baseline(content.pop(BASELINE, None), file)
    if old is not None:
        files = old.get(_HEALTHY) if isinstance(old, dict) and set(old) <= {_HEALTHY} else None
        if not _texts(files):
            raise InputError(
                f'{file}: [{_CALIBRATION}]: it holds {_HEALTHY} = ["RUN.csv", ...] and nothing else: calibrate again, or take it out'
            )
        baseline = baseline or BaselineRecords(tuple(files or ()))
    return baseline, _findings(content.pop(FINDINGS, []), file)


def _texts(value: object) -> bool:
    return isinstance(value, list) and all(isinstance(text, str) and text for text in value)


def _baseline(table: object, file: str) -> BaselineRecords | None:
    if table is None:
        return None
    wanted = f'[{BASELINE}]: it holds records = ["RECORD.csv", ...], sha256 with as many texts, and before = {{"effects.NAME.FIELD" = NUMBER, ...}}'
    if not isinstance(table, dict):
        raise InputError(f"{file}: {wanted}: correct it, or take it out")
    before, without = table.pop(_BEFORE, None), table.pop(_WITHOUT, None)
    if not set(table) <= set(_BASELINE_KEYS) or not all(map(_texts, table.values())) or not (without is None or _texts(without)):
        raise InputError(f"{file}: {wanted}: correct it, or take it out")
    files, sums = (table.get(key) for key in _BASELINE_KEYS)
    if not files or (sums is not None and len(sums) != len(files)):
        raise InputError(f"{file}: {wanted}: correct it, or take it out")
    if before is None and without is not None:
        sizes = {effect.name: effect.size for effect in load_definitions().effects}
        before = dict((f"effects.{sizes[name].name}", sizes[name].nominal) if name in sizes else (name, 0.0) for name in without)
    return BaselineRecords(tuple(files), tuple(sums or ()), None if before is None else tuple(_before(before, file).items()))


def _before(table: object, file: str) -> dict[str, float]:
    """Values as the baseline records have them."""
    if not isinstance(table, dict):
        raise InputError(f'{file}: [{BASELINE}]: {_BEFORE}: it holds "effects.NAME.FIELD" = NUMBER: correct it, or take it out')
    unknown = set(table) - {f"effects.{value.name}" for value in load_definitions().effect_values}
    if unknown:
        raise InputError(f"{file}: [{BASELINE}]: {_BEFORE}: {min(unknown)} is no value of an effect: ema effects lists them")
    return {name: _number(value, f"[{BASELINE}]", file) for name, value in table.items()}


def _findings(rows: object, file: str) -> tuple[RecordFinding, ...]:
    if not isinstance(rows, list) or not all(isinstance(row, dict) and set(row) <= set(_FINDING_KEYS) for row in rows):
        raise InputError(f"{file}: [[{FINDINGS}]]: each holds {', '.join(_FINDING_KEYS)}: correct it, or take it out")
    return tuple(_finding(row, file) for row in rows)


def _finding(row: dict[str, Any], file: str) -> RecordFinding:
    texts = [row.get(key, "") for key in ("record", "sha256", "command")]
    numbers = {name: row[key] for name, key in FOUND.items() if key in row}
    if not all(isinstance(text, str) for text in texts):
        raise InputError(f"{file}: [[{FINDINGS}]]: record, sha256 and command are texts: put them in quotes")
    return RecordFinding(
        texts[0], texts[1], texts[2], tuple((name, _number(value, f"[[{FINDINGS}]]", file)) for name, value in numbers.items())
    )


def _number(value: object, table: str, file: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise InputError(f"{file}: {table}: {value} is no number: correct it, or take it out")
    return float(value)


def update_state(document: tomlkit.TOMLDocument, baseline: BaselineRecords | None, findings: Sequence[RecordFinding]) -> None:
    """Write baseline and findings into a file's document, in place of those that it has."""
    if taken_state({key: document[key].unwrap() for key in (_CALIBRATION, BASELINE, FINDINGS) if key in document}, "") == (
        baseline,
        tuple(findings),
    ):
        return
    for key in (_CALIBRATION, BASELINE, FINDINGS):
        document.pop(key, None)
    if baseline is not None:
        table = tomlkit.table()
        table.add(tomlkit.comment("Records of the healthy machine; every command compares later records with them"))
        table.add("records", list(baseline.files))
        if baseline.sha256:
            table.add("sha256", list(baseline.sha256))
        if baseline.before is not None:
            before = tomlkit.inline_table()
            before.update(dict(baseline.before))
            table.add(_BEFORE, before)
            table[_BEFORE].comment("effects that began or grew after these records, as the records have them")
        document.add(BASELINE, table)
    if findings:
        rows = tomlkit.aot()
        for finding in findings:
            row = tomlkit.table()
            for key, text in (("record", finding.record), ("sha256", finding.sha256), ("command", finding.command)):
                row.add(key, text)
            for name, value in finding.values:
                row.add(FOUND[name], value)
            rows.append(row)
        document.add(FINDINGS, rows)


def from_folder(file: str, folder: Path) -> str:
    """The path of a file as seen from a folder, or the whole path where there is none."""
    try:
        return Path(os.path.relpath(file, folder)).as_posix()
    except ValueError:  # another drive
        return str(Path(file).resolve())
