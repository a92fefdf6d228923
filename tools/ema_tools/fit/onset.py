"""Since when a value has changed: the step or the ramp from some day on that stands out most, in standard errors."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ema_tools.base.arrays import Reals

_SIDE = 2  # days on each side of a change [judgement]
_LIKELY = 3.84  # twice the logarithm of the likelihood ratio at the end of a 95 % interval [chance]
_OUTLIER = 2.5  # standard deviations off its neighbours beyond which a day counts less [judgement]
_MIDDLE = 1.4826  # standard deviation of normal numbers over the middle of their sizes [chance]


@dataclass(frozen=True)
class Onset:
    """First day of a change, and between which two days it begins with 95 %."""

    day: float
    ends95: tuple[float, float]


def onset(days: Reals, values: Reals, stds: Reals) -> Onset:
    """Of `values` [n] on `days` [n] with standard errors `stds` [n], four or more and not all of one day, of which it is known that they have changed."""
    std = _robust(values, np.hypot(stds, _beyond(values, stds)))
    places = np.arange(_SIDE, days.size - _SIDE + 1)
    steps = (np.arange(days.size)[:, None] >= places).astype(np.float64)
    ramps = np.maximum(days[:, None] - days[: days.size - _SIDE], 0.0)
    there = ramps[-1] > 0.0
    shapes = np.hstack([steps, ramps[:, there]])
    begins = np.concatenate([places, np.flatnonzero(there)])
    weight = 1.0 / std**2
    centred = shapes - np.average(shapes, axis=0, weights=weight)
    norm = np.sqrt(weight @ centred**2)
    score = (values * weight) @ centred / np.where(norm > 0.0, norm, math.inf)
    most = int(np.argmax(np.abs(score)))
    near = begins[score**2 >= score[most] ** 2 - _LIKELY]
    first, last = int(near.min()), int(near.max())
    return Onset(float(days[begins[most]]), (float(days[max(first - 1, 0)]), float(days[last])))


def _beyond(values: Reals, stds: Reals) -> float:
    """What neighbouring days differ by beyond their standard errors, one standard deviation; by the middle of the differences, so that a step or a trend adds little."""
    shown = _MIDDLE * float(np.median(np.abs(np.diff(values)))) / math.sqrt(2.0)
    return math.sqrt(max(0.0, shown**2 - float(np.median(stds)) ** 2))


def _robust(values: Reals, stds: Reals) -> Reals:
    """Standard errors, larger where a day lies far off those beside it."""
    beside = np.array([np.median(values[max(0, place - _SIDE) : place + _SIDE + 1]) for place in range(values.size)])
    off = np.abs(values - beside)
    return np.where(off > _OUTLIER * stds, np.maximum(stds, off), stds)
