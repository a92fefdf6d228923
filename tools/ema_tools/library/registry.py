"""The records of all effects, found by name and joined to their rows of `ema_effects.def`."""

from __future__ import annotations

import functools
import importlib
import pkgutil
from collections.abc import Collection, Iterator, Mapping, Sequence

from ema_tools.base.errors import LibraryError
from ema_tools.library import effects
from ema_tools.library.definitions import Definitions, Effect, load_definitions
from ema_tools.library.faults import FAULT_RECORDS
from ema_tools.library.measurements import MEASUREMENTS, Measurement
from ema_tools.library.record import GENERIC, EffectRecord


def _fields(record: EffectRecord) -> Iterator[str]:
    """Fields of the effect's row that a record names."""
    if record.typical is not None:
        yield from record.typical.values
    if record.slight is not None:
        yield from (name for values in record.slight.free for name in values)
    yield from (*record.shapes, *record.onboard.shapes, *record.onboard.of_reach)
    if record.periodic is not None:
        yield "phase_rad"
        yield from ("periods",) if record.periodic.periods else ()
    if record.local is not None:
        yield from (*record.local.tried, *record.local.in_balance)


def _check(row: Effect, record: EffectRecord) -> None:
    file = f"library/effects/{row.name}.py"
    known = {value.field for value in row.parameters}
    for name in _fields(record):
        if name not in known:
            raise LookupError(f"{file}: {name} is no parameter of {row.name}: it has {', '.join(value.field for value in row.parameters)}")
    given = (record.typical.values,) if record.typical is not None else ()
    slight = record.slight.free if record.slight is not None else ()
    for values in (*given, *slight):
        if next(iter(values), "") != row.size.field:
            raise LookupError(
                f"{file}: {row.size.field}, the size, does not stand first among {', '.join(values) or 'no values'}: put it there"
            )


def joined(definitions: Definitions, described: Mapping[str, EffectRecord]) -> dict[str, EffectRecord]:
    """The record of every effect of the list, in its order; one of the user's own has the generic one.

    Raises LookupError for a row of the project's without a record, a record without a row, and what a record says that the list does not bear out.
    """
    found = {}
    for row in definitions.effects:
        if row.name in described:
            _check(row, described[row.name])
        elif not row.is_own:
            raise LookupError(f"{row.name}: ema_effects.def has it, library/effects/{row.name}.py is missing: write it")
        found[row.name] = described.get(row.name, GENERIC)
    parameters = {row.name for row in definitions.parameters}
    for name, record in described.items():
        if name not in found:
            raise LookupError(f"library/effects/{name}.py: no row of ema_effects.def has this name: add one, or remove the file")
        for value in (record.confounded.parameter if record.confounded is not None else "", record.base_value):
            if value and value not in parameters:
                raise LookupError(f"library/effects/{name}.py: {value} is no row of ema_params.def: correct it")
        for other in record.inseparable:
            if other not in described or name not in described[other].inseparable:
                raise LookupError(f"library/effects/{name}.py: inseparable from {other}, whose record does not say so: say it in both")
    return found


@functools.cache
def described() -> dict[str, EffectRecord]:
    """The records of the folder `effects` by name, in its order."""
    names = sorted(module.name for module in pkgutil.iter_modules(effects.__path__))
    return {name: importlib.import_module(f"{effects.__name__}.{name}").EFFECT for name in names}


@functools.lru_cache(maxsize=2)
def _joined(definitions: Definitions) -> dict[str, EffectRecord]:
    try:
        return joined(definitions, described())
    except LookupError as error:
        raise LibraryError(str(error)) from None


def records() -> Mapping[str, EffectRecord]:
    """The record of every effect of the lists in use, in their order. Raises LibraryError that says what `joined` does."""
    return _joined(load_definitions())


def record_of(effect: str) -> EffectRecord:
    """What is known of an effect; of a fault parameter, nothing."""
    return records().get(effect, GENERIC)


def named() -> tuple[str, ...]:
    """The effects that have a physical name, in the order of the list: all but tables of what has none."""
    return tuple(name for name, record in records().items() if record.learned is None or record.along is not None)


def called(effect: str) -> str:
    """What people know an effect by that the balance of forces found: a table over the stroke by what it is there, any other by its row's name."""
    along = record_of(effect).along
    return along.called if along is not None else effect


def effect_called(name: str) -> str:
    """The effect that people know by a name: the reverse of `called`."""
    return next((effect for effect in named() if called(effect) == name), name)


def learned_effect(balance: str, friction: bool = False) -> str:
    """The effect whose table holds what is left of a balance."""
    return next(
        name
        for name, record in records().items()
        if record.learned and (record.learned.balance, record.learned.friction) == (balance, friction)
    )


def effect_of_base_value(name: str) -> str:
    """The effect that is one with a base value of the mechanical balance."""
    return next(effect for effect, record in records().items() if record.base_value == name)


def separable(names: Sequence[str]) -> bool:
    """Whether a command may separate an effect from its rivals, which follow it; no command does where the library says so of all of them."""
    return bool(names) and not set(names) <= {names[0], *record_of(names[0]).inseparable}


def separating(names: Collection[str]) -> tuple[Measurement, ...]:
    """Measurements that separate all of these effects and fault parameters from each other, in the order in which they are advised."""
    by = [FAULT_RECORDS[name].separated_by if name in FAULT_RECORDS else record_of(name).separated_by for name in names]
    return tuple(one for one in MEASUREMENTS if all(one in some for some in by))
