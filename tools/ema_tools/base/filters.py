"""Filters without phase, and correlation, by the transforms of scipy.fft: what the balances need of scipy.signal, which takes as long to load as a record takes to judge.

A signal is held to go on beyond both its ends point-symmetrically, as `scipy.signal.sosfiltfilt` holds it for a few rows; of such a signal without the straight line between its ends the discrete
sine transform holds the lines, so that a filter is a factor for each and has no transient of its own. A filter that is run forward and backward has the square of its gain: its closed form
(A. V. Oppenheim, R. W. Schafer, Discrete-Time Signal Processing, sections 7.2 and 7.3).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy import fft

from ema_tools.base.arrays import Reals


def butterworth(shares: Reals, order: int, cutoff: float) -> Reals:
    """What a Butterworth filter of `order`, forward and backward, leaves at frequencies given, as the cutoff, as shares of half the sample rate, [k]."""
    return np.asarray(1.0 / (1.0 + _warped(shares, cutoff) ** (2 * order)))


def chebyshev(shares: Reals, order: int, ripple_dB: float, cutoff: float) -> Reals:
    """The same of a Chebyshev filter of the first kind; `ripple_dB` of one way through it."""
    place = _warped(shares, cutoff)
    swing = 10.0 ** (0.1 * ripple_dB) - 1.0
    return np.asarray(1.0 / (1.0 + swing * np.polynomial.chebyshev.chebval(place, [0.0] * order + [1.0]) ** 2))


def shares_of(rows: int) -> Reals:
    """The frequencies of a record's lines as shares of half the sample rate, [rows - 1], that of the straight line first."""
    return np.arange(rows - 1) / (rows - 1)


def filtered(values: Reals, gains: Reals, axis: int = -1) -> Reals:
    """Values [rows] along `axis` with every line of `shares_of(rows)` times its gain [rows - 1]."""
    rows = np.moveaxis(np.asarray(values, dtype=np.float64), axis, -1)
    out = np.linspace(rows[..., 0], rows[..., -1], rows.shape[-1], axis=-1)
    lines = fft.dst(rows[..., 1:-1] - out[..., 1:-1], type=1, axis=-1)
    out *= gains[0]
    out[..., 1:-1] += fft.idst(lines * gains[1:], type=1, axis=-1)
    return np.asarray(np.moveaxis(out, -1, axis))


def correlated(one: Reals, two: Reals) -> Reals:
    """Sum over rows of `one` some rows later times `two`, both [rows], for lags of 1 - rows .. rows - 1, [2 rows - 1]."""
    rows = one.size
    length = int(fft.next_fast_len(2 * rows - 1, real=True))
    products = fft.irfft(fft.rfft(one, length) * np.conj(fft.rfft(two, length)), length)
    return np.concatenate([products[length - rows + 1 :], products[:rows]])


def _warped(shares: ArrayLike, cutoff: float) -> Reals:
    """Frequencies as the bilinear transform puts them, the cutoff at one."""
    return np.asarray(np.tan(0.5 * np.pi * np.asarray(shares)) / np.tan(0.5 * np.pi * cutoff))
