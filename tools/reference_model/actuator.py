"""An actuator as the blocks see it: one structure per section of `ema_params.def`, one per effect."""

from __future__ import annotations

import math
from collections import namedtuple
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ema_tools.base.compiled import HAS_NUMBA
from ema_tools.library.definitions import Definitions, defaults, project_definitions


def _tuple_type(name: str, fields: Iterable[str]) -> Any:
    """A named tuple whose fields the lists decide, so that no checker can know them."""
    return namedtuple(name, fields)


_DEFINITIONS: Definitions = project_definitions()
_BLOCK_SECTIONS = ("control", "drive", "motor", "gearbox", "screw", "encoder", "timing")
Effects = _tuple_type("Effects", [effect.name for effect in _DEFINITIONS.effects])
Actuator = _tuple_type("Actuator", [*_BLOCK_SECTIONS, "effects"])


def _structure(fields: Mapping[str, float | int]) -> Any:
    """Numbers by name as one value with attributes: a pointer to compiled code, a tuple to Python."""
    if not HAS_NUMBA:
        return _tuple_type("Structure", fields)(**fields)
    kind = np.dtype([(name, np.int64 if isinstance(value, int) else np.float64) for name, value in fields.items()])
    return np.rec.array([tuple(fields.values())], dtype=kind)[0]


def filled(values: Mapping[str, float]) -> dict[str, float]:
    """Every value of an actuator: `values` over the nominal ones.

    Raises KeyError for a name that the lists do not have, ValueError for a value outside its range.
    """
    complete = defaults()
    for name, value in values.items():
        row = _DEFINITIONS.find(name)
        number = float(value)
        if not (math.isfinite(number) and row.lower <= number <= row.upper):
            raise ValueError(f"{name} = {value}: outside {row.lower:g} .. {row.upper:g}: give a value inside")
        complete[name] = number
    return complete


def is_active(effect: str, values: Mapping[str, float]) -> bool:
    """Whether the first parameter of `effect` differs from its zero."""
    size = _DEFINITIONS.effect(effect).size
    return values[size.name] != size.nominal


def build(values: Mapping[str, float]) -> Any:
    """The structures of a complete set of values; options as whole numbers."""
    sections = []
    for section in _BLOCK_SECTIONS:
        rows = _DEFINITIONS.sections[section]
        sections.append(_structure({row.field: int(values[row.name]) if row.is_option else float(values[row.name]) for row in rows}))
    effects = [_structure({value.field: float(values[value.name]) for value in effect.parameters}) for effect in _DEFINITIONS.effects]
    return Actuator(*sections, Effects(*effects))
