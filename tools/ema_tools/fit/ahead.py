"""What comes of wear: when each law first reaches the limit, and what all of them say together when wear may stall, go on again or change its pace at any time.

Times are shares of the time since the first reading. Equations: docs/DESIGN.md, "Trend and time to a limit".
"""

from __future__ import annotations

import math

import numpy as np
from scipy import special

from ema_tools.base.arrays import Reals
from ema_tools.fit.laws import Known, Laws

MOST = 20.0  # ages ahead that are looked at; what comes later is open [layout]
_TIMES = 80  # in them [layout]
_FIRST = 2e-3  # of an age: the first of them behind zero [layout]
_CHANGES = 1.0  # changes of pace in one age [judgement]
_PARTS = 5  # of the times of a change, as likely; odd, so that no median falls between two [precision]
_STALLS = 0.25  # share of the changes of pace that stall it [judgement]
_TO_COME = 0.3  # ages that a stall to come is taken to have lasted, as far as its end is concerned [judgement]
_SPREAD = 0.75  # standard deviation of the logarithm of the others [judgement]
_PACES = (1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0)  # weights of Gauss and Hermite's three points, at minus and plus the root of 3 and 0 [precision]
_DOUBT = 1e-12  # least variance of what is foretold [layout]

AHEAD = np.concatenate([[0.0], np.geomspace(_FIRST, MOST, _TIMES - 1)])


def states(laws: Laws, own: Reals) -> Reals:
    """What level, rate, fading part and walk are multiplied by at each law's own time [laws], the grease as at the last reading: [laws, 4]."""
    ones = np.ones_like(own)
    return np.stack([ones, laws.risen(own[:, None])[:, 0], laws.faded(np.ones(1))[:, 0], ones], axis=1)


def reached(laws: Laws, found: Known, own: Reals) -> Reals:
    """Probability of each law that the limit has been reached at AHEAD of its own time, from `own` [laws] on: [laws, times].

    First passage of a Brownian motion whose drift is normal (Cox and Miller, section 5.7, with the drift integrated out).
    """
    risen = laws.risen(own[:, None] + AHEAD[None, :])
    # all but the rate is the same at any time ahead
    rest = states(laws, own)
    rest[:, 1] = 0.0
    fixed, rate = np.sum(rest * found.mean, axis=1)[:, None], found.mean[:, 1, None]
    with_rate = np.sum(rest * found.cov[:, 1, :], axis=1)[:, None]
    without = np.einsum("lk,lkm,lm->l", rest, found.cov, rest)[:, None]
    value = fixed + rate * risen
    doubt = np.maximum(without + risen * (2.0 * with_rate + risen * found.cov[:, 1, 1, None]), _DOUBT)
    left, advance = 1.0 - value[:, :1], value - value[:, :1]
    walked = laws.walk[:, None] ** 2 * AHEAD[None, :]
    spread = np.sqrt(doubt + walked)
    below = (left - advance) / spread
    gone = special.ndtr(-below)
    some = (laws.walk > 0.0) & (left[:, 0] > 0.0)
    gone[some, 1:] += _back(left[some], advance[some, 1:], doubt[some, 1:], walked[some, 1:], spread[some, 1:], below[some, 1:])
    return np.maximum.accumulate(np.minimum(gone, 1.0), axis=1)


def _back(left: Reals, advance: Reals, doubt: Reals, walked: Reals, spread: Reals, below: Reals) -> Reals:
    """What had been reached and has walked back below the limit, [laws, times]."""
    mirrored = (left + advance + 2.0 * left * doubt / walked) / spread
    # e^(x^2 / 2) of the one and the tail beyond the other, without leaving the numbers
    near = np.exp(-0.5 * below**2) * 0.5 * special.erfcx(np.maximum(mirrored, 0.0) / math.sqrt(2.0))
    past = np.exp(np.minimum(0.5 * (mirrored**2 - below**2), 0.0)) * special.ndtr(-mirrored)
    return np.where(mirrored > 0.0, near, past)


def paced(going: Reals, stalled: Reals, stalled_for: float) -> Reals:
    """Shares reached at AHEAD of the calendar, by those over wear's own time where it goes on now and where it is stalled since `stalled_for` ages, [times]."""
    middles = (np.arange(_PARTS) + 0.5) / _PARTS
    changes = -np.log1p(-middles) / _CHANGES
    ends = (
        1.0 / np.sqrt(1.0 - middles) - 1.0
    )  # of a stall, over what it has lasted: its rate of ending is unknown but for that (Pareto's law of exponent 2)
    paces = np.exp(_SPREAD * math.sqrt(3.0) * np.array([-1.0, 0.0, 1.0]))
    total = np.zeros_like(AHEAD)
    for change in changes:
        until = np.minimum(AHEAD, change)
        since = AHEAD - until
        for pace, share in zip(paces, _PACES, strict=True):
            total += (1.0 - _STALLS) * share * np.interp(until + pace * since, AHEAD, going)
        for end in ends:
            total += _STALLS / _PARTS * np.interp(until + np.maximum(since - _TO_COME * end, 0.0), AHEAD, going)
    for end in ends:
        total += np.interp(np.maximum(AHEAD - stalled_for * end, 0.0), AHEAD, stalled)
    return np.minimum(np.maximum.accumulate(total / _PARTS), 1.0)


def time_of(shares: Reals, share: float) -> float:
    """The time by which `share` has reached the limit; infinite where it does not in what is looked ahead."""
    if shares[-1] < share:
        return math.inf
    place = int(np.argmax(shares >= share))
    if place == 0:
        return 0.0
    return float(np.interp(share, shares[place - 1 : place + 1], AHEAD[place - 1 : place + 1]))
