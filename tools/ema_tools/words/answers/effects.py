"""The result of `ema effects`."""

from __future__ import annotations

from collections.abc import Iterable

from ema_tools.library.definitions import Effect
from ema_tools.library.registry import record_of
from ema_tools.results.effects import Effects, EffectValue, LibraryEffect

SITES = {
    "PARAMETER": "changes parameters",
    "FRICTION": "level of dry friction",
    "TORQUE": "torque on the shaft",
    "LOAD": "load against extension",
    "VOLTAGE": "motor voltage",
    "MOTOR": "torque constant and back-EMF",
    "PRESLIDING": "contact before it slides",
    "TRANSMISSION": "between play and rod",
    "READING": "rod sensor's reading",
    "WINDING": "resistance as it warms",
    "GREASE": "dry and viscous friction as they warm",
}


def effects(rows: Iterable[Effect]) -> Effects:
    """The library, or a part of it."""
    return Effects("effects", tuple(map(_described, rows)))


def _described(effect: Effect) -> LibraryEffect:
    return LibraryEffect(
        name=effect.name,
        acts_on=SITES.get(effect.site, effect.site.lower()),
        learned=effect.is_learned,
        own=effect.is_own,
        equation=effect.equation,
        source=effect.source,
        signature=record_of(effect.name).shows,
        look_alikes=tuple(effect.look_alikes),
        parameters=tuple(
            EffectValue(row.field, row.unit, row.nominal if row is effect.size else None, row.nominal, row.lower, row.upper, row.text)
            for row in effect.parameters
        ),
    )
