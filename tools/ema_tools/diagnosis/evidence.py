"""What a record says beyond the machine's own repeatability: the residual, whitened, and the directions in which healthy runs scatter.

With healthy repeats of the same command the residual is the record minus their mean, so that a standing error of the model, which is in both, drops out. Noise is
estimated per channel and frequency from how the repeats differ, after the share that a scatter of the machine's own parameters explains (friction, grease,
winding) has been taken off. That share stays in the answer as directions with a known spread, not as free parameters, so that a change of the same parameter
beyond its usual scatter can still be named.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ema_tools.actuator import Actuator
from ema_tools.errors import InputError
from ema_tools.native import CHANNELS, library
from ema_tools.parallel import each
from ema_tools.records import Record, start_of

Reals = NDArray[np.float64]

# Usual scatter of a machine from run to run, relative; it counts as much as this many repeats that had shown it.
USUAL_SCATTER: Mapping[str, float] = {"screw.csj_Nm": 0.004, "screw.viscous_Nm_s_per_rad": 0.01, "motor.resistance_ohm": 0.003}
_USUAL_WEIGHT = 4.0
# Step of the scatter's signatures: large against rounding, small against nonlinearity.
_SCATTER_STEP = 0.02
# Half width of the smoothing of a noise spectrum: this many lines, or this share of the frequency.
_SMOOTH_LINES = 12
_SMOOTH_SHARE = 0.15
# No signal is trusted beyond this share of its own size, whatever its noise: a drive's voltage follows from the other signals and would have none.
_LEAST_NOISE = 1e-3


def simulate_channels(actuator: Actuator, record: Record, channels: Sequence[str]) -> Reals:
    """The model under the record's command, [channels, rows]. Raises InputError when the model refuses."""
    values, options = actuator.arrays()
    run = library(32).simulate(values, options, record.command_mm, start_of(actuator, record))
    return np.array([getattr(run, name) for name in channels])


def measured_channels(record: Record, channels: Sequence[str]) -> Reals:
    """The record's signals, [channels, rows]."""
    return np.array([record.channel(name) for name in channels])


@dataclass(frozen=True)
class Whitener:
    """Turns signals [channels, rows] into a vector of as many numbers in which noise has unit variance. `weights` [channels, rows // 2 + 1]."""

    weights: Reals

    def __call__(self, signals: Reals) -> Reals:
        lines = np.fft.rfft(signals, axis=1, norm="ortho") * self.weights
        # a line stands for its mirror image too, except the first and, for an even count, the last
        last = lines.shape[1] - 1 if signals.shape[1] % 2 == 0 else lines.shape[1]
        lines[:, 1:last] *= np.sqrt(2.0)
        return np.concatenate([lines.real.ravel(), lines.imag.ravel()])


@dataclass(frozen=True)
class Evidence:
    """A record against healthy repeats. Vectors are whitened and projected: squared lengths are costs with the scatter's spread allowed for.

    `residual` [n]: of the record; `repeats`: of each repeat against the others, what a record with nothing new looks like. `base` [channels, rows]:
    the model as it is.
    """

    actuator: Actuator
    record: Record
    channels: tuple[str, ...]
    base: Reals
    residual: Reals
    repeats: tuple[Reals, ...]
    _whiten: Whitener
    _basis: Reals

    def projected(self, signals: Reals) -> Reals:
        """Signals [channels, rows] as a vector [n]."""
        plain = self._whiten(signals)
        tall = np.concatenate([plain, np.zeros(self._basis.shape[1])])
        return tall - self._basis @ (self._basis.T @ tall)

    def signature(self, changes: Mapping[str, float]) -> Reals:
        """What `changes` make of the model, [n]. Raises InputError when the model refuses them."""
        return self.projected(simulate_channels(self.actuator.changed(changes), self.record, self.channels) - self.base)


def _smoothed(power: Reals) -> Reals:
    """Running mean over frequency, [channels, lines]."""
    lines = power.shape[1]
    total = np.concatenate([np.zeros((power.shape[0], 1)), np.cumsum(power, axis=1)], axis=1)
    index = np.arange(lines)
    half = np.maximum(_SMOOTH_LINES, (_SMOOTH_SHARE * index).astype(int))
    low, high = np.maximum(index - half, 0), np.minimum(index + half + 1, lines)
    return (total[:, high] - total[:, low]) / (high - low)


def common_channels(records: Sequence[Record]) -> tuple[str, ...]:
    """Signals that every record has."""
    return tuple(name for name in CHANNELS if all(record.channel(name) is not None for record in records))


def _check_repeats(record: Record, healthy: Sequence[Record]) -> None:
    if len(healthy) < 2:
        raise InputError(f"{record.file}: {len(healthy)} healthy record(s) tell nothing of repeatability: give two or more of the same command")
    for other in healthy:
        if other.rows != record.rows or not np.allclose(other.command_mm, record.command_mm, atol=1e-6):
            raise InputError(f"{other.file}: command_mm: not the command of {record.file}: give healthy records of the same command")


def gather(actuator: Actuator, record: Record, healthy: Sequence[Record], channels: Sequence[str] | None = None) -> Evidence:
    """Evidence of a record against two or more healthy repeats of its command, in the signals that all have or in `channels`.

    Raises InputError for repeats of another command or too few of them.
    """
    _check_repeats(record, healthy)
    names = tuple(channels) if channels else common_channels([record, *healthy])
    base = simulate_channels(actuator, record, names)
    runs = np.array([measured_channels(other, names) for other in healthy])
    mean = runs.mean(axis=0)
    count = len(healthy)
    deviations = runs - mean

    def moved(name: str) -> Reals:
        return (simulate_channels(actuator.changed({name: actuator[name] * (1.0 + _SCATTER_STEP)}), record, names) - base) / _SCATTER_STEP

    directions = np.array(each(moved, list(USUAL_SCATTER)))
    least = _LEAST_NOISE * np.sqrt(np.mean(mean**2, axis=1)) + 1e-12
    spread = np.maximum(np.sqrt(np.mean(deviations**2, axis=(0, 2))), least)
    flat = (directions / spread[:, None]).reshape(len(directions), -1)
    shares = np.linalg.lstsq(flat.T, (deviations / spread[:, None]).reshape(count, -1).T, rcond=None)[0]
    usual = np.array(list(USUAL_SCATTER.values()))
    scatter_std = np.sqrt((_USUAL_WEIGHT * usual**2 + np.sum(shares**2, axis=1)) / (_USUAL_WEIGHT + count - 1))
    left = deviations - np.einsum("kr,kcn->rcn", shares, directions)

    power = np.mean(np.abs(np.fft.rfft(left, axis=2, norm="ortho")) ** 2, axis=0) * count / (count - 1)
    widen = 1.0 + 1.0 / count
    whiten = Whitener(1.0 / np.sqrt(widen * (_smoothed(power) + least[:, None] ** 2)))
    scatter = np.column_stack([whiten(direction) * std * np.sqrt(widen) for direction, std in zip(directions, scatter_std, strict=True)])
    basis, _ = np.linalg.qr(np.vstack([scatter, np.eye(scatter.shape[1])]))
    evidence = Evidence(actuator, record, names, base, np.empty(0), (), whiten, basis)
    # a repeat against the mean of the others scatters a little more than the record against the mean of them all
    shrink = np.sqrt(widen / (1.0 + 1.0 / (count - 1)))
    repeats = tuple(evidence.projected((runs[k] - np.delete(runs, k, axis=0).mean(axis=0)) * shrink) for k in range(count))
    return Evidence(actuator, record, names, base, evidence.projected(measured_channels(record, names) - mean), repeats, whiten, basis)
