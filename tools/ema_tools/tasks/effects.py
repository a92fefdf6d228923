"""The library of optional effects: what `ema effects` shows."""

from __future__ import annotations

from ema_tools.base.errors import InputError
from ema_tools.data.actuator import alike
from ema_tools.library.definitions import Effect, load_definitions
from ema_tools.library.registry import called


def find_effect(name: str) -> Effect:
    """The effect called `name`, by its row or by what people know it by. Raises InputError with the names that are most like it."""
    known = {effect.name: effect for effect in load_definitions().effects}
    count = len(known)
    known |= {called(effect): row for effect, row in known.items()}
    if name not in known:
        near = alike(name, known)
        hint = f" (did you mean {', '.join(near[:-1])}{' or ' if near[1:] else ''}{near[-1]}?)" if near else ""
        raise InputError(f"effect {name}: unknown{hint}: ema effects lists all {count}")
    return known[name]
