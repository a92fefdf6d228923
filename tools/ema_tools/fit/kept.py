"""What is kept of a unit's readings: the newest as they are, older ones joined with their neighbours, so that a unit of any age is a bounded number of knots.

Equations: docs/DESIGN.md, "Trend and time to a limit"; firmware keeps the same (include/ema/ema_trend.h), and neither is translated from the other.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ema_tools.base.arrays import Reals

KNOTS = 48  # readings that are kept, joined ones as one [layout]
_NEWEST = 6  # of them that are never joined [judgement]
SIDE = 2  # readings on each side by which one is seen to lie far off [judgement]
_OUTLIER = 2.5  # standard deviations off its neighbours beyond which a reading counts less [judgement]
_CLIP = 3.0  # standard deviations beyond which a deviation tells no more of the scatter [judgement]
_CLIPPED = 0.9733  # of the square of a normal deviation that is clipped there [chance]
_BEFORE = 8  # readings that have said before any that they scatter by what they state [judgement]
_LEAST = 0.25  # square of the least scatter [judgement]


@dataclass(frozen=True)
class Knots:
    """Knots [n]: time since the first reading, value and standard error by all that is known of the scatter."""

    time: Reals
    value: Reals
    std: Reals


def kept(days: Reals, values: Reals, stds: Reals) -> Knots:
    """The knots of readings [n] in order."""
    time = np.array([], dtype=np.float64)
    value, std = time, time
    square, taken = 1.0, 0
    for day, one, error in zip(days - days[0], values, stds, strict=True):
        if time.size == KNOTS:
            time, value, std = _joined(time, value, std)
        time, value, std = np.append(time, day), np.append(value, one), np.append(std, error)
        taken += 1
        if taken > SIDE:
            square = _scatter(square, taken, time[-3:], value[-3:], std[-3:])
        if taken > 2 * SIDE:
            first = 0 if taken == 2 * SIDE + 1 else time.size - 1 - SIDE
            std = _robust(value, std, square, range(first, time.size - SIDE))
    if taken > 2 * SIDE:
        std = _robust(value, std, square, range(time.size - SIDE, time.size))
    return Knots(time, value, std * math.sqrt(max(1.0, square)))


def _joined(time: Reals, value: Reals, std: Reals) -> tuple[Reals, Reals, Reals]:
    """Two neighbours made one, those least apart before the newest."""
    place = int(np.argmin(np.diff(time[: KNOTS - _NEWEST])))
    pair = slice(place, place + 2)
    weight = std[pair] ** -2.0
    mean = [float(np.average(of[pair], weights=weight)) for of in (time, value)]
    rest = [np.delete(of, place + 1) for of in (time, value, std)]
    for of, new in zip(rest, (*mean, weight.sum() ** -0.5), strict=True):
        of[place] = new
    return rest[0], rest[1], rest[2]


def _scatter(square: float, taken: int, time: Reals, value: Reals, std: Reals) -> float:
    """What readings scatter by over what they state, squared: the mean of how far each lies off the line between its neighbours, clipped at three of it."""
    span = time[2] - time[0]
    part = (time[1] - time[0]) / span if span > 0.0 else 0.5
    line = np.array([-(1.0 - part), 1.0, -part])
    off = float(line @ value) / math.sqrt(float(line**2 @ std**2))
    seen = min(off**2, _CLIP**2 * square) / _CLIPPED
    return max(_LEAST, square + (seen - square) / (taken - 2 + _BEFORE))


def _robust(value: Reals, std: Reals, square: float, places: range) -> Reals:
    """Standard errors, larger where one of `places` lies far off those beside it."""
    scatter = math.sqrt(max(1.0, square))
    found = std.copy()
    for place in places:
        off = abs(value[place] - np.median(value[max(0, place - SIDE) : place + SIDE + 1])) / scatter
        if off > _OUTLIER * std[place]:
            found[place] = off
    return found
