"""Filters without phase, and correlation, by the transforms of scipy.fft: what the balances need of scipy.signal, which takes as long to load as a record takes to judge.

A signal is held to go on beyond both its ends point-symmetrically, as `scipy.signal.sosfiltfilt` holds it for a few rows; of such a signal without the straight line between its ends the discrete
sine transform holds the lines, so that a filter is a factor for each and has no transient of its own. A filter that is run forward and backward has the square of its gain: its closed form
(A. V. Oppenheim, R. W. Schafer, Discrete-Time Signal Processing, sections 7.2 and 7.3).
"""

from __future__ import annotations

import math

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


def quick_length(rows: int, memory: float, every: int = 1) -> int:
    """Rows of which a transform is quick, `rows` or `memory` of a filter and more beyond them, one more than a multiple of `every`; `rows` itself where there is no multiple so near."""
    length = every * int(fft.next_fast_len(math.ceil((rows - 1 + memory) / every), real=True)) + 1
    return length if length <= 2 * rows - 2 else rows


def filtered(values: Reals, gains: Reals, axis: int = -1) -> Reals:
    """Values [rows] along `axis` with every line of `shares_of(rows)` times its gain [rows - 1]; with more gains, as if the values went on that far."""
    rows, straight, lines = _lines(values, gains, axis)
    out = straight[..., : rows.shape[-1]] * gains[0]
    inner = fft.idst(lines * gains[1:], type=1, axis=-1)[..., : rows.shape[-1] - 1]
    out[..., 1 : 1 + inner.shape[-1]] += inner
    return np.asarray(np.moveaxis(out, -1, axis))


def filtered_every(values: Reals, gains: Reals, every: int, axis: int = -1) -> Reals:
    """The first and every n-th after it of `filtered`, [k]; as many gains as a multiple of `every`.

    Sampled more slowly, lines that lie as far above a multiple of the new sample rate as others below it are one: they are added before the way back, which is then as much shorter.
    """
    rows, straight, lines = _lines(values, gains, axis)
    period = 2 * gains.size // every
    lines *= gains[1:]
    turns = np.zeros((*lines.shape[:-1], period * -(-gains.size // period)))
    turns[..., 1 : gains.size] = lines
    folded = turns.reshape(*lines.shape[:-1], -1, period).sum(axis=-2)
    alike = folded[..., 1 : period // 2] - folded[..., : period // 2 : -1]
    out = straight[..., : rows.shape[-1] : every] * gains[0]
    inner = fft.idst(alike, type=1, axis=-1)[..., : out.shape[-1] - 1] / every
    out[..., 1 : 1 + inner.shape[-1]] += inner
    return np.asarray(np.moveaxis(out, -1, axis))


def _lines(values: Reals, gains: Reals, axis: int) -> tuple[Reals, Reals, Reals]:
    """Values with `axis` last; the straight line between the ends, [..., gains + 1]; and the sine transform of what is beside it, [..., gains - 1]."""
    rows = np.moveaxis(np.asarray(values, dtype=np.float64), axis, -1)
    count, length = rows.shape[-1], gains.size + 1
    beyond = 2.0 * rows[..., -1:] - rows[..., count - 2 : 2 * count - 2 - length : -1] if length > count else rows[..., :0]
    last = beyond[..., -1] if length > count else rows[..., -1]
    straight = np.linspace(rows[..., 0], last, length, axis=-1)
    beside = np.concatenate([rows[..., 1:], beyond], axis=-1)[..., : length - 2] - straight[..., 1:-1]
    return rows, straight, fft.dst(beside, type=1, axis=-1, overwrite_x=True)


def correlated(one: Reals, two: Reals) -> Reals:
    """Sum over rows of `one` some rows later times `two`, both [rows], for lags of 1 - rows .. rows - 1, [2 rows - 1]."""
    rows = one.size
    length = int(fft.next_fast_len(2 * rows - 1, real=True))
    products = fft.irfft(fft.rfft(one, length) * np.conj(fft.rfft(two, length)), length)
    return np.concatenate([products[length - rows + 1 :], products[:rows]])


def _warped(shares: ArrayLike, cutoff: float) -> Reals:
    """Frequencies as the bilinear transform puts them, the cutoff at one."""
    return np.asarray(np.tan(0.5 * np.pi * np.asarray(shares)) / np.tan(0.5 * np.pi * cutoff))
