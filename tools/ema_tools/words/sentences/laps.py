"""What `ema diagnose` says of a command that repeats."""

from __future__ import annotations

import math

from ema_tools.tasks.diagnose_by_laps import LapsAnswer


def sentence(found: LapsAnswer) -> str:
    """The answer in a sentence or two."""
    given = found.forces.given
    floor = f"the laps repeat to {found.forces.floor_percent:.2f} %" if math.isfinite(found.forces.floor_percent) else "no floor is known"
    if not found.accepted:
        said = (
            "no effect of the library carries over to the laps held out"
            if found.verdict == "unknown"
            else "nothing exceeds what the laps repeat"
        )
        return f"{found.record.file}: {said} (force error {given.training:.2f} %, {floor})."
    last = found.forces.steps[-1].errors
    names = ", ".join(step.effect for step in found.accepted)
    return (
        f"{found.record.file}: missing are {names}: force error {given.training:.2f} % on the laps fitted and {given.holdout:.2f} % on the laps held out before,"
        f" {last.training:.2f} % and {last.holdout:.2f} % after; {floor}."
    )


def next_step(found: LapsAnswer) -> str:
    """What to do next."""
    if found.accepted:
        return "Next: --fitted NEW.toml writes the model with these effects; hold it against a record of another motion with ema compare."
    return "Next: record another motion, and the current, so that more of the mechanics is seen."
