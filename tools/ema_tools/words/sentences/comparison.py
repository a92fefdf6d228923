"""What `ema compare` says."""

from __future__ import annotations

from ema_tools.compare.comparison import Comparison, ErrorPart
from ema_tools.data.machine_state import FOUND
from ema_tools.tasks.model_error import ModelError
from ema_tools.words.sentences.sensors import is_outside_mechanics, reading_sentence, sensor_sentence

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


def error_sentence(record: str, error: ModelError) -> str:
    """The weighted error of a model on a record, with the CSJ and BLK that it is reached with."""
    values = [f"{FOUND[name].partition('_')[0].upper()} {value:.4g} {FOUND[name].partition('_')[2]}" for name, value in error.today.items()]
    verb = "explains" if error.explains else "does not explain"
    when = "today" if error.explains else "at best, which is no reading while the model lacks something"
    given = f" ({' and '.join(values)} {when})" if values else ""
    return f"The model {verb} {record}: weighted error {error.fitted:.4g}, noise level {error.noise_level:.4g}{given}."


def sentence(found: Comparison, error: ModelError | None = None) -> str:
    """The comparison: the weighted error first, then the balance that leaves most."""
    if found.unlike:
        return f"{found.record} tells nothing of the machine as it is: {'; '.join(found.unlike)}."
    largest = _largest(found)
    if found.reading is not None:
        reading = f"{reading_sentence(found.reading)}."
        largest = reading if is_outside_mechanics(found.reading) else f"{reading} {largest}"
    if error is None:
        return largest
    excess = max((balance.excess_percent for balance in found.balances.values() if not balance.reason), default=0.0)
    first = error_sentence(found.record, error)
    if error.explains:
        return first
    if error.sensor is not None and found.reading is None:
        told = sensor_sentence(error.sensor)
        return f"{first} {told[:1].upper()}{told[1:]}."
    return f"{first} {largest if excess > 0.0 else 'No balance by itself leaves more than sensor noise and method.'}"


def _largest(found: Comparison) -> str:
    """The balance with the largest unexplained part."""
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
