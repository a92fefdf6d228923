"""An actuator as the blocks see it: one named tuple per section of `ema_params.def`, one per effect."""

from __future__ import annotations

import math
from collections import namedtuple
from collections.abc import Mapping
from typing import Any

from ema_tools.definitions import Definitions, defaults, load_definitions

# The lists decide the fields, so the types are made from them.
_DEFINITIONS: Definitions = load_definitions()
_BLOCK_SECTIONS = ("control", "drive", "motor", "gearbox", "screw", "encoder", "timing")
_SECTION_TYPES: dict[str, Any] = {
    section: namedtuple(section.capitalize(), [row.field for row in _DEFINITIONS.sections[section]])  # type: ignore[misc]
    for section in _BLOCK_SECTIONS
}
_EFFECT_TYPES: dict[str, Any] = {
    effect.name: namedtuple(effect.name, [value.field for value in effect.parameters])  # type: ignore[misc]
    for effect in _DEFINITIONS.effects
}
_Effects: Any = namedtuple("Effects", list(_EFFECT_TYPES))  # type: ignore[misc]
Actuator: Any = namedtuple("Actuator", [*_BLOCK_SECTIONS, "effects"])


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
    """The named tuples of a complete set of values; options as whole numbers."""
    sections = []
    for section in _BLOCK_SECTIONS:
        rows = _DEFINITIONS.sections[section]
        numbers = [int(values[row.name]) if row.is_option else float(values[row.name]) for row in rows]
        sections.append(_SECTION_TYPES[section](*numbers))
    effects = [
        _EFFECT_TYPES[effect.name](*(float(values[value.name]) for value in effect.parameters))
        for effect in _DEFINITIONS.effects
    ]
    return Actuator(*sections, _Effects(*effects))
