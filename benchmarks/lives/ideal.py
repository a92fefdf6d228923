"""What an observer who knows how the histories of the goals are drawn can foretell of them: Bayes' rule over the very priors of `benchmarks.lives.histories`, by drawing.

No filter that is not told of these priors can do better on the average, so that what this one lacks in accuracy is not to be had from the readings, but for the noise of its drawing. It knows the
scatter, that a unit wears, and that one which is asked for is still in service; the four kinds and the grease are weighed by their evidence.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import special

from benchmarks.lives.few_numbers import FewNumbers
from benchmarks.lives.histories import GOALS, GREASED, UNDERSTATED, Draw
from benchmarks.lives.jumping import followed
from benchmarks.lives.posterior import Looks, Posterior
from benchmarks.lives.scores import Said
from benchmarks.lives.tempering import drawn
from ema_tools.base.arrays import Reals

_KIND = 0.25  # of the histories are of each kind [chance]
_FAMILIES = (("even", 0, 1.0), ("feeding", 0, 1.0), ("stalling", 1, 0.5), ("stalling", 2, 0.5))  # kind, stalls, share of the kind [chance]
_POINTS = 200  # among which the most accurate one is sought [precision]


@dataclass(frozen=True)
class IdealSaid:
    """What is told of the time left, and the point in days of the greatest relative accuracy to be expected."""

    said: Said
    sharpest: float


def ideal(
    days: Reals, values: Reals, stds: Reals, counts: Sequence[int], random: np.random.Generator, draw: Draw = GOALS
) -> list[IdealSaid]:
    """What is told after each of `counts` readings, in rising order, of `values` [n] in % on `days` [n] with the stated standard errors `stds` [n]; the stalls are those of the goals."""
    looks = Looks(days, values, UNDERSTATED * stds / math.sqrt(2.0), counts)
    kinds = [followed(looks, draw.jumps, math.log(_KIND), random)]
    for kind, stalls, part in _FAMILIES:
        for greased in (False, True):
            prior = _KIND * part * (GREASED if greased else 1.0 - GREASED)
            kinds.append(drawn(looks, FewNumbers(kind, stalls, greased), math.log(prior), random))
    return [_mixed([one[place] for one in kinds]) for place in range(len(counts))]


def _mixed(kinds: Sequence[Posterior]) -> IdealSaid:
    logs = np.array([one.log for one in kinds])
    share = np.exp(logs - special.logsumexp(logs))
    left = np.concatenate([one.left for one in kinds])
    weight = np.concatenate([np.full(one.left.size, part / one.left.size) for one, part in zip(kinds, share, strict=True)])
    order = np.argsort(left)
    left, summed = left[order], np.cumsum(weight[order])
    low, median, high = (float(left[min(int(np.searchsorted(summed, part)), left.size - 1)]) for part in (0.05, 0.5, 0.95))
    points = np.unique(np.interp(np.linspace(0.005, 0.995, _POINTS), summed, left))
    expected = np.maximum(0.0, 1.0 - np.abs(points[:, None] - left[None, :]) / left[None, :]) @ weight[order]
    return IdealSaid(Said(median, low, high), float(points[int(np.argmax(expected))]))
