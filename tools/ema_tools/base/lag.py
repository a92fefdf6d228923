"""What a drive's record is late by: the current or torque that it writes down has passed a filter of the first order, of which no data sheet tells.

Where friction turns over, a millisecond of it looks like friction of another kind.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ema_tools.base.arrays import Reals

_FORGOTTEN = 5.0  # time constants after which a filter has forgotten what it saw, to 1 % [precision]


def lagged(values: Reals, period_s: float, lag_s: float) -> Reals:
    """Values behind a filter of the first order with a time constant of `lag_s`, straight between the rows, from rest at the first, [rows] or [rows, k]; without one as they are."""
    if lag_s <= 0.0:
        return values
    # a tenth of a second to load, for records that lag alone
    from scipy.signal import lfilter

    share = period_s / lag_s
    fades = math.exp(-share)
    mean = -math.expm1(-share) / share
    first = values[:1]
    return np.asarray(first + lfilter([1.0 - mean, mean - fades], [1.0, -fades], values - first, axis=0))


def remembered(resting: NDArray[np.bool_], period_s: float, lag_s: float) -> NDArray[np.bool_]:
    """Rows at which a filter still shows what was at those of rest, [rows]."""
    after = math.ceil(_FORGOTTEN * abs(lag_s) / period_s) if lag_s else 0
    if not after or not resting.any():
        return resting
    since = np.arange(resting.size) - np.maximum.accumulate(np.where(resting, np.arange(resting.size), -resting.size - after))
    return np.asarray(since <= after)
