"""Where a model fails, in words."""

from __future__ import annotations

from ema_tools.compare.comparison import TITLES
from ema_tools.compare.localisation import Where
from ema_tools.select.sensors import CLOCK, Suspect
from ema_tools.words.sentences.comparison import GROUPS
from ema_tools.words.sentences.sensors import is_outside_mechanics, reading_sentence


def sentence(found: Where, sensor: Suspect | None = None) -> str:
    """Where the model fails, in one sentence; `sensor`: whose own error explains it, where one does."""
    blocks = found.blocks
    there = [block for block in blocks if not block.reason]
    against = "the healthy repeats" if found.relative else "sensor noise and method"
    if not there:
        return f"No balance can be drawn: {blocks[0].reason}; only the signals themselves can be compared."
    telling = sorted((block for block in there if block.telling), key=lambda block: -block.share)
    missing = [block.name for block in blocks if block.reason]
    without = f" (not to be had: {', '.join(missing)})" if missing else ""
    if not telling:
        return f"In {found.record} no balance shows more than {against} explain{without}."
    worst = telling[0]
    reading = ""
    if found.reading is not None and (sensor is None or sensor.channel == found.reading.channel):
        reading = f"{reading_sentence(found.reading)}."
        if is_outside_mechanics(found.reading):
            return reading
    elif sensor is not None:
        pattern = f", {worst.winner.words}" if worst.winner is not None else ""
        used = f"{GROUPS[worst.name]} are weighed with it, so that the {worst.name} balance stands out"
        what = "recorder's clock" if sensor.channel == CLOCK else f"sensor of the {TITLES[sensor.channel]}"
        return f"The error is that of the {what}{pattern}; {used}."
    verb = "of the excess over the healthy repeats" if found.relative else "of what the model leaves unexplained"
    text = f"{100.0 * worst.share:.0f} % {verb} lies in the {worst.name} balance ({GROUPS[worst.name]}){without}"
    if worst.winner is not None:
        text += f", {worst.winner.words} ({100.0 * worst.of_excess(worst.winner):.0f} % of it)"
    place = next((place for place in found.places if place.source == f"{worst.name} balance" and place.surprise > 0.1), None)
    if place is not None and place.time_share is not None:
        text += f"; {100.0 * place.share:.0f} % of it at {place.by} {place.part}, {100.0 * place.time_share:.0f} % of the time"
    if len(telling) > 1 and telling[1].share > 0.05:
        second = telling[1]
        text += f"; then the {second.name} balance with {100.0 * second.share:.0f} %" + (
            f", {second.winner.words}" if second.winner is not None else ""
        )
    return f"{reading} {text}.".strip()
