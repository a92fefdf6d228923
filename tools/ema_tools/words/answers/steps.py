"""Parts that several results share: the fall of an error, a suspected sensor, and short names."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from ema_tools.data.actuator import row_of, shown
from ema_tools.results import parts
from ema_tools.select.forward_errors import Forward
from ema_tools.select.holdout import ErrorFall, Rung
from ema_tools.select.sensors import Suspect
from ema_tools.words.sentences.sensors import sensor_next, sensor_sentence

FIRST = "as given"
REFITTED = "base values refitted"
FORCE_UNIT = "% of the drive's force"


def errors(found: ErrorFall) -> parts.WeightedErrors:
    """From the first model to the last."""
    return parts.WeightedErrors(found.before, found.after, found.floor, found.holdout_before, found.holdout_after, found.holdout_floor)


def steps(way: Sequence[Rung]) -> tuple[parts.StepEntry, ...]:
    """Model by model."""
    return tuple(
        parts.StepEntry(
            tuple(step.effects),
            step.added or FIRST,
            step.error,
            step.holdout,
            *step.told,
            loads(step.values),
        )
        for step in way
    )


def loads(values: Mapping[str, float]) -> dict[str, float]:
    """What makes a model of the first, by full name; what was not determined stays as it was."""
    return {shown(row_of(name)): value for name, value in values.items() if math.isfinite(value)}


def forward(found: Forward) -> parts.ForwardErrors:
    """The forward solution beside the balance."""
    return parts.ForwardErrors(*_had(found.motion), *_had(found.holdout), *_had(found.drive), found.reads)


def _had(pair: tuple[float, float]) -> tuple[float | None, float | None]:
    before, after = (error if math.isfinite(error) else None for error in pair)
    return before, after


def sensor(one: Suspect) -> parts.Sensor:
    """The sensor whose own error something looks like."""
    return parts.Sensor(one.channel, one.share, one.cost, one.factor, one.offset, one.late_s, sensor_sentence(one), sensor_next(one))


def field_of(name: str) -> str:
    """The last word of a value's full name."""
    return name.split(".")[-1]
