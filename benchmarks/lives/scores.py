"""What a forecast of remaining life is worth: relative accuracy and its mean over a life, and whether the interval holds the truth.

Saxena, Celaya, Saha, Saha and Goebel 2010, "Metrics for offline evaluation of prognostic performance": relative accuracy at an instant is 1 - |r - told| / r, r being what is left in truth; the
cumulative one of a unit is the weighed mean over its instants. Here the weights are equal, the instants are shares of the time from the first reading to the limit, and what would be below 0 counts 0.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

HALF = 0.5  # of the life, from which on accuracy counts [judgement]


@dataclass(frozen=True)
class Said:
    """What was told of the time left, in days: median and 90 % interval, infinite where there is no end."""

    median: float
    low: float
    high: float


@dataclass(frozen=True)
class Asked:
    """One unit at one instant: its seed, its kind of wear, how much of its life had gone, the days left in truth, and what was told; None where no drift was found."""

    seed: int
    kind: str
    share: float
    left: float
    told: Said | None


def accuracy(left: float, median: float) -> float:
    """Relative accuracy, not below 0; 0 of a median without end."""
    return max(0.0, 1.0 - abs(median - left) / left) if math.isfinite(median) else 0.0


def within(left: float, told: Said) -> bool:
    """Whether the 90 % interval holds what is left."""
    return told.low <= left <= told.high


def held(asked: Sequence[Asked]) -> float:
    """Share of the intervals that hold what is left, where one was told."""
    return mean([within(one.left, one.told) for one in asked if one.told is not None])


def cumulative(asked: Sequence[Asked]) -> float:
    """Cumulative relative accuracy from half life on: the mean over each unit's instants, and of that over the units."""
    units: dict[int, list[float]] = defaultdict(list)
    for one in asked:
        if one.told is not None and one.share >= HALF:
            units[one.seed].append(accuracy(one.left, one.told.median))
    return mean([mean(found) for found in units.values()])


def unfloored(asked: Sequence[Asked]) -> tuple[float, float]:
    """Mean relative accuracy from half life on with what is below 0 as it is, of the forecasts with an end, and the share of these."""
    late = [one for one in asked if one.told is not None and one.share >= HALF]
    ends = [1.0 - abs(one.told.median - one.left) / one.left for one in late if one.told is not None and math.isfinite(one.told.median)]
    return mean(ends), len(ends) / max(1, len(late))


def mean(group: Sequence[float]) -> float:
    """Of none, not a number."""
    return float(np.mean(group)) if group else math.nan
