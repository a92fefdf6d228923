"""The library of optional effects: what `ema effects` shows."""

from __future__ import annotations

from ema_tools.base.errors import InputError
from ema_tools.data.actuator import nearest
from ema_tools.library.definitions import Effect, load_definitions


def find_effect(name: str) -> Effect:
    """The effect called `name`. Raises InputError with the nearest name."""
    known = {effect.name: effect for effect in load_definitions().effects}
    if name not in known:
        raise InputError(f"effect {name}: unknown{nearest(name, known)}: effects are {', '.join(known)}")
    return known[name]
