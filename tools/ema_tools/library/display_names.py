"""What people call things that have code names: an effect or a fault by its display name, a value by what its row says of it; in sentences the code name stands behind in brackets."""

from __future__ import annotations

import itertools
from collections.abc import Iterable

from ema_tools.library.definitions import load_definitions
from ema_tools.library.faults import FAULTS
from ema_tools.library.registry import effect_called

# Words of code names that are written otherwise.
_SPELT = {"stribeck": "Stribeck", "csj": "CSJ", "blk": "BLK"}
# Words of a value's name from which on it is its unit.
_UNITS = frozenset("Nm N s s2 rad rad2 mm degC V A ohm H m kg per sqrt".split())
_FAULTS = {"csj": "friction", "blk": "backlash"}
FAULT_TITLES = {"csj": "CSJ, static dry friction", "blk": "BLK, backlash at the rod"}


def display(name: str) -> str:
    """The display name of an effect or fault, as in `Stribeck friction`."""
    if name in _FAULTS:
        return FAULT_TITLES[name]
    spelt = " ".join(_SPELT.get(word, word) for word in name.split("_"))
    return spelt[:1].upper() + spelt[1:]


def within(name: str) -> str:
    """The same inside a sentence."""
    if name in _FAULTS:
        return f"{_FAULTS[name]} ({name.upper()})"
    shown = display(name)
    return shown if shown.split(" ")[0] in _SPELT.values() else shown[:1].lower() + shown[1:]


def coded(name: str, more: str = "", first: bool = False) -> str:
    """The display name with the code name behind it, as in `pitch ripple (its code name)`; `more` stands in the same brackets. `first`: at the beginning of a sentence."""
    shown = display(name) if first and name not in _FAULTS else within(name)
    # a name of one word says itself
    told = "; ".join(filter(None, ("" if name in (*_FAULTS, shown.lower()) else name, more)))
    return f"{shown} ({told})" if told else shown


def all_coded(names: Iterable[str], joint: str = ", ") -> str:
    """Several in a row."""
    return joint.join(map(coded, names))


def value_called(name: str) -> str:
    """A value by what it is, as in `winding resistance`; by its name where nothing is known of it."""
    fault = _fault_of(name)
    if fault:
        return within(fault)
    known = load_definitions()
    effect, _, field = name.removeprefix("effects.").partition(".")
    if any(effect_called(effect) == one.name for one in known.effects):
        return f"{_field_words(field)} of {within(effect)}"
    return value_words(known.by_name[name].text, field) if name in known.by_name else name


def value_coded(name: str) -> str:
    """The same with its full name behind it, as in `winding resistance (motor.resistance_ohm)`."""
    called = value_called(name)
    # a fault has its name in brackets already
    return called if called == name or _fault_of(name) else f"{called} ({name})"


def _fault_of(name: str) -> str:
    """The fault that a value is; empty for any other."""
    return next((fault for fault, value in FAULTS.items() if value == name), "")


def value_words(text: str, field: str) -> str:
    """A value of the machine in a few words, by the text of its row; by its name where that text is a sentence about `this`."""
    plain = text.partition(",")[0].partition(";")[0]
    mode, said, rest = plain.partition(": ")
    plain = rest if said and mode.islower() else plain
    return _field_words(field) if "this" in plain.split() or "(1" in plain else plain


def _field_words(field: str) -> str:
    return " ".join(itertools.takewhile(lambda word: word not in _UNITS, field.split("_")))


def listed(names: list[str]) -> str:
    """Names in a row: `a`, `a and b`, `a, b and c`."""
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
