"""At how many periods per motor turn what a model leaves swings, where that need be no whole number: a pulley behind a belt, the teeth of a second stage.

The residual over the angle, averaged where the machine has been more than once, and the squares of its Fourier transform, summed over the records, none of which need say where it begins.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ema_tools.base.arrays import Reals

_CYCLES = 2.0  # of the longest way, that a swing repeats at least [judgement]
_CELLS = 4.0  # of angle per period of the highest swing [precision]
_CELLS_MAX = 1 << 17  # of one record: a hundred thousand turns are looked at more coarsely [effort]
_FINER = 8  # lines between two that the longest way tells apart [precision]
_SWINGS = 3  # the strongest, that are tried [effort]
_TREND = 2  # power of the angle up to which what varies slowly is taken out before [judgement]


def swings(residuals: Sequence[Reals], angles_rad: Sequence[Reals], highest: float) -> tuple[float, ...]:
    """The strongest, best first, in periods per turn and below `highest`, whole ones left out; `residuals` and `angles_rad` of the rows of each record that moves, [rows]."""
    longest = max((float(np.ptp(angle)) for angle in angles_rad if angle.size), default=0.0)
    if not longest > 0.0 or highest * longest < 2.0 * math.pi * _CYCLES:
        return ()
    width = max(2.0 * math.pi / (_CELLS * highest), longest / _CELLS_MAX)
    lines = _FINER * (1 << math.ceil(math.log2(longest / width + 1.0)))
    power = np.zeros(lines // 2 + 1)
    for residual, angle in zip(residuals, angles_rad, strict=True):
        if angle.size:
            power += np.abs(np.fft.rfft(_over_angle(residual, angle, width), lines)) ** 2
    orders = np.arange(power.size, dtype=np.float64) * (2.0 * math.pi / (lines * width))
    apart = 2.0 * math.pi / longest
    power[(orders < _CYCLES * apart) | (orders > highest)] = 0.0
    # here and below, since it takes half a second to load and few records come here
    from scipy import signal

    peaks, _ = signal.find_peaks(power, distance=_FINER)
    whole = np.abs(orders[peaks] - np.round(orders[peaks])) < apart
    peaks = peaks[~(whole & (np.round(orders[peaks]) > 0.0))]
    return tuple(_between(orders, power, int(place)) for place in peaks[np.argsort(-power[peaks])][:_SWINGS])


def _over_angle(residual: Reals, angle_rad: Reals, width: float) -> Reals:
    """Means of a residual over equal cells of the angle, without what varies slowly, fading to both ends; zero where the machine never was, [cells]."""
    cell = ((angle_rad - float(np.min(angle_rad))) / width).astype(np.int64)
    count = np.bincount(cell)
    there = count > 0
    means = np.bincount(cell, residual)[there] / count[there]
    place = np.flatnonzero(there) / count.size
    found = np.zeros(count.size)
    found[there] = means - np.polynomial.Polynomial.fit(place, means, min(_TREND, means.size - 1))(place)
    from scipy import signal

    return np.asarray(found * signal.windows.hann(count.size, sym=True))


def _between(orders: Reals, power: Reals, place: int) -> float:
    """Where between its neighbours a peak is highest, as of a parabola."""
    low, here, high = power[place - 1 : place + 2]
    bend = low - 2.0 * here + high
    return float(orders[place] + (0.5 * (low - high) / bend if bend < 0.0 else 0.0) * (orders[1] - orders[0]))
