"""Noise of a record's signals by channel and frequency, and the filter that makes it white with unit variance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import fft

from ema_tools.base.arrays import Complexes, Reals

_SMOOTH_LINES = 12  # half width of the smoothing of a noise spectrum: this many lines, so that its own scatter is a fifth ... [chance]
_SMOOTH_SHARE = 0.15  # ... or this share of the frequency: noise has no narrower lines than that [judgement]
# No signal is trusted beyond this share of its own size, whatever its noise: a drive's voltage follows from the other signals and would
# have none [judgement]
_LEAST_NOISE = 1e-3


@dataclass(frozen=True)
class Whitener:
    """Turns signals [channels, rows] into a vector in which noise has unit variance. `weights` [channels, lines_of(rows)]; the second half of a real
    spectrum is counted by them too."""

    weights: Reals

    @staticmethod
    def of(power: Reals, rows: int) -> Whitener:
        """From the noise power of every line, [channels, lines], in the square unit of the signals."""
        weights = 1.0 / np.sqrt(power)
        # a line stands for its mirror image too, except the first and, for an even count, the last
        last = weights.shape[1] - 1 if counted(rows) % 2 == 0 else weights.shape[1]
        weights[:, 1:last] *= np.sqrt(2.0)
        return Whitener(weights)

    def __call__(self, signals: Reals) -> Reals:
        """The vector [2 * channels * lines] of signals [channels, rows]."""
        return np.ascontiguousarray(spectrum(signals) * self.weights).view(np.float64).ravel()

    def lines(self, vector: Reals) -> Complexes:
        """The whitened lines [channels, lines] in a vector."""
        return vector.view(np.complex128).reshape(self.weights.shape)


def counted(rows: int) -> int:
    """Rows of a record that are turned into lines: the transform of 10 001 takes twice as long as that of 10 000, so the last ones are left out, at most 2.5 % of 500 rows and more."""
    return int(fft.prev_fast_len(rows))


def lines_of(rows: int) -> int:
    """Lines of the spectrum of a record."""
    return counted(rows) // 2 + 1


def frequencies(rows: int, period_s: float) -> Reals:
    """Of the lines, Hz, [lines]."""
    return np.asarray(fft.rfftfreq(counted(rows), period_s))


def spectrum(signals: Reals) -> Complexes:
    """Lines [channels, lines] with the energy of the signals [channels, rows]."""
    return np.asarray(fft.rfft(signals[..., : counted(signals.shape[-1])], axis=-1, norm="ortho"))


def least_noise(signals: Reals) -> Reals:
    """Smallest noise, rms, that each of the signals [channels, rows] is credited with, [channels]."""
    return np.asarray(_LEAST_NOISE * np.sqrt(np.mean(signals**2, axis=1)) + 1e-12)


def noise_between(left: Reals, least: Reals) -> Reals:
    """Power of one run's noise [channels, lines] in what is `left` of runs about their mean [runs, channels, rows]; `least`: rms, [channels]."""
    count = len(left)
    return smoothed(np.mean(np.abs(spectrum(left)) ** 2, axis=0) * count / (count - 1)) + least[:, None] ** 2


def smoothed(power: Reals) -> Reals:
    """Running mean over frequency, [channels, lines]."""
    lines = power.shape[1]
    total = np.concatenate([np.zeros((power.shape[0], 1)), np.cumsum(power, axis=1)], axis=1)
    index = np.arange(lines)
    half = np.maximum(_SMOOTH_LINES, (_SMOOTH_SHARE * index).astype(int))
    low, high = np.maximum(index - half, 0), np.minimum(index + half + 1, lines)
    return np.asarray((total[:, high] - total[:, low]) / (high - low))
