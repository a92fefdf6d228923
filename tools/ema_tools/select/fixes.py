"""What a user states of a fit by the balance of forces: base values that stay as they are, base values between two ends, and effects that are not refitted."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from ema_tools.balances.mechanical import MECHANICAL_PARAMETERS
from ema_tools.base.errors import InputError
from ema_tools.data.actuator import Actuator, nearest, row_of
from ema_tools.library.registry import named


@dataclass(frozen=True)
class Fixes:
    """`kept`: base values that stay as the actuator states them; `between`: the ends of others, in the actuator's units; `effects`: those whose values stay. All by full name.

    `undetermined`: base values that stay as well, not by the user but since the records do not tell them from an effect.
    """

    kept: frozenset[str] = frozenset()
    between: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    effects: frozenset[str] = frozenset()
    undetermined: frozenset[str] = frozenset()

    @property
    def as_stated(self) -> frozenset[str]:
        """Base values that are not fitted."""
        return self.kept | self.undetermined

    def with_effects(self, more: frozenset[str]) -> Fixes:
        """The same with more effects that stay as they are."""
        return replace(self, effects=self.effects | more)

    def without(self, base_value: str) -> Fixes:
        """The same with a base value that the records do not determine."""
        return replace(self, undetermined=self.undetermined | {base_value})


NONE = Fixes()


def fixes_of(actuator: Actuator, texts: Sequence[str]) -> Fixes:
    """NAME and NAME=LOW..HIGH as typed. Raises InputError that says what to write."""
    names = _names()
    kept: set[str] = set()
    between: dict[str, tuple[float, float]] = {}
    effects: set[str] = set()
    for text in texts:
        short, mark, ends = (part.strip() for part in text.partition("="))
        name = names.get(short.removeprefix("effects."))
        if name is None:
            known = ", ".join(row_of(one).field.partition("_")[0] for one in MECHANICAL_PARAMETERS)
            raise InputError(f"--fix {text}: no base value and no effect{nearest(short, names)}: write one of {known}, or an effect's name")
        if name in kept or name in between or name in effects:
            raise InputError(f"--fix {text}: {short} is given twice: give every value once")
        if name not in MECHANICAL_PARAMETERS:
            if mark:
                raise InputError(f"--fix {text}: an effect stays as it is, or is refitted: write --fix {short}, or leave it out")
            if name not in actuator.active_effects:
                raise InputError(f"--fix {text}: {actuator.file or actuator.name} does not hold {name}: leave it out")
            effects.add(name)
        elif mark:
            between[name] = _ends(text, name, ends)
        else:
            kept.add(name)
    return Fixes(frozenset(kept), between, frozenset(effects))


def _ends(text: str, name: str, ends: str) -> tuple[float, float]:
    row = row_of(name)
    try:
        low, high = (float(end) for end in ends.split(".."))
    except ValueError:
        raise InputError(f"--fix {text}: write NAME=LOW..HIGH, in {row.unit or 'its unit'}, or NAME alone to keep it as stated") from None
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise InputError(f"--fix {text}: the lower end is not below the upper one: write NAME=LOW..HIGH, in {row.unit or 'its unit'}")
    if low < row.lower or high > row.upper:
        raise InputError(f"--fix {text}: outside {row.lower:g} .. {row.upper:g} {row.unit}: give ends inside".replace("  ", " "))
    return low, high


def _names() -> dict[str, str]:
    """Full names by every way to write them."""
    found = {effect: effect for effect in named()}
    for name in MECHANICAL_PARAMETERS:
        whole = row_of(name).field
        first = whole.partition("_")[0]
        found |= dict.fromkeys((name, whole, first), name)
    found["load_torque"] = found["load"]
    found["friction"] = found["csj"]
    return found
