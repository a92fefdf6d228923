"""What neighbouring rows share of a sensor's own noise, by healthy runs of one command: a filter before the converter, an amplifier's drift.

What a model lacks is shared by neighbouring rows as well, but it follows the motion: it is the same in every run, which the mean of the runs takes off, and it is there where the machine
turns round and not where it coasts. Noise is there all the time, so the middle of what the parts of the records show is taken. The errors of an autocovariance are Bartlett's for a noise of
first order (G. Box and G. Jenkins, Time Series Analysis, 1970, ch. 2).
"""

from __future__ import annotations

import math

import numpy as np

from ema_tools.base.arrays import Reals

_PARTS = 20  # of a record, of which the middle one counts [judgement]
_MIDDLE = math.pi / 2.0  # times the variance of a mean has a median of normal values [chance]
_SURE = 3.0  # standard errors that a shared noise must exceed, and that a record may show more of it than these runs did [chance]


def shared_noise(left: Reals) -> float:
    """Rms of what neighbouring rows share of the noise, no less than another record of it would show; zero where it is white. `left`: what is left of each run without what all have in
    common, [runs, rows], in the signal's unit, the result too."""
    rows = left.shape[1]
    part = rows // _PARTS
    if part < _PARTS:
        return 0.0
    parts = left[:, : part * _PARTS].reshape(-1, part)
    whole = float(np.median(np.mean(np.square(parts), axis=1)))
    shared = float(np.median(np.mean(parts[:, 1:] * parts[:, :-1], axis=1)))
    if not shared > _SURE * whole * math.sqrt(_MIDDLE / left.size):
        return 0.0
    square = min(shared / whole, 1.0 - 1.0 / rows) ** 2
    varies = (1.0 + _MIDDLE / len(left)) * ((1.0 + square) / (1.0 - square) + square + 2.0 * square / (1.0 - square)) / rows
    return math.sqrt(shared + _SURE * whole * math.sqrt(varies))
