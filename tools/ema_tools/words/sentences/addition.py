"""What `ema add` says."""

from __future__ import annotations

import math

from ema_tools.data.actuator import row_of
from ema_tools.fit.division import PARTS
from ema_tools.library.definitions import load_definitions
from ema_tools.library.display_names import coded, value_coded
from ema_tools.library.registry import called
from ema_tools.tasks.add import Added, Why
from ema_tools.tasks.add_by_balance import BalanceAdded
from ema_tools.words.sentences.sizes import size_text

_WHY = {
    Why.NOISE: "the error on the fitted record does not fall by more than noise can make it",
    Why.UNDETERMINED: "its size could as well be none beside what the model does not explain: ema diagnose says what would explain more",
    Why.AT_BOUND: "{value} lies on a bound of its range, so the effect stands in for another one",
    Why.NOT_HELD: "the error on the record held out does not fall",
    Why.TIED: "the error falls, but its size cannot be told from {value} (correlation {correlation:.2f}) on this record",
    Why.FALLS: "the error falls on the fitted record; no record was held out",
    Why.HELD: "the error falls on the fitted record and on the one held out",
}


def reason(found: Added) -> str:
    """Why it is recommended, or not."""
    judged = found.judgement
    return _WHY[judged.why].format(value=value_coded(judged.value) if judged.value else "", correlation=judged.correlation)


def sentence(found: Added) -> str:
    """What was done and what came of it."""
    done = "was there and is refitted" if found.refitted else "added"
    errors = f"{found.errors.before:.3g} before, {found.errors.after:.3g} after, floor {found.errors.floor:.3g}"
    text = "; ".join(
        f"{coded(effect, first=place == 0)} {done}, {_size(found, effect)}" for place, effect in enumerate(found.effects or (found.effect,))
    )
    text += f": weighted error {errors}"
    text += "".join(f", {error:.3g} without {coded(effect)}" for effect, error in found.without.items())
    if found.errors.holdout_before is not None:
        text += f"; on the record held out {found.errors.holdout_before:.3g} before, {found.errors.holdout_after:.3g} after"
    return f"{text}. {'Recommended' if found.recommended else 'Not recommended'}: {reason(found)}."


def _size(found: Added, effect: str) -> str:
    """The size of one effect with its interval."""
    own = found.fit.of_effect(effect)
    size = next(iter(own))
    return f"{row_of(size).field} {size_text(size, own[size], found.fit.std.get(size))}"


def reason_by_balance(found: BalanceAdded) -> str:
    """Why it is recommended, or not, by the balance of forces."""
    parts = PARTS[found.forces.division.by]
    return found.forces.reason or f"the force error falls on the {parts} fitted and on every one of the {parts} held out"


def sentence_by_balance(found: BalanceAdded) -> str:
    """What was done by the balance of forces, and what came of it."""
    forces = found.forces
    parts = PARTS[forces.division.by]
    size = load_definitions().effect(found.effect).size.name
    done = "was there and is refitted" if found.refitted else "added"
    errors = (
        f"force error {percent(forces.given.training)} on the {parts} fitted and {percent(forces.given.holdout)} on the {parts} held out before,"
        f" {percent(forces.errors.training)} and {percent(forces.errors.holdout)} after"
    )
    value = f"{row_of(size).field} {size_text(size, forces.values[size], forces.std.get(size))}"
    return f"{coded(called(found.effect), first=True)} {done}, {value}: {errors}. {'Recommended' if found.recommended else 'Not recommended'}: {reason_by_balance(found)}."


def percent(value: float) -> str:
    """An error in %; of what rests throughout there is none."""
    return f"{value:.2f} %" if math.isfinite(value) else "none (at rest)"


def set_sentence(effect: str, was: float | None) -> str:
    """Of values that were given."""
    size = load_definitions().effect(effect).size.field
    there = f" was there with {size} = {was:g}; it is now" if was is not None else ""
    return f"{coded(effect, first=True)}{there} set to given values; nothing was fitted."
