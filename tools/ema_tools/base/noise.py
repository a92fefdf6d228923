"""How noisy a signal is, and in which steps it was recorded, from the signal alone."""

from __future__ import annotations

import math

import numpy as np

from ema_tools.base.arrays import Reals

_WHOLE = 1e-3  # of a step: differences of a quantised signal are whole steps to within this, which the digits of a file leave [precision]
_HELD = 0.01  # of the rows, at least, show a neighbour's value again, or the signal is no counter's [judgement]


def white_noise(values: Reals) -> float:
    """Standard deviation of white noise on a signal [rows], from its fourth differences, which smooth motion hardly has."""
    differences = np.diff(values, 4)
    return 1.4826 * float(np.median(np.abs(differences - np.median(differences)))) / math.sqrt(70.0)


def resolution(values: Reals) -> float:
    """The step in which a signal [rows] was recorded; 0 where it shows none."""
    steps = np.abs(np.diff(values))
    moved = steps[steps > 0.0]
    if moved.size == 0 or steps.size - moved.size < _HELD * steps.size:
        return 0.0
    least = float(moved.min())
    counts = moved / least
    return least if bool(np.all(np.abs(counts - np.round(counts)) < _WHOLE * np.maximum(counts, 1.0))) else 0.0
