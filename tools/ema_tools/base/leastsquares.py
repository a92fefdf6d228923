"""Linear least squares whose standard errors hold when neighbouring residuals are alike.

Covariance: W. K. Newey and K. D. West, Econometrica 55 (1987), with the bandwidth of D. W. K. Andrews, Econometrica 59 (1991), for
first-order autocorrelation. A residual that is missing model rather than noise is strongly correlated; taken as white it would make
errors look several times smaller than they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError


@dataclass(frozen=True)
class LinearFit:
    """Parameters [p], their covariance [p, p], and the residual of every stretch of samples."""

    parameters: Reals
    covariance: Reals
    residuals: tuple[Reals, ...]

    @property
    def std(self) -> Reals:
        """Standard errors, [p]."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))


def long_run(scores: Reals) -> Reals:
    """Sum of the scores' covariance over all lags, times their number, [p, p]; `scores` is [samples, p] of one unbroken stretch."""
    samples = scores.shape[0]
    total = scores.T @ scores
    lag = _bandwidth(scores)
    for step in range(1, lag + 1):
        product = scores[step:].T @ scores[:-step]
        total += (1.0 - step / (lag + 1.0)) * (product + product.T)
    return np.asarray(total * (samples / max(1, samples - scores.shape[1])))


def _bandwidth(scores: Reals) -> int:
    """Andrews' lag for Bartlett's kernel, from the first-order autocorrelation of every score."""
    upper = lower = 0.0
    for column in scores.T:
        power = float(column[:-1] @ column[:-1])
        if power <= 0.0:
            continue
        ratio = float(np.clip(column[1:] @ column[:-1] / power, -0.97, 0.97))
        variance = float(np.mean((column[1:] - ratio * column[:-1]) ** 2))
        upper += 4.0 * ratio**2 * variance**2 / ((1.0 - ratio) ** 6 * (1.0 + ratio) ** 2)
        lower += variance**2 / (1.0 - ratio) ** 4
    alpha = upper / lower if lower > 0.0 else 0.0
    return int(min(scores.shape[0] // 4, np.ceil(1.1447 * (alpha * scores.shape[0]) ** (1.0 / 3.0))))


def fit(targets: Sequence[Reals], columns: Sequence[Reals], names: Sequence[str]) -> LinearFit:
    """Least squares of targets [samples] on columns [samples, p], one entry per unbroken stretch.

    Raises InputError that names a parameter which the data do not determine.
    """
    matrix = np.vstack(columns)
    scale = np.linalg.norm(matrix, axis=0)
    for name, size in zip(names, scale, strict=True):
        if not size > 0.0:
            raise InputError(f"calibrate: {name}: no record moves what it acts on: give a record that does")
    scaled = matrix / scale
    _, sizes, rows = np.linalg.svd(scaled, full_matrices=False)
    if sizes[-1] < 1e-8 * sizes[0]:
        worst = names[int(np.argmax(np.abs(rows[-1])))]
        raise InputError(f"calibrate: {worst}: the records do not determine it: give one with other speeds or accelerations")
    solved, *_ = np.linalg.lstsq(scaled, np.concatenate(targets), rcond=None)
    parameters = solved / scale
    residuals = tuple(target - column @ parameters for target, column in zip(targets, columns, strict=True))
    inverse = np.linalg.inv(scaled.T @ scaled)
    scores = sum(long_run(column / scale * residual[:, None]) for column, residual in zip(columns, residuals, strict=True))
    return LinearFit(parameters, inverse @ scores @ inverse / np.outer(scale, scale), residuals)
