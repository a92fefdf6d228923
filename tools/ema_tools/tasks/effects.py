"""The library of optional effects: what `ema effects` shows."""

from __future__ import annotations

from typing import Any

from ema_tools.base.errors import InputError
from ema_tools.data.actuator import nearest
from ema_tools.library.definitions import Effect, load_definitions
from ema_tools.library.registry import record_of

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
}


def find_effect(name: str) -> Effect:
    """The effect called `name`. Raises InputError with the nearest name."""
    known = {effect.name: effect for effect in load_definitions().effects}
    if name not in known:
        raise InputError(f"effect {name}: unknown{nearest(name, known)}: effects are {', '.join(known)}")
    return known[name]


def describe(effect: Effect) -> dict[str, Any]:
    """Everything about an effect, for JSON."""
    return {
        "name": effect.name,
        "acts_on": SITES.get(effect.site, effect.site.lower()),
        "learned": effect.is_learned,
        "own": effect.is_own,
        "equation": effect.equation,
        "source": effect.source,
        "signature": record_of(effect.name).shows,
        "look_alikes": list(effect.look_alikes),
        "parameters": [
            {
                "field": row.field,
                "unit": row.unit,
                "zero": row.nominal if row is effect.size else None,
                "nominal": row.nominal,
                "lower": row.lower,
                "upper": row.upper,
                "text": row.text,
            }
            for row in effect.parameters
        ],
    }
