"""What standard errors are where a model leaves more than noise: one yardstick for all fits of effects."""

from __future__ import annotations

import math

# What is left unexplained may hide behind a value: a share of it, in units of cost, as if it lay along the value's signature [judgement]
_BENT = 0.5
DIRECTIONS = 20.0  # along which the form of a model errs [judgement]
_NOTICED = 3.0  # standard deviations of the cost from which on it is misfit [chance]
_TRUSTED = 0.006  # share of a change to which the model and the machine's known values are trusted [judgement]


def misfit(cost: float, expected: float, numbers: int, counting: float = 0.0) -> float:
    """How much of a fit's `cost` is more than `numbers` of noise, of which `expected` is usual, may have by chance and `counting` by what sensors count."""
    return max(cost - expected - _NOTICED * math.sqrt(2.0 * numbers) - counting, 0.0)


def in_noise(excess: float) -> float:
    """Variance of the noise by which a fit is judged that leaves the cost `excess` above it: its discrepancy lies along so many directions, and each of them counts as noise does."""
    return 1.0 + max(excess, 0.0) / DIRECTIONS


def whole_std(by_noise: float, left: float, name: str, change: float, bent: float = _BENT) -> float:
    """The standard error of a value that differs by `change` from the machine's own: that of noise and scatter, larger by what the misfit `left` may have bent, of which the share `bent` lies along
    the value's signature, and no smaller than the share to which the model is trusted."""
    trusted = 0.0 if name.endswith("phase_rad") else _TRUSTED * abs(change)
    return math.hypot(by_noise * math.sqrt(1.0 + bent * left), trusted)
