"""What an actuator's enabled effects make of its values, by the module's own equations."""

from __future__ import annotations

from ema_tools.data.actuator import Actuator
from ema_tools.library.definitions import load_definitions
from ema_tools.plant.native import library


def acts(actuator: Actuator, site: str) -> bool:
    """Whether an effect of a site is active."""
    active = set(actuator.active_effects)
    return any(effect.site == site and effect.name in active for effect in load_definitions().effects)


def adjusted(actuator: Actuator) -> dict[str, float]:
    """The values with the enabled PARAMETER effects in them, by name."""
    values = dict(actuator.values)
    if acts(actuator, "PARAMETER"):
        reals = load_definitions().reals
        numbers = library().adjusted(*actuator.arrays())[: len(reals)]
        values.update(zip((row.name for row in reals), numbers.tolist(), strict=True))
    return values


def transmission_of(actuator: Actuator) -> str:
    """The effect that places the rod behind the play, empty without one."""
    for effect in load_definitions().effects:
        if effect.site == "TRANSMISSION" and effect.name in actuator.active_effects:
            return effect.name
    return ""
