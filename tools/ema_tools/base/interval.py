"""The interval that is stated of an estimate."""

from __future__ import annotations

import math

WIDTH_95 = 1.96  # standard deviations on either side that hold 95 % of a normal distribution [chance]


def interval95(estimate: float, *stds: float) -> tuple[float | None, float | None]:
    """The 95 % interval about an estimate with independent errors of these standard deviations; no ends where the record does not determine it."""
    half = WIDTH_95 * math.hypot(*stds)
    return (estimate - half, estimate + half) if math.isfinite(half) else (None, None)


def interval_of(estimate: float, std: float | None) -> tuple[float | None, float | None]:
    """The same of an estimate that may have no standard error."""
    return interval95(estimate, math.nan if std is None else std)
