"""MATLAB, Parquet, NumPy and JSON files as columns."""

from __future__ import annotations

import json
import zlib
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.data.tables.raw import Layout, RawColumn, RawTable
from ema_tools.data.tables.text import unit_in_name
from ema_tools.data.tables.units import Units

Found = Iterator[tuple[str, Any]]


def read_mat(path: Path, file: str, units: Units) -> RawTable:
    """A MATLAB file up to v7: variables, also those inside structs, by their names joined by points. Raises InputError."""
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    try:
        content = loadmat(path, simplify_cells=True)
    except NotImplementedError:
        raise InputError(f"{file}: a .mat file of version 7.3, which is not read: save it with -v7") from None
    except (MatReadError, ValueError, TypeError, EOFError, OSError):
        raise InputError(f"{file}: not a readable .mat file: save it again with -v7") from None
    return _table(_flat({key: value for key, value in content.items() if not key.startswith("__")}), file, "MATLAB", units)


def read_npz(path: Path, file: str, units: Units) -> RawTable:
    """Arrays of a .npz by their names, or the fields or columns of a .npy. Raises InputError."""
    try:
        with np.load(path, allow_pickle=False) if path.suffix.lower() == ".npz" else _one(np.load(path, allow_pickle=False)) as content:
            arrays = {name: content[name] for name in content}
    except (ValueError, OSError, EOFError, KeyError, BadZipFile, zlib.error):
        raise InputError(f"{file}: not a readable NumPy file of numbers: write it again with numpy.savez") from None
    return _table(_flat(arrays), file, "NumPy", units)


class _one(dict[str, Any]):
    """The fields of a structured array, or the array itself, as what `with` takes."""

    def __init__(self, array: Any) -> None:
        """`array` of a .npy file."""
        names = array.dtype.names
        super().__init__({name: array[name] for name in names} if names else {"column": array})

    def __enter__(self) -> _one:
        return self

    def __exit__(self, *_: object) -> None:
        return None


def read_parquet(path: Path, file: str, units: Units) -> RawTable:
    """The columns of a Parquet file, moments as seconds from the first. Raises InputError."""
    import pyarrow
    import pyarrow.parquet

    try:
        with path.open("rb") as stream:
            table = pyarrow.parquet.read_table(stream)
    except (pyarrow.ArrowException, OSError):
        raise InputError(f"{file}: not a readable Parquet file: write it again") from None
    return _table(((name, table.column(name).to_numpy()) for name in table.column_names), file, "Parquet", units)


def read_json(content: bytes, file: str, units: Units) -> RawTable:
    """A list of objects, one object a line, an object of lists (also inside of others), or columns and data as pandas writes them. Raises InputError."""
    text = content.decode("utf-8-sig", errors="replace")
    try:
        found = json.loads(text)
    except json.JSONDecodeError as error:
        try:
            found = [json.loads(line) for line in text.splitlines() if line.strip()]
        except json.JSONDecodeError:
            raise InputError(f"{file}, row {error.lineno}: not JSON ({error.msg}): correct that row") from None
    return _table(_of_json(found), file, "JSON", units)


def _of_json(found: Any) -> Found:
    if isinstance(found, dict) and isinstance(found.get("columns"), list) and isinstance(found.get("data"), list):
        found = [dict(zip(map(str, found["columns"]), row, strict=False)) for row in found["data"] if isinstance(row, list)]
    if isinstance(found, list) and found and all(isinstance(row, dict) for row in found):
        flat = [dict(_flat(row)) for row in found]
        names = list(dict.fromkeys(name for row in flat for name in row))
        yield from ((name, [row.get(name) for row in flat]) for name in names)
    elif isinstance(found, dict):
        for name, value in found.items():
            # pandas writes each column as an object by row
            if isinstance(value, dict) and value and all(key.isdigit() for key in value):
                yield name, list(value.values())
            elif isinstance(value, dict | list) and value and isinstance(value[0] if isinstance(value, list) else value, dict):
                yield from ((f"{name}.{inner}", one) for inner, one in _of_json(value))
            else:
                yield name, value


def _flat(content: Mapping[str, Any], before: str = "") -> Found:
    """Values by their names, those inside of structs joined by points."""
    for name, value in content.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{before}{name}.")
        elif isinstance(value, np.ndarray) and value.dtype.names:
            yield from ((f"{before}{name}.{field}", value[field]) for field in value.dtype.names)
        else:
            yield f"{before}{name}", value


def _as_numbers(value: Any) -> tuple[Reals, dict[int, str]] | None:
    """A value as numbers and the cells that are none; None for what is no array."""
    array = np.asarray(value) if not isinstance(value, list) else np.asarray(value, dtype=object)
    if array.dtype.kind == "M":
        return (array.ravel() - array.ravel()[:1]).astype("timedelta64[ns]").astype(np.float64) * 1e-9, {}
    if array.dtype.kind in "biuf":
        numbers = array.astype(np.float64)
        return np.where(np.isfinite(numbers), numbers, np.nan), {}
    if array.dtype.kind not in "OU" or array.ndim != 1:
        return None
    numbers, texts = np.full(array.size, np.nan), {}
    for place, one in enumerate(array.tolist()):
        if isinstance(one, bool | int | float):
            numbers[place] = float(one) if np.isfinite(one) else np.nan
        elif one is not None and str(one).strip():
            try:
                numbers[place] = float(str(one))
            except ValueError:
                texts[place] = str(one)
    return numbers, texts


def _table(found: Found, file: str, kind: str, units: Units) -> RawTable:
    """Columns of the length that most arrays have; a matrix gives one for each of its narrow side. Raises InputError when there is none."""
    arrays: dict[str, tuple[Reals, dict[int, str]]] = {}
    constants: dict[str, float] = {}
    for name, value in found:
        read = _as_numbers(value)
        if read is None:
            continue
        numbers, texts = read
        numbers = np.squeeze(numbers)
        if numbers.ndim == 0:
            if not texts:
                constants[name] = float(numbers)
        elif numbers.ndim == 1:
            arrays[name] = (numbers, texts)
        elif numbers.ndim == 2:
            tall = numbers if numbers.shape[0] >= numbers.shape[1] else numbers.T
            arrays.update({f"{name}({k + 1})": (tall[:, k], {}) for k in range(tall.shape[1])})
    lengths = Counter(numbers.size for numbers, _ in arrays.values() if numbers.size > 1)
    if not lengths:
        raise InputError(f"{file}: no columns of numbers are found: give a file with one array or list for each signal")
    rows = max(lengths, key=lambda size: (lengths[size], size))
    columns = tuple(
        RawColumn(name, unit_in_name(name, units), np.ascontiguousarray(numbers), number, texts)
        for number, (name, (numbers, texts)) in enumerate(((name, one) for name, one in arrays.items() if one[0].size == rows), start=1)
    )
    uneven = {name: numbers.size for name, (numbers, _) in arrays.items() if numbers.size != rows}
    return RawTable(file, columns, np.arange(1, rows + 1), Layout(kind), constants, uneven=uneven)
