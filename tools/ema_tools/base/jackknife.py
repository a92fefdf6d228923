"""How far a value may be off, by what it is when one record after another is left out (the jackknife; B. Efron, The Jackknife, the Bootstrap and Other Resampling Plans, 1982)."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ema_tools.base.arrays import Reals

LEAST_RECORDS = 3  # of which one can be left out and the rest still tell how they differ [chance]


def jackknife_std(told: Sequence[ArrayLike]) -> Reals:
    """Standard error of what is told, a number or an array, when each record in turn is left out, in its shape; two or more are needed."""
    count = len(told)
    return np.asarray((count - 1) / math.sqrt(count) * np.std(np.asarray(told, dtype=np.float64), axis=0, ddof=1))
