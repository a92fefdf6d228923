"""Which recordings a fleet's folder holds: by its manifest, or by the names of its folders and files."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Literal

from ema_tools.base.errors import InputError
from ema_tools.base.files import read_text

Kind = Literal["healthy", "test"]
KINDS: tuple[Kind, ...] = ("healthy", "test")

MANIFESTS = ("manifest.csv", "manifest.parquet")
REQUIRED, COLUMNS = ("unit", "file"), ("unit", "file", "date", "kind", "actuator")
_RECORDS = (".csv", ".mat", ".parquet", ".pq")
_DATE = re.compile(r"(\d{4})-(\d{2})-(\d{2})(?:[T_ ](\d{2})[-:]?(\d{2})(?:[-:]?(\d{2}))?)?")


@dataclass(frozen=True, order=True)
class Entry:
    """One recording of a fleet; paths as they are opened, the date in UTC where it says nothing else."""

    unit: str
    date: datetime
    file: Path
    kind: Kind
    actuator: Path


def read_manifest(folder: Path) -> tuple[Entry, ...]:
    """The recordings in a folder, by unit and date. Raises InputError that names the row, or what is wanting.

    With `manifest.csv` or `manifest.parquet` its rows: unit and file, and where stated date (ISO 8601), kind (healthy or test) and actuator, paths from the folder. Without one every folder in it is
    a unit; its TOML file, or the one beside the folders, is the actuator; a date stands in a file's name, and what has healthy in its name is a healthy run.
    """
    if not folder.is_dir():
        raise InputError(f"{folder}: no folder: give the one with the units' folders, or with a {MANIFESTS[0]}")
    given = next((folder / name for name in MANIFESTS if (folder / name).is_file()), None)
    entries = _by_rows(folder, given) if given is not None else _by_names(folder)
    if not entries:
        raise InputError(f"{folder}: no recordings there: put them in a folder for each unit, or name them in {MANIFESTS[0]}")
    return tuple(sorted(entries))


def _by_rows(folder: Path, manifest: Path) -> list[Entry]:
    rows = _table(manifest)
    entries: list[Entry] = []
    for number, row in enumerate(rows, 1):
        where = f"{manifest.name}: row {number}"
        absent = next((name for name in REQUIRED if not row.get(name)), None)
        if absent:
            raise InputError(f"{where}: {absent}: not there: every row names {' and '.join(REQUIRED)}")
        file = folder / row["file"]
        kind = row.get("kind") or _kind_of(file)
        if kind not in KINDS:
            raise InputError(f"{where}: kind = {kind}: write one of {', '.join(KINDS)}")
        date = _stated_date(row.get("date"), where) or _date_of(file)
        stated = row.get("actuator")
        actuator = folder / stated if stated else _actuator_of(folder, folder / row["unit"])
        if actuator is None:
            raise InputError(f"{where}: no actuator: name its TOML file in a column actuator, or put one TOML file into the folder")
        entries.append(Entry(row["unit"], date, file, kind, actuator))
    return entries


def _table(manifest: Path) -> list[Mapping[str, str]]:
    """Rows of a manifest by the names of its columns."""
    if manifest.suffix == ".parquet":
        import pyarrow
        import pyarrow.parquet

        try:
            rows = pyarrow.parquet.read_table(manifest).to_pylist()
        except (pyarrow.ArrowException, OSError):
            raise InputError(f"{manifest.name}: not a readable Parquet file: write it again") from None
        return [{name: "" if value is None else str(value) for name, value in row.items()} for row in rows]
    lines = [line for line in read_text(manifest).splitlines() if line.strip() and not line.lstrip().startswith("#")]
    reader = csv.DictReader(io.StringIO("\n".join(lines)), skipinitialspace=True, restval="")
    wanting = [name for name in REQUIRED if name not in (reader.fieldnames or ())]
    if wanting:
        raise InputError(f"{manifest.name}: no column {wanting[0]}: its columns are {', '.join(COLUMNS)}")
    return [{name: value.strip() for name, value in row.items() if isinstance(name, str) and isinstance(value, str)} for row in reader]


def _by_names(folder: Path) -> list[Entry]:
    entries: list[Entry] = []
    for unit in sorted(one for one in folder.iterdir() if one.is_dir()):
        files = sorted(one for one in unit.iterdir() if one.suffix.lower() in _RECORDS)
        actuator = _actuator_of(folder, unit)
        if files and actuator is None:
            raise InputError(f"{unit.name}: no actuator: put one TOML file into its folder, or beside the units' folders")
        entries += _in_order([Entry(unit.name, _date_of(one), one, _kind_of(one), actuator) for one in files if actuator is not None])
    return entries


def _in_order(entries: Sequence[Entry]) -> list[Entry]:
    """Entries of a unit; healthy runs whose names have no date come before its first dated record, not when their files were copied."""
    dated = [one.date for one in entries if date_in_name(one.file) is not None]
    if not dated:
        return list(entries)
    undated = [one for one in entries if one.kind == "healthy" and date_in_name(one.file) is None]
    before = {one.file: min(dated) - timedelta(days=len(undated) - place) for place, one in enumerate(undated)}
    return [replace(one, date=before.get(one.file, one.date)) for one in entries]


def _actuator_of(folder: Path, unit: Path) -> Path | None:
    """The one TOML file of a unit's folder, else the one beside the folders."""
    for place in (unit, folder):
        found = _tomls(place)
        if len(found) > 1:
            raise InputError(
                f"{place.name}: {' and '.join(one.name for one in found[:2])}: which is the actuator? Leave one, or name it in {MANIFESTS[0]}"
            )
        if found:
            return found[0]
    return None


def _tomls(place: Path) -> Sequence[Path]:
    return sorted(place.glob("*.toml")) if place.is_dir() else ()


def _kind_of(file: Path) -> Kind:
    return "healthy" if "healthy" in file.stem.lower() else "test"


def _stated_date(text: str | None, where: str) -> datetime | None:
    if not text:
        return None
    try:
        date = datetime.fromisoformat(text)
    except ValueError:
        raise InputError(f"{where}: date = {text}: write it as 2026-03-31 or 2026-03-31T14:05") from None
    return date if date.tzinfo else date.replace(tzinfo=UTC)


def _date_of(file: Path) -> datetime:
    """The date in a file's name, else that of its last change."""
    named = date_in_name(file)
    if named is not None:
        return named
    try:
        return datetime.fromtimestamp(file.stat().st_mtime, tz=UTC)
    except OSError:
        return datetime.fromtimestamp(0, tz=UTC)


def date_in_name(file: Path) -> datetime | None:
    """The date in a file's name, UTC; None where there is none."""
    found = _DATE.search(file.stem)
    try:
        return datetime(*(int(part) for part in found.groups() if part is not None), tzinfo=UTC) if found else None  # type: ignore[misc, arg-type]
    except ValueError:
        return None
