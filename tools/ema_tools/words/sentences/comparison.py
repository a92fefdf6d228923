"""What `ema compare` says."""

from __future__ import annotations

from ema_tools.compare.comparison import Comparison, ErrorPart

# What each balance holds.
GROUPS = {
    "mechanical": "motor torque, friction, inertia and load",
    "electrical": "winding, back-EMF and supply",
    "kinematic": "gears, screw, play and sensors",
    "controller": "the control law and its feedback",
}


def place_name(place: ErrorPart) -> str:
    """A part of a residual."""
    return f"{place.source}: {place.by} {place.part}" if place.by else f"{place.source}: {place.part}"


def sentence(found: Comparison) -> str:
    """The comparison in one sentence."""
    if found.unlike:
        return f"{found.record} tells nothing of the machine as it is: {'; '.join(found.unlike)}."
    balances = found.balances
    there = {name: error for name, error in balances.items() if not error.reason}
    if not there:
        return f"No balance can be drawn: {balances['mechanical'].reason}; only the channels' errors are known."
    worst = max(there, key=lambda name: there[name].excess_percent)
    if not there[worst].excess_percent > 0.0:
        return f"The model explains {found.record} as far as sensor noise and method can tell, in every balance that can be drawn ({', '.join(there)})."
    error = there[worst]
    text = f"The model's largest unexplained part is in the {worst} balance ({GROUPS[worst]}): {error.relative_percent:.3g} % of its measured side"
    parts = [place for place in found.where if place.source == f"{worst} balance"]
    telling = max(parts, key=lambda place: place.surprise, default=None)
    if telling is not None and telling.surprise > 0.0 and telling.time_share is not None:
        text += (
            f"; {100.0 * telling.share:.0f} % of that lies at {telling.by} {telling.part}, {100.0 * telling.time_share:.0f} % of the time"
        )
    return text + "."
