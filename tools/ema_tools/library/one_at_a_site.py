"""Sites at which one effect acts at a time: the contact that carries dry friction, and what lies between motor and rod. Of two the module runs the first of its list."""

from __future__ import annotations

import functools
from collections.abc import Collection, Mapping

from ema_tools.library.definitions import load_definitions
from ema_tools.library.registry import record_of

# What each of them is, for a sentence.
ONE_AT_A_TIME: Mapping[str, str] = {
    "PRESLIDING": "the contact that carries dry friction",
    "TRANSMISSION": "what lies between motor and rod",
}


@functools.cache
def _sizes(site: str) -> tuple[tuple[str, str, float], ...]:
    """Name, size and the size that is none of every effect of a site."""
    names = {effect.name for effect in load_definitions().effects if effect.site == site}
    return tuple(one for one in load_definitions().sizes if one[0] in names)


def _acting(site: str, values: Mapping[str, float]) -> list[tuple[str, str, float]]:
    return [(name, size, zero) for name, size, zero in _sizes(site) if values[size] != zero]


def acting(site: str, values: Mapping[str, float]) -> tuple[str, ...]:
    """Effects of a site whose size is not none."""
    return tuple(name for name, _, _ in _acting(site, values))


def taken_out(values: Mapping[str, float], changed: Collection[str]) -> dict[str, float]:
    """Sizes of effects that stand where an effect among the values `changed` takes their place, being the same and more: a contact that yields becomes one behind a play."""
    found: dict[str, float] = {}
    for site in ONE_AT_A_TIME:
        here = _acting(site, values)
        new = [name for name, size, _ in here if size in changed]
        if len(here) > 1 and len(new) == 1:
            special = record_of(new[0]).special_case
            found |= {size: zero for name, size, zero in here if name == special}
    return found


def clash(values: Mapping[str, float]) -> str:
    """Why two effects of one site cannot both act, in words; empty where none do."""
    for site, what in ONE_AT_A_TIME.items():
        here = acting(site, values)
        if len(here) > 1:
            return f"{' and '.join(here)} are both {what}, of which there is one: leave one of them at zero"
    return ""
