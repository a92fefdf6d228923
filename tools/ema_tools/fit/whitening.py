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
_WINDOWS = 10  # of a record end to end, which overlap by half: their number tells one signal's noise from four signals [effort]
_RESOLVED = 3  # turns in a window [chance]
_HANN_WIDTH = 1.5  # lines of a Hann window that count as one [physics]
_RIDGE = 1e-9  # of a signal's power: two signals that are the same have no noise, and the matrix stays invertible [precision]


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

    def signals(self, vector: Reals, rows: int) -> Reals:
        """The signals [channels, counted(rows)] of which a vector is what the call makes."""
        return np.asarray(fft.irfft(self.lines(np.ascontiguousarray(vector)) / self.weights, n=counted(rows), axis=-1, norm="ortho"))

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


def incoherent_power(residual: Reals) -> Reals:
    """Noise power [channels, lines_of(rows)] of each signal: of its residual [channels, rows] what goes along with no other signal's.

    That is one over the diagonal of the inverse cross-spectral matrix (D. R. Brillinger, Time Series: Data Analysis and Theory, 1981, ch. 8), averaged over half-overlapping Hann windows and
    neighbouring lines. What a model lacks moves all signals of a control loop together, and the noise of a sensor moves one. The noise of the others adds to it where it hides what they have in
    common.
    """
    channels, rows = residual.shape
    length = rows // _WINDOWS
    window = np.hanning(length)
    parts = np.lib.stride_tricks.sliding_window_view(residual, length, axis=1)[:, :: length // 2]
    lines = fft.rfft(parts * window, axis=-1) / np.linalg.norm(window)
    level = np.sqrt(np.mean(np.abs(lines) ** 2, axis=(1, 2), keepdims=True)) + np.finfo(np.float64).tiny
    lines = lines / level
    found = np.empty((channels, lines.shape[2]))
    for place in range(lines.shape[2]):
        half = max(1, int(_SMOOTH_SHARE * place))
        band = lines[:, :, max(place - half, 1) : place + half + 1].reshape(channels, -1)
        matrix = band @ band.conj().T / band.shape[1] + _RIDGE * np.eye(channels)
        # neighbouring lines of a Hann window are not independent
        freedom = band.shape[1] / _HANN_WIDTH
        found[:, place] = freedom / (freedom - channels + 1) / np.real(np.diag(np.linalg.inv(matrix)))
    # slower than a few turns in a window, drift cannot be told from noise
    found[:, :_RESOLVED] = found[:, _RESOLVED, None]
    at = np.arange(lines_of(rows)) * length / counted(rows)
    return np.array([np.exp(np.interp(at, np.arange(one.size), np.log(one))) for one in found * level[:, :, 0] ** 2])


def smoothed(power: Reals) -> Reals:
    """Running mean over frequency, [channels, lines]."""
    lines = power.shape[1]
    total = np.concatenate([np.zeros((power.shape[0], 1)), np.cumsum(power, axis=1)], axis=1)
    index = np.arange(lines)
    half = np.maximum(_SMOOTH_LINES, (_SMOOTH_SHARE * index).astype(int))
    low, high = np.maximum(index - half, 0), np.minimum(index + half + 1, lines)
    return np.asarray((total[:, high] - total[:, low]) / (high - low))
