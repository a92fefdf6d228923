"""A fleet's results as a Parquet dataset: one row a recording, in parts that are written whole or not at all, each with the version of its rows."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ema_tools.base.errors import InputError

if TYPE_CHECKING:
    import pyarrow

# Version of a row: it rises when a column changes its name or meaning. A column that came since is empty in the rows of older parts, and one that went is passed over.
VERSION = 1
_KEY = b"ema_rows_version"


@dataclass(frozen=True)
class FleetRow:
    """What is known of one recording. `status` bad: it could not be judged, and `reason` says why; the rest is empty then."""

    key: str  # of the recording, the model and the way of judging: the same key is the same work
    unit: str
    date: datetime
    file: str
    kind: str
    actuator: str
    sha256: str = ""  # of the recording
    status: str = "ok"  # ok or bad
    reason: str = ""
    verdict: str | None = None
    reasons: str = ""
    adequate: bool | None = None
    residual_rms_mm: float | None = None
    csj_Nm: float | None = None
    csj_healthy_Nm: float | None = None
    csj_shift_percent: float | None = None
    csj_low_percent: float | None = None  # 95 % interval of the shift
    csj_high_percent: float | None = None
    blk_mm: float | None = None
    blk_healthy_mm: float | None = None
    blk_shift_percent: float | None = None
    blk_low_percent: float | None = None
    blk_high_percent: float | None = None
    effect: str | None = None  # that is missing from the model, where it was asked for
    evaluations: int | None = None
    wall_s: float | None = None
    software: str = ""

    def reading(self, name: str) -> tuple[float | None, float | None, float | None]:
        """Shift of csj or blk and the ends of its 95 % interval, %."""
        return getattr(self, f"{name}_shift_percent"), getattr(self, f"{name}_low_percent"), getattr(self, f"{name}_high_percent")

    def counts(self, name: str) -> bool:
        """Whether the reading of csj or blk says what the unit is like: the model explains the record, and the record determines the value."""
        return self.status == "ok" and self.adequate is not False and None not in self.reading(name)


def _schema() -> pyarrow.Schema:
    import pyarrow

    kinds = {"str": pyarrow.string(), "datetime": pyarrow.timestamp("us", tz="UTC"), "float": pyarrow.float64(), "int": pyarrow.int64()}
    kinds["bool"] = pyarrow.bool_()
    columns = [pyarrow.field(one.name, kinds[str(one.type).split(" ")[0]]) for one in fields(FleetRow)]
    return pyarrow.schema(columns, metadata={_KEY: str(VERSION).encode()})


def key_of(*parts: str) -> str:
    """A name for some work: the same for the same parts."""
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:32]


def write_part(folder: Path, rows: Sequence[FleetRow]) -> Path:
    """Put rows into the dataset, all of them or none: the part is named after the work in it, so that work done twice stands there once."""
    import pyarrow
    import pyarrow.parquet

    folder.mkdir(parents=True, exist_ok=True)
    place = folder / f"part-{key_of(*sorted(row.key for row in rows))}.parquet"
    begun = place.with_name(f".{place.name}.{os.getpid()}")
    pyarrow.parquet.write_table(pyarrow.Table.from_pylist([asdict(row) for row in rows], schema=_schema()), begun)
    os.replace(begun, place)
    return place


def read_rows(folder: Path) -> Iterator[FleetRow]:
    """The rows of the dataset, part by part. Raises InputError for a part of a later version, or one that cannot be read."""
    for part in _parts(folder):
        for row in _read(part, None):
            yield _row_of(row)


def drop_superseded(folder: Path, wanted: Mapping[tuple[str, str], str]) -> None:
    """Take rows out of the dataset whose recording, by unit and file, is there with another key by now; those of recordings that are no longer wanted stay."""
    done = keys(folder)
    for part in list(_parts(folder)):
        rows = [_row_of(row) for row in _read(part, None)]
        # a newer row takes the place of one once it is there
        kept = [row for row in rows if wanted.get((row.unit, row.file), row.key) == row.key or wanted[row.unit, row.file] not in done]
        if len(kept) == len(rows):
            continue
        if kept:
            write_part(folder, kept)
        part.unlink()


def keys(folder: Path) -> set[str]:
    """The keys of what is done."""
    return {row["key"] for part in _parts(folder) for row in _read(part, ["key"])}


def _row_of(row: Mapping[str, Any]) -> FleetRow:
    return FleetRow(**{one.name: row[one.name] for one in fields(FleetRow) if one.name in row})


def _parts(folder: Path) -> Iterable[Path]:
    return sorted(folder.glob("part-*.parquet")) if folder.is_dir() else ()


def _read(part: Path, columns: list[str] | None) -> list[dict[str, Any]]:
    import pyarrow
    import pyarrow.parquet

    try:
        with part.open("rb") as stream:
            file = pyarrow.parquet.ParquetFile(stream)
            version = int((file.schema_arrow.metadata or {}).get(_KEY, b"0"))
            rows: list[dict[str, Any]] = file.read(columns=columns).to_pylist() if version <= VERSION else []
    except (pyarrow.ArrowException, OSError, ValueError):
        raise InputError(f"{part}: not a readable part of the results: remove it, and ema fleet does its recordings again") from None
    if version > VERSION:
        raise InputError(f"{part}: rows of version {version}, written by a later version of the tools: this one reads up to {VERSION}")
    return rows
