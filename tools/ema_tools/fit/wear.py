"""A value of a unit over its days: whether it has changed, since when, how fast, and when it will reach a limit.

Whether it has changed, its trend and its remaining life are those of the filter that firmware has (include/ema/ema_trend.h): a bank of wear laws over what is kept of the readings, weighed by their
evidence. Since when is the step or the ramp that stands out most, which needs all days and is the desk's alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import special

from ema_tools.base.arrays import Reals
from ema_tools.fit.ahead import paced, reached, states, time_of
from ema_tools.fit.kept import kept
from ema_tools.fit.laws import all_laws, known
from ema_tools.fit.onset import onset

READINGS_LEAST = 6  # below which nothing is told [judgement]
_TEMPER = 0.7  # of the logarithm of the evidence: no law of the library is the machine's own, and days beside each other repeat what the law lacks [judgement]
_IDLE_LEAST = 1e-35  # weight of those that are stalled, below which it does not matter for how long [layout]
_ODDS = 80.0  # logarithm beyond which odds are not told apart [layout]


@dataclass(frozen=True)
class Drift:
    """Whether a value has changed: `chance` is the most that units without change show as much; `since` is its first day, `since95` between which two days it begins with 95 %."""

    changed: bool
    chance: float
    since: float
    since95: tuple[float, float]
    by: float  # at the last day, by what wears


@dataclass(frozen=True)
class Life:
    """Time from the last day until the limit is reached: median and 90 % interval, infinite where it is not reached in what is looked ahead; `now`: the value of the last day by all days."""

    median: float
    low: float
    high: float
    reached: float  # probability that it is reached at all in what is looked ahead
    now: float


@dataclass(frozen=True)
class Outlook:
    """All that is said of a value; rate in % a day, and its standard error, as that of `now`; `odds`: logarithm of how much likelier the days are with wear than without."""

    drift: Drift
    life: Life
    now_std: float
    rate: float
    rate_std: float
    odds: float


def outlook(days: Reals, values: Reals, stds: Reals, limit: float, false_alarm: float = 0.01) -> Outlook | None:
    """What is said of `values` [n] on `days` [n], in order, with standard errors `stds` [n], of which 0 is the healthy value; None where there are too few."""
    if days.size < READINGS_LEAST or not days[-1] > days[0]:
        return None
    knots = kept(days, values, stds)
    age = float(days[-1] - days[0])
    laws = all_laws()
    found = known(laws, knots.time / age, knots, limit)
    still = laws.still
    joint = found.evidence + np.log(laws.share)
    odds = float(np.clip(special.logsumexp(joint[~still]) - special.logsumexp(joint[still]), -_ODDS, _ODDS))
    weight = np.where(still, 0.0, laws.share * np.exp(_TEMPER * (found.evidence - found.evidence[~still].max())))
    weight /= weight.sum()
    own = laws.own_time(np.ones(1))[:, 0]
    now = states(laws, own)
    slope = np.zeros_like(now)
    slope[:, 1] = np.where(laws.stalled_for > 0.0, 0.0, laws.rises(own))
    told = [_mixed(weight, np.sum(row * found.mean, axis=1), np.einsum("lk,lkm,lm->l", row, found.cov, row)) for row in (now, slope)]
    shares = reached(laws, found, own)
    idle = weight * (laws.stalled_for > 0.0)
    stalled_for = float(idle @ laws.stalled_for) / max(float(idle.sum()), _IDLE_LEAST)
    ahead = paced((weight - idle) @ shares, idle @ shares, stalled_for)
    low, median, high = (age * time_of(ahead, share) for share in (0.05, 0.5, 0.95))
    by = limit * float(weight @ (now[:, 1] * found.mean[:, 1]))
    begins = onset(days, values, stds)
    drift = Drift(odds >= -math.log(false_alarm), math.exp(-max(odds, 0.0)), begins.day, begins.ends95, by)
    life = Life(median, low, high, float(ahead[-1]), limit * told[0][0])
    return Outlook(drift, life, abs(limit) * told[0][1], limit * told[1][0] / age, abs(limit) * told[1][1] / age, odds)


def _mixed(weight: Reals, mean: Reals, variance: Reals) -> tuple[float, float]:
    """Mean and standard deviation of a mixture."""
    middle = float(weight @ mean)
    return middle, math.sqrt(max(0.0, float(weight @ (variance + (mean - middle) ** 2))))
