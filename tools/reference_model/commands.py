"""Position commands as functions of time, in mm.

Equations: docs/DESIGN.md, "Commands". The sine is the reference's own, so that samples have the same bits everywhere.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ema_tools.base.compiled import compiled
from reference_model.elementary import TWO_PI, sin


def times_s(count: int, step_s: float = 1e-3) -> np.ndarray:
    """Start times of `count` steps, s."""
    return np.arange(count) * step_s


@compiled
def _sine_of_turns(turns: float) -> float:
    return sin(TWO_PI * (turns - math.floor(turns)))


@compiled
def _fill_chirp(time_s: np.ndarray, amplitude_mm: float, start_hz: float, end_hz: float, duration_s: float, out: np.ndarray) -> None:
    for index in range(time_s.size):
        t = min(time_s[index], duration_s)
        turns = start_hz * t + (end_hz - start_hz) * t * t / (2.0 * duration_s)
        out[index] = amplitude_mm * _sine_of_turns(turns)


def chirp(
    time_s: np.ndarray, amplitude_mm: float = 2.0, start_hz: float = 0.1, end_hz: float = 4.0, duration_s: float = 10.0
) -> np.ndarray:
    """Linear sine sweep at `time_s` [n], held at its last value after `duration_s`; the defaults are the reference chirp."""
    out = np.empty(time_s.size)
    _fill_chirp(np.ascontiguousarray(time_s, dtype=float), amplitude_mm, start_hz, end_hz, duration_s, out)
    return out


@compiled
def _fill_multisine(time_s: np.ndarray, amplitude_mm: float, base_hz: float, count: int, out: np.ndarray) -> None:
    scale = amplitude_mm / math.sqrt(float(count))
    start = 0.0
    for line in range(1, count + 1):
        start += _sine_of_turns(-0.5 * line * (line - 1) / count)
    for index in range(time_s.size):
        total = 0.0
        for line in range(1, count + 1):
            total += _sine_of_turns(line * base_hz * time_s[index] - 0.5 * line * (line - 1) / count)
        out[index] = scale * (total - start)


def multisine(time_s: np.ndarray, amplitude_mm: float, base_hz: float, count: int) -> np.ndarray:
    """`count` harmonics of `base_hz` with Schroeder phases at `time_s` [n], moved to start at zero."""
    out = np.empty(time_s.size)
    _fill_multisine(np.ascontiguousarray(time_s, dtype=float), amplitude_mm, base_hz, count, out)
    return out


def trapezoid(time_s: np.ndarray, amplitude_mm: float, frequency_hz: float, share: float) -> np.ndarray:
    """Ramp to the peak in `share` of a quarter period, hold for the rest of it, back the same way, then mirrored; [n]."""
    turns = time_s * frequency_hz
    place = 4.0 * (turns - np.floor(turns))
    quarter = np.where(place < 1.0, place, np.where(place < 3.0, 2.0 - place, place - 4.0))
    return amplitude_mm * np.clip(quarter / share, -1.0, 1.0)


def triangle(time_s: np.ndarray, amplitude_mm: float, frequency_hz: float) -> np.ndarray:
    """Triangle with peak `amplitude_mm`, from zero and rising; [n]."""
    return trapezoid(time_s, amplitude_mm, frequency_hz, 1.0)


def step(time_s: np.ndarray, amplitude_mm: float, at_s: float) -> np.ndarray:
    """Zero before `at_s`, `amplitude_mm` from then on; [n]."""
    return np.where(time_s >= at_s, amplitude_mm, 0.0)


def record(samples_mm: Sequence[float] | np.ndarray, samples_every_steps: int, count: int) -> np.ndarray:
    """Recorded command [m] held over `samples_every_steps` steps each, its last sample from then on; [count]."""
    samples = np.asarray(samples_mm, dtype=float)
    index = np.minimum(np.arange(count) // samples_every_steps, samples.size - 1)
    return samples[index]
