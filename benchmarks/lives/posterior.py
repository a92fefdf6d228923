"""What the parts of the ideal observer share: the readings with their likelihood, and draws of the time left with their evidence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ema_tools.base.arrays import Reals

DEGREES = 4.0  # of freedom of the scatter [chance]


@dataclass(frozen=True)
class Looks:
    """Readings [n] of one unit in % on days, the scale of their scatter, and after how many of them it is asked, in rising order."""

    days: Reals
    values: Reals
    scale: Reals
    counts: Sequence[int]

    def log_likelihood(self, count: int, wear: Reals) -> Reals:
        """Of the first `count` readings by wear [draws, count], but for what all share."""
        off = (self.values[:count] - wear) / self.scale[:count]
        return np.asarray(-0.5 * (DEGREES + 1.0) * np.sum(np.log1p(off**2 / DEGREES), axis=1))


@dataclass(frozen=True)
class Posterior:
    """Draws of the time left in days [draws], and the logarithm of the evidence with the prior."""

    left: Reals
    log: float


def between(ends: tuple[float, float], cube: Reals) -> Reals:
    """Numbers of 0 .. 1 put between two ends."""
    return ends[0] + (ends[1] - ends[0]) * cube
