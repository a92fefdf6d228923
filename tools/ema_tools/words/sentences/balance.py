"""What `ema diagnose` says by the balance of forces."""

from __future__ import annotations

import math

from ema_tools.fit.division import By
from ema_tools.results.diagnosis import FrictionShape
from ema_tools.tasks.diagnose_by_balance import BalanceAnswer

# What is fitted and held out, in the plural.
PARTS: dict[By, str] = {"lap": "laps", "block": "stretches", "record": "records"}


def sentence(found: BalanceAnswer) -> str:
    """The answer in a sentence or two."""
    given, division = found.forces.given, found.forces.division
    parts = PARTS[division.by]
    floor = f"the laps repeat to {found.forces.floor_percent:.2f} %" if math.isfinite(found.forces.floor_percent) else "no floor is known"
    if not found.accepted:
        said = (
            f"no effect of the library carries over to the {parts} held out"
            if found.verdict == "unknown"
            else "nothing exceeds what the laps repeat"
            if math.isfinite(found.forces.floor_percent)
            else f"no effect of the library lowers the error on the {parts} held out"
        )
        return f"{found.names}: {said} (force error {given.training:.2f} %, {floor})."
    last = found.forces.steps[-1].errors
    names = ", ".join(step.effect for step in found.accepted)
    return (
        f"{found.names}: missing are {names}: force error {given.training:.2f} % on the {parts} fitted and {given.holdout:.2f} % on the {parts} held out before,"
        f" {last.training:.2f} % and {last.holdout:.2f} % after; {floor}."
    )


def friction_sentence(found: FrictionShape) -> str:
    """Where steady friction is least, and how far above that it is at standstill."""
    turns = found.minimum_at_rad_s * 60.0 / (2.0 * math.pi)
    return f"Friction at standstill is {found.above_minimum_percent:.2g} % above its minimum, which lies at {found.minimum_at_rad_s:.3g} rad/s ({turns:.3g} rpm) of the motor."


def next_step(found: BalanceAnswer) -> str:
    """What to do next."""
    if found.accepted:
        return "Next: --fitted NEW.toml writes the model with these effects; hold it against a record of another motion with ema compare."
    return "Next: record another motion, and the current, so that more of the mechanics is seen."
