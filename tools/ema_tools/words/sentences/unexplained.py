"""What is left after the best known effects, in words."""

from __future__ import annotations

from collections.abc import Sequence

from ema_tools.compare.unexplained import NODES, REPEATS_SHARE, RICHER, LearnedTable, Ranked, Unknown
from ema_tools.library.display_names import coded

_WORDS = {
    "speed": "with speed",
    "position": "with position",
    "place in the lead": "with the screw lead",
    "motor angle": "with the motor angle",
    "current": "with current",
    "acceleration": "with acceleration",
    "time since reversal": "with the time since reversal",
    "time": "slowly in time",
    "constant": "as a constant",
}


def words(one: Ranked) -> str:
    """As in: it repeats ..."""
    return _WORDS[one.axis] + (", against the motion" if one.friction else "")


def learned_sentence(one: LearnedTable) -> str:
    """What a table is and where it holds."""
    return f"{coded(one.effect)}, a table over {one.axis} seen from {one.first:.4g} to {one.last:.4g} {one.unit}: outside that range it holds its edge value and nothing is known"


def first_sentence(unknowns: Sequence[Unknown]) -> str:
    """That of the most telling balance."""
    return sentence(unknowns[0]) if unknowns else "no balance can be drawn, so the unknown cannot be drawn either"


def sentence(found: Unknown) -> str:
    """What it repeats with."""
    what, ranked = found.what, found.ranked
    best = ranked[0]
    if best.of_excess < REPEATS_SHARE:
        return f"the unknown {what} repeats with none of the axes: the best, {best.axis}, foretells {max(0.0, 100.0 * best.explained):.0f} % of it on other passes"
    text = f"the unknown {what} repeats {words(best)} ({100.0 * best.of_excess:.0f} % of it foretold on other passes)"
    if best.explained - best.tabled > RICHER and best.axis != "constant":
        text += f", in finer detail than a table of {NODES} nodes holds"
    rivals = {"position": "place in the lead", "place in the lead": "position"}
    rival_name = rivals.get(best.axis, "")
    rival = max((one for one in ranked if one.axis == rival_name), key=lambda one: one.explained, default=None)
    if rival_name and rival is None:
        text += "; position and screw lead cannot be told apart on a stroke below one lead"
    elif rival is not None:
        alike = best.explained - rival.explained < RICHER
        text += f"; {'as well' if alike else 'not'} {_WORDS[rival.axis]} ({100.0 * rival.of_excess:.0f} %)"
    second = next(
        (one for one in ranked[1:] if one.axis not in (best.axis, rival_name, "constant") and best.explained - one.explained < RICHER),
        None,
    )
    if second is not None and best.axis != "constant":
        text += f"; nearly as well {words(second)} ({100.0 * second.of_excess:.0f} %)"
    return text
