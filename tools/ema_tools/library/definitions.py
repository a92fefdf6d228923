"""The two lists that make an actuator, `ema_params.def` and `ema_effects.def` with the user's own behind it, as the compiled library has them.

These lists are the single source of names, nominal values, ranges and texts; Python keeps no copy of them and reads no C.
"""

from __future__ import annotations

import ctypes
import functools
import os
import sys
from collections.abc import Iterator
from ctypes import POINTER, byref, c_char_p, c_double, c_int32
from dataclasses import dataclass, replace
from enum import IntEnum
from pathlib import Path
from typing import Any, TypeVar

from ema_tools.base.errors import LibraryError

_UNITS = (
    ("Nm_per_sqrt_rad_s", "Nm/sqrt(rad/s)"),
    ("Nm_s2_per_rad2", "Nm s2/rad2"),
    ("percent_per_day", "%/day"),
    ("mm_per_rad", "mm/rad"),
    ("per_kgm2", "1/(kg m2)"),
    ("per_mm", "1/mm"),
    ("mm_s", "mm/s"),
    ("days", "days"),
    ("hz", "Hz"),
    ("m", "m"),
    ("Nm_s_per_rad", "Nm s/rad"),
    ("V_s_per_rad", "V s/rad"),
    ("Nm_per_mm", "Nm/mm"),
    ("Nm_per_A", "Nm/A"),
    ("per_m_s", "1/(m s)"),
    ("s_per_m", "s/m"),
    ("rad_s", "rad/s"),
    ("kgm2", "kg m2"),
    ("mm2s", "mm2 s"),
    ("m_s", "m/s"),
    ("per_m", "1/m"),
    ("per_s", "1/s"),
    ("percent", "%"),
    ("degC_per_W", "degC/W"),
    ("degC", "degC"),
    ("Nm", "Nm"),
    ("mm", "mm"),
    ("ohm", "ohm"),
    ("rad", "rad"),
    ("kg", "kg"),
    ("V", "V"),
    ("A", "A"),
    ("H", "H"),
    ("s", "s"),
)


class TableAxis(IntEnum):
    """`ema_axis_t`: what a learned table is read along, as its value `axis` counts them."""

    SPEED = 0
    POSITION = 1
    LEAD = 2
    TURN = 3
    CURRENT = 4


def unit_of(field: str) -> str:
    """The unit that the suffix of `field` names, the longest that fits, as printed text; empty for a plain number."""
    return next((unit for suffix, unit in sorted(_UNITS, key=lambda one: -len(one[0])) if field.endswith("_" + suffix)), "")


@dataclass(frozen=True)
class Parameter:
    """One row of `ema_params.def`: a real number, or an option (`is_option`) that is a whole number or a choice."""

    section: str
    field: str
    nominal: float
    lower: float
    upper: float
    text: str
    is_option: bool = False
    choices: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Name in TOML and in Python: `section.field`."""
        return f"{self.section}.{self.field}"

    @property
    def unit(self) -> str:
        """Unit from the suffix of the field."""
        return unit_of(self.field)


@dataclass(frozen=True)
class EffectParameter:
    """One EMA_P of an effect; the first of an effect is its size and its nominal value is the effect's zero."""

    effect: str
    field: str
    nominal: float
    lower: float
    upper: float
    text: str

    @property
    def name(self) -> str:
        """Name in Python: `effect.field`."""
        return f"{self.effect}.{self.field}"

    @property
    def unit(self) -> str:
        """Unit from the suffix of the field."""
        return unit_of(self.field)


@dataclass(frozen=True)
class Effect:
    """One row of `ema_effects.def`."""

    name: str
    site: str
    memory: int
    substeps: int
    equation: str
    source: str
    look_alikes: tuple[str, ...]
    parameters: tuple[EffectParameter, ...]
    is_learned: bool = False  # no physical effect but a table that holds what was learned from records
    is_own: bool = False  # from the user's own list

    @property
    def nodes(self) -> tuple[EffectParameter, ...]:
        """The nodes of a learned table in their order; nothing for a physical effect."""
        return tuple(row for row in self.parameters if row.field.startswith("node_")) if self.is_learned else ()

    @property
    def size(self) -> EffectParameter:
        """The parameter whose nominal value means that the effect is absent."""
        return self.parameters[0]


@dataclass(frozen=True, eq=False)
class Definitions:
    """Both lists in the order of the files; there is one object of them, which is compared as such."""

    parameters: tuple[Parameter, ...]
    effects: tuple[Effect, ...]

    @property
    def reals(self) -> tuple[Parameter, ...]:
        """The real parameters, in the order of the C structure."""
        return tuple(row for row in self.parameters if not row.is_option)

    @property
    def options(self) -> tuple[Parameter, ...]:
        """The options, in the order of the C structure."""
        return tuple(row for row in self.parameters if row.is_option)

    @property
    def physical(self) -> tuple[Effect, ...]:
        """The effects without the tables that are learned."""
        return tuple(effect for effect in self.effects if not effect.is_learned)

    @property
    def effect_values(self) -> tuple[EffectParameter, ...]:
        """The values of all effects, in the order of the C structure."""
        return tuple(value for effect in self.effects for value in effect.parameters)

    @property
    def rows(self) -> tuple[Parameter | EffectParameter, ...]:
        """The parameters and the values of all effects, in the order of the files."""
        return (*self.parameters, *self.effect_values)

    @functools.cached_property
    def value_names(self) -> tuple[str, ...]:
        """Names of all real values in the order of the C module: parameters, then the values of effects."""
        return (*(row.name for row in self.reals), *(row.name for row in self.effect_values))

    @functools.cached_property
    def option_names(self) -> tuple[str, ...]:
        """Names of the options in the order of the C module."""
        return tuple(row.name for row in self.options)

    @functools.cached_property
    def sizes(self) -> tuple[tuple[str, str, float], ...]:
        """Of every effect its name, the name of its size, and the zero of that."""
        return tuple((row.name, row.size.name, row.size.nominal) for row in self.effects)

    @functools.cached_property
    def ids(self) -> dict[str, int]:
        """Name to the C library's id: real parameters, then effect values, then options."""
        rows: tuple[Parameter | EffectParameter, ...] = (*self.reals, *self.effect_values, *self.options)
        return {row.name: index for index, row in enumerate(rows)}

    @property
    def sections(self) -> dict[str, tuple[Parameter, ...]]:
        """Section to its rows, in the order of the file."""
        found: dict[str, list[Parameter]] = {}
        for row in self.parameters:
            found.setdefault(row.section, []).append(row)
        return {section: tuple(rows) for section, rows in found.items()}

    @functools.cached_property
    def by_name(self) -> dict[str, Parameter | EffectParameter]:
        """Every row by its `section.field` or `effect.field`."""
        return {row.name: row for row in self.rows}

    def find(self, name: str) -> Parameter | EffectParameter:
        """The row called `section.field` or `effect.field`. Raises KeyError with a message that lists the nearest names."""
        if name in self.by_name:
            return self.by_name[name]
        first = name.split(".", 1)[0]
        near = [row.name for row in self.rows if row.name.split(".", 1)[0] == first]
        known = near or [*self.sections, *(effect.name for effect in self.effects)]
        raise KeyError(f"{name}: no such value; use one of {', '.join(known)}")

    def effect(self, name: str) -> Effect:
        """The effect called `name`. Raises KeyError with a message that lists the effects."""
        for row in self.effects:
            if row.name == name:
                return row
        raise KeyError(f"{name}: no such effect; use one of {', '.join(row.name for row in self.effects)}")


_FOLDER = "EMA_LIBRARY_DIR"
_PACKAGE = Path(__file__).resolve().parents[1]


def is_installed() -> bool:
    """Whether the package stands by itself, as from a wheel: its libraries and what ships with it lie inside it."""
    return (_PACKAGE / "lib").is_dir()


def library_folder() -> Path:
    """Folder of the shared libraries: EMA_LIBRARY_DIR, else that inside an installed package, else `build/lib` of the repository around this file."""
    named = os.environ.get(_FOLDER)
    if named:
        return Path(named).resolve()
    return _PACKAGE / "lib" if is_installed() else _PACKAGE.parents[1] / "build" / "lib"


def shipped_folder() -> Path:
    """Where `actuators` and `recordings` lie: inside an installed package, else the repository around this file."""
    return _PACKAGE / "shipped" if is_installed() else _PACKAGE.parents[1]


def named_library(name: str) -> Path:
    """Where the shared library called `name` is, or would be."""
    file = {"win32": f"{name}.dll", "darwin": f"lib{name}.dylib"}.get(sys.platform, f"lib{name}.so")
    return library_folder() / file


def library_path(bits: int) -> Path:
    """The shared library of one precision. Raises LibraryError when it is absent."""
    path = named_library(f"ema_desk{bits}")
    if not path.is_file():
        raise LibraryError(
            f"{path.name}: not in {path.parent}: build the project (cmake --workflow --preset demo) or point EMA_LIBRARY_DIR at the libraries"
        )
    return path


def open_library(path: Path) -> ctypes.CDLL:
    """The library at `path`. Raises LibraryError when it cannot be loaded."""
    try:
        return ctypes.CDLL(str(path))
    except OSError as error:
        raise LibraryError(f"{path.name}: cannot be loaded ({error}): build the project again") from None


def library_function(opened: ctypes.CDLL, name: str) -> Any:
    """A function of an open library. Raises LibraryError where it has none of this name."""
    found = getattr(opened, name, None)
    if found is None:
        raise LibraryError(f"{Path(opened._name).name}: has no {name}: build the project again")
    return found


class _Row(ctypes.Structure):
    _fields_ = [
        ("section", c_char_p),
        ("field", c_char_p),
        ("text", c_char_p),
        ("choices", c_char_p),
        ("nominal", c_double),
        ("lower", c_double),
        ("upper", c_double),
        ("is_option", c_int32),
    ]


class _Effect(ctypes.Structure):
    _fields_ = [
        ("name", c_char_p),
        ("site", c_char_p),
        ("equation", c_char_p),
        ("source", c_char_p),
        ("look_alikes", c_char_p),
        ("memory", c_int32),
        ("substeps", c_int32),
        ("is_learned", c_int32),
        ("is_own", c_int32),
        ("first_value", c_int32),
        ("value_count", c_int32),
    ]


_AnyRow = TypeVar("_AnyRow", _Row, _Effect)


def _rows(opened: ctypes.CDLL, name: str, kind: type[_AnyRow]) -> Iterator[_AnyRow]:
    """The rows of one list, from its first to the one behind which the library refuses."""
    read = library_function(opened, name)
    read.argtypes = [c_int32, POINTER(kind)]
    index, row = 0, kind()
    while read(index, byref(row)) == 0:
        yield row
        index, row = index + 1, kind()


def _parameter(row: _Row) -> Parameter:
    choices = tuple(row.choices.decode().split("|")) if row.choices else ()
    section, field, text = row.section.decode(), row.field.decode(), row.text.decode()
    return Parameter(section, field, row.nominal, row.lower, row.upper, text, bool(row.is_option), choices)


def _effect(row: _Effect, values: list[_Row]) -> Effect:
    name = row.name.decode()
    mine = values[row.first_value : row.first_value + row.value_count]
    return Effect(
        name=name,
        site=row.site.decode().removesuffix("_TABLE"),
        memory=row.memory,
        substeps=row.substeps,
        equation=row.equation.decode(),
        source=row.source.decode(),
        look_alikes=tuple(other.strip() for other in row.look_alikes.decode().split(",") if other.strip()),
        parameters=tuple(
            EffectParameter(name, value.field.decode(), value.nominal, value.lower, value.upper, value.text.decode()) for value in mine
        ),
        is_learned=bool(row.is_learned),
        is_own=bool(row.is_own),
    )


@functools.cache
def read_definitions(path: Path) -> Definitions:
    """Both lists as the library at `path` has them. Raises LibraryError when it cannot be loaded or is older than these tools."""
    opened = open_library(path)
    parameters = tuple(_parameter(row) for row in _rows(opened, "ema_desk_parameter_row", _Row))
    values = list(_rows(opened, "ema_desk_effect_value_row", _Row))
    return Definitions(parameters, tuple(_effect(row, values) for row in _rows(opened, "ema_desk_effect_row", _Effect)))


def load_definitions() -> Definitions:
    """Both lists of the libraries in use. Raises LibraryError without any."""
    return _loaded(os.environ.get(_FOLDER))


@functools.cache
def _loaded(_named: str | None) -> Definitions:
    # asked for with every value of every model run: no look at the disk each time
    return read_definitions(library_path(64))


def project_definitions() -> Definitions:
    """Both lists as the project has them, without effects of the user's own."""
    known = load_definitions()
    return replace(known, effects=tuple(effect for effect in known.effects if not effect.is_own))


def defaults() -> dict[str, float]:
    """The reference actuator without effects: every `section.field` and `effect.field` at its nominal value."""
    return {row.name: row.nominal for row in load_definitions().rows}


def is_size(name: str) -> bool:
    """Whether a value, `effects.effect.field`, is the size of its effect."""
    return name in {f"effects.{effect.size.name}" for effect in load_definitions().effects}
