"""Results as JSON and back, derived from their types: there is no second place that knows a layout.

A result type is a frozen dataclass. The name of a field is its key, unless `key` states another. A number that is not finite becomes null where the type allows None, and is refused
with its path elsewhere. Reading checks every value against its type, names what is missing and refuses what is unknown; a field with a default may be absent, so that files written
before it existed stay readable.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import MISSING, Field, dataclass, fields, is_dataclass
from functools import cache
from types import NoneType, UnionType
from typing import Any, Literal, TypeVar, Union, cast, get_args, get_origin, get_type_hints

import numpy as np

from ema_tools.base.errors import InputError
from ema_tools.base.files import are_finite

# The layout of all results. To be raised when a program of before can no longer read what is written; a new field with a default needs no new number.
FORMAT = 1
FORMAT_KEY = "format"

# Numbers of a curve or a picture: all of them finite.
Series = tuple[float, ...]

Result = TypeVar("Result")

_KEY, _SPARE = "key", "spare"
_AGAIN = "write the result again with --json"


# Of a field that is left out of the file where it is None.
SPARE: Mapping[str, Any] = {_SPARE: True}


def key(name: str) -> Mapping[str, Any]:
    """Metadata of a field whose JSON key is not its name, because the key is a word of Python."""
    return {_KEY: name}


@dataclass(frozen=True)
class _Field:
    """One field: its name in Python, its key in JSON, its type, whether a file must hold it, whether None is left out."""

    name: str
    key: str
    kind: Any
    required: bool
    spare: bool


@cache
def _rows(kind: Any) -> tuple[_Field, ...]:
    hints = get_type_hints(kind)

    def row(one: Field[Any]) -> _Field:
        required = one.default is MISSING and one.default_factory is MISSING
        return _Field(one.name, one.metadata.get(_KEY, one.name), hints[one.name], required, one.metadata.get(_SPARE, False))

    return tuple(row(one) for one in fields(kind))


@cache
def _choices(kind: Any) -> tuple[Any, ...]:
    """The members of a union, else the type alone."""
    return get_args(kind) if get_origin(kind) in (Union, UnionType) else (kind,)


def to_json(result: Any) -> dict[str, Any]:
    """A result for `json.dumps`, with the number of the format. Raises InputError for a number that is not finite where the type demands one, with its path."""
    return {FORMAT_KEY: FORMAT, **_written_fields(result, "")}


def _written_fields(value: Any, path: str) -> dict[str, Any]:
    found = {}
    kind: Any = type(value)
    for row in _rows(kind):
        inner = getattr(value, row.name)
        if not (row.spare and inner is None):
            found[row.key] = _written(inner, row.kind, f"{path}{row.key}")
    return found


def _written(value: Any, kind: Any, path: str) -> Any:
    choices = _choices(kind)
    if isinstance(value, np.generic):
        value = value.item()
    if value is None and NoneType in choices:
        return None
    if is_dataclass(value):
        return _written_fields(value, f"{path}.")
    if isinstance(value, Mapping):
        inner = next(get_args(one)[1] for one in choices if get_origin(one) is dict)
        return {str(key): _written(one, inner, f"{path}.{key}") for key, one in value.items()}
    if isinstance(value, tuple):
        kinds = next(_of_tuple(one, len(value)) for one in choices if get_origin(one) is tuple)
        if set(kinds) == {float} and are_finite(value):
            return list(value)
        return [_written(one, inner, f"{path}[{place}]") for place, (one, inner) in enumerate(zip(value, kinds, strict=True))]
    if float in choices and not isinstance(value, bool | str):
        return _number(float(value), NoneType in choices, path)
    if value is None:
        raise TypeError(f"{path}: None where {kind} is stated")
    return value


def _number(value: float, may_be_absent: bool, path: str) -> float | None:
    if math.isfinite(value):
        return value
    if may_be_absent:
        return None
    raise InputError(f"{path}: {value} cannot be written, since a number must stand there: report this record to the authors of ema")


def _of_tuple(kind: Any, count: int) -> tuple[Any, ...]:
    """Types of the members of a tuple of so many."""
    inner = get_args(kind)
    return inner[:1] * count if len(inner) == 2 and inner[1] is Ellipsis else inner


def from_json(data: Mapping[str, Any], kind: type[Result], source: str) -> Result:
    """The result that a JSON object holds. Raises InputError that names `source` and the field."""
    check_format(data, source)
    return cast(Result, _Reader(source).fields({key: value for key, value in data.items() if key != FORMAT_KEY}, (kind,), ""))


def check_format(data: Mapping[str, Any], source: str) -> None:
    """Raises InputError for a format that this program does not know; files without a number are of the first."""
    number = data.get(FORMAT_KEY, FORMAT)
    if isinstance(number, bool) or not isinstance(number, int) or number < 1:
        raise InputError(f"{source}: field {FORMAT_KEY} is not a whole number from 1: {_AGAIN}")
    if number > FORMAT:
        raise InputError(
            f"{source}: format {number} is newer than this ema, which reads up to {FORMAT}: read it with the ema that wrote it"
        )


@dataclass(frozen=True)
class _Reader:
    """Reads values of one file, which errors name."""

    source: str

    def fail(self, path: str, problem: str) -> InputError:
        return InputError(f"{self.source}: field {path} {problem}: {_AGAIN}")

    def fields(self, data: Mapping[str, Any], kinds: tuple[type, ...], path: str) -> Any:
        """An object as the type that it fits: the first whose required fields it has and which knows all of its own."""
        kind = next((one for one in kinds if _fits(data, one)), kinds[0])
        rows = {row.key: row for row in _rows(kind)}
        found = {}
        for key, value in data.items():
            if key in rows:
                found[rows[key].name] = self.value(value, rows[key].kind, f"{path}{key}")
        for row in rows.values():
            if row.required and row.key not in data:
                raise self.fail(f"{path}{row.key}", "is missing")
        for key in data:
            if key not in rows:
                raise InputError(
                    f"{self.source}: field {path}{key} is unknown to this ema: take it out, or read the file with the ema that wrote it"
                )
        return kind(**found)

    def value(self, value: Any, kind: Any, path: str) -> Any:
        choices = _choices(kind)
        if value is None:
            if NoneType in choices:
                return None
            raise self.fail(path, "is missing")
        classes = tuple(one for one in choices if is_dataclass(one))
        if classes:
            if not isinstance(value, dict):
                raise self.fail(path, "is not an object")
            return self.fields(value, cast(tuple[type, ...], classes), f"{path}.")
        (only,) = (one for one in choices if one is not NoneType)
        return self.plain(value, only, path)

    def plain(self, value: Any, kind: Any, path: str) -> Any:
        """A value of one type that is no dataclass."""
        if kind == Series:
            return self.series(value, path)
        origin = get_origin(kind)
        if origin is dict:
            if not isinstance(value, dict):
                raise self.fail(path, "is not an object")
            return {key: self.value(one, get_args(kind)[1], f"{path}.{key}") for key, one in value.items()}
        if origin is tuple:
            return self.members(value, kind, path)
        if origin is Literal:
            if value not in get_args(kind):
                raise self.fail(path, f"is none of {', '.join(map(str, get_args(kind)))}")
            return value
        if kind is float:
            return self.number(value, path)
        if kind is int:
            if self.number(value, path) != value or not isinstance(value, int):
                raise self.fail(path, "is not a whole number")
            return value
        if not isinstance(value, kind):
            raise self.fail(path, "is not a text" if kind is str else "is neither true nor false")
        return value

    def number(self, value: Any, path: str) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.fail(path, "is not a number")
        if not math.isfinite(value):
            raise self.fail(path, "is not finite")
        return float(value)

    def members(self, value: Any, kind: Any, path: str) -> tuple[Any, ...]:
        """A list."""
        first = get_args(kind)[0]
        what = "texts" if first is str else "objects" if any(map(is_dataclass, _choices(first))) else "values"
        kinds = _of_tuple(kind, len(value)) if isinstance(value, list) else ()
        if not isinstance(value, list) or len(kinds) != len(value):
            raise self.fail(path, f"is not a list of {f'{len(kinds)} ' if kinds else ''}{what}")
        if first is str and not all(isinstance(one, str) for one in value):
            raise self.fail(path, "is not a list of texts")
        return tuple(self.value(one, inner, f"{path}[{place}]") for place, (one, inner) in enumerate(zip(value, kinds, strict=True)))

    def series(self, value: Any, path: str) -> Series:
        """A row of finite numbers."""
        if not isinstance(value, list) or any(isinstance(one, bool | str) for one in value):
            raise self.fail(path, "is not a list of numbers")
        try:
            array = np.asarray(value, dtype=np.float64)
        except (TypeError, ValueError):
            raise self.fail(path, "is not a list of numbers") from None
        if array.ndim != 1:
            raise self.fail(path, "is not a list of numbers")
        if not np.all(np.isfinite(array)):
            raise self.fail(path, f"is not finite at row {int(np.argmin(np.isfinite(array))) + 1}")
        return tuple(array.tolist())


def _fits(data: Mapping[str, Any], kind: type) -> bool:
    rows = _rows(kind)
    known = {row.key for row in rows}
    return all(key in known for key in data) and all(row.key in data for row in rows if row.required)
