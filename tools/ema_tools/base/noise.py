"""How noisy a signal is, from the signal alone."""

from __future__ import annotations

import math

import numpy as np

from ema_tools.base.arrays import Reals


def white_noise(values: Reals) -> float:
    """Standard deviation of white noise on a signal [rows], from its fourth differences, which smooth motion hardly has."""
    differences = np.diff(values, 4)
    return 1.4826 * float(np.median(np.abs(differences - np.median(differences)))) / math.sqrt(70.0)
