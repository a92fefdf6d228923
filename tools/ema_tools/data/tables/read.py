"""A file of any maker as columns, by its ending; text where the ending says nothing."""

from __future__ import annotations

import glob
from collections.abc import Iterable
from pathlib import Path

from ema_tools.base.errors import InputError
from ema_tools.base.files import read_again, readable, reason
from ema_tools.data.tables.raw import RawTable
from ema_tools.data.tables.text import Stated, read_text_table
from ema_tools.data.tables.units import Units

# Endings of files that a folder is searched for.
ENDINGS = (".csv", ".tsv", ".txt", ".dat", ".asc", ".log", ".mat", ".parquet", ".pq", ".json", ".jsonl", ".npz", ".npy")


def read_table(path: str | Path, stated: Stated | None = None, units: Units | None = None) -> RawTable:
    """The columns of a file. Raises InputError in one line that names file, row and column."""
    with read_again(Path(path)) as place:
        return _read(place, stated or Stated(), units or Units())


def _read(place: Path, stated: Stated, known: Units) -> RawTable:
    """The columns of a file that gives its bytes as often as they are asked for."""
    file = readable(place.name)
    try:
        content = place.read_bytes()
    except OSError as error:
        raise InputError(f"{place}: {reason(error)}: check the path") from None
    if not content:
        raise InputError(f"{file}: is empty: record it again")
    ending = place.suffix.lower()
    if ending in (".xls", ".xlsx", ".ods") or (content[:4] == b"PK\x03\x04" and ending != ".npz"):
        raise InputError(f"{file}: a workbook, which is not read: save its sheet as CSV")
    if ending in (".mat", ".npz", ".npy", ".parquet", ".pq"):
        from ema_tools.data.tables import binary

        reader = {".mat": binary.read_mat, ".npz": binary.read_npz, ".npy": binary.read_npz}.get(ending, binary.read_parquet)
        return reader(place, file, known)
    if ending in (".json", ".jsonl"):
        from ema_tools.data.tables.binary import read_json

        return read_json(content, file, known)
    return read_text_table(content, file, stated, known)


def files_of(names: Iterable[str | Path]) -> list[Path]:
    """Files, patterns and folders as files, each once, in order. Raises InputError for what leads to none."""
    found: list[Path] = []
    for name in names:
        path = Path(name)
        if path.is_dir():
            inside = sorted(one for one in path.rglob("*") if one.suffix.lower() in ENDINGS and one.is_file())
            if not inside:
                raise InputError(f"{name}: no file in this folder ends with one of {', '.join(ENDINGS)}: name the files")
            found += inside
        elif path.exists() or not glob.has_magic(str(name)):
            found.append(path)
        else:
            inside = sorted(Path(one) for one in glob.glob(str(name), recursive=True) if Path(one).is_file())
            if not inside:
                raise InputError(f"{name}: no file is named like this: check the pattern")
            found += inside
    return list(dict.fromkeys(found))
