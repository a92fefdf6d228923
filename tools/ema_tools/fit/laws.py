"""The bank of named wear laws, and what readings say of each: a Gaussian process with a linear mean (Rasmussen and Williams, section 2.7), whose levels and rates are integrated in closed form.

A law is a level, wear that begins at an onset and slows down, goes on evenly, accelerates, feeds on itself or stalls for a while, a part that fades (grease that runs in), and a random walk, which
is what steps and irregular wear look like. Times are shares of the time since the first reading, values shares of the limit. Equations: docs/DESIGN.md, "Trend and time to a limit"; firmware works
out the same law by law and reading by reading (include/ema/ema_trend.h), here all at once.
"""

from __future__ import annotations

import functools
import itertools
from dataclasses import dataclass

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.fit.kept import Knots

_PARTS = 12  # places of onsets and stalls [precision]
_POWERS = (0.5, 1.0, 1.6, 2.5)  # of the time in which wear went on [judgement]
_GROWTHS = (2.0, 5.0)  # e-foldings of wear in one age, where it feeds on itself [judgement]
_FADES = (0.0, 0.1)  # time in which grease runs in; 0 is none [judgement]
_WALKS = (0.0, 0.01, 0.05, 0.2)  # what the walk comes to over the age [judgement]
_STALL_ONSETS = (0, 2, 4, 6)  # twelfths at which wear begins that stalls later [precision]
_STALL_WALKS = 3  # of the walks, the smallest, beside a stall [judgement]
_PRIOR = np.array([0.2, 0.4, 0.2])  # level, rate over one age and fading part: one standard deviation [judgement]
_FAR = 20.0  # e-foldings beyond which it does not matter how far beyond the limit [layout]
_BEGUN = 0.001  # of an age, from which on the rate is told of wear that begins infinitely fast [layout]


@dataclass(frozen=True)
class Laws:
    """Every law, [laws]: onset, stall and going on again (both 1 for none; again 1 for one that lasts), shape (a power, minus e-foldings, 0: no wear), fading time, walk, prior share."""

    onset: Reals
    stall: Reals
    again: Reals
    shape: Reals
    fade: Reals
    walk: Reals
    share: Reals

    @property
    def still(self) -> np.ndarray:
        """Those that do not wear."""
        return np.asarray(self.shape == 0.0)

    @property
    def stalls(self) -> np.ndarray:
        """Those that are stalled at the last reading."""
        return np.asarray((self.stall < 1.0) & (self.again >= 1.0))

    def own_time(self, at: Reals) -> Reals:
        """Time in which wear went on until `at` [times], [laws, times]."""
        gone = np.maximum(at[None, :] - self.onset[:, None], 0.0)
        return gone - np.clip(at[None, :] - self.stall[:, None], 0.0, (self.again - self.stall)[:, None])

    def risen(self, own_time: Reals) -> Reals:
        """Wear of rate 1 by its own time [laws, times], 1 after 1."""
        shape = self.shape[:, None]
        growth = np.where(shape < 0.0, -shape, 1.0)
        grown = np.expm1(np.minimum(growth * own_time, _FAR)) / np.expm1(growth)
        return np.where(shape < 0.0, grown, np.where(shape > 0.0, own_time ** np.where(shape > 0.0, shape, 1.0), 0.0))

    def rises(self, own_time: Reals) -> Reals:
        """How fast that rises, [laws]."""
        begun = np.maximum(own_time, _BEGUN)
        growth = np.where(self.shape < 0.0, -self.shape, 1.0)
        power = np.where(self.shape > 0.0, self.shape, 1.0)
        rising = np.where(self.shape < 0.0, growth * np.exp(growth * begun) / np.expm1(growth), power * begun ** (power - 1.0))
        return np.where(self.still, 0.0, rising)

    def faded(self, at: Reals) -> Reals:
        """The part that fades, from 0 towards -1, [laws, times]."""
        fade = self.fade[:, None]
        return np.where(fade > 0.0, np.expm1(-at[None, :] / np.where(fade > 0.0, fade, 1.0)), 0.0)


@functools.cache
def all_laws() -> Laws:
    """Those that do not wear, those that do steadily, and those that stall; the last two share one half each."""
    still = [(0.0, 1.0, 1.0, 0.0, fade, 0.0) for fade in _FADES]
    onsets = [count / _PARTS for count in range(_PARTS)]
    shapes = (*_POWERS, *(-one for one in _GROWTHS))
    steady = [(onset, 1.0, 1.0, shape, fade, walk) for onset, shape, fade, walk in itertools.product(onsets, shapes, _FADES, _WALKS)]
    stalling = [
        (onset / _PARTS, stall / _PARTS, again / _PARTS, 1.0, 0.0, walk)
        for onset in _STALL_ONSETS
        for stall, again in itertools.combinations(range(onset + 1, _PARTS + 1), 2)
        for walk in _WALKS[:_STALL_WALKS]
    ]
    share = np.concatenate([np.full(len(one), part / len(one)) for one, part in ((still, 1.0), (steady, 0.5), (stalling, 0.5))])
    onset, stall, again, shape, fade, walk = np.array([*still, *steady, *stalling]).T
    return Laws(onset, stall, again, shape, fade, walk, share)


@dataclass(frozen=True)
class Known:
    """What is known of each law: its logarithm of the evidence [laws], and of level, rate, fading part and walk at the last reading mean [laws, 4] and covariance [laws, 4, 4]."""

    evidence: Reals
    mean: Reals
    cov: Reals


def known(laws: Laws, at: Reals, knots: Knots, limit: float) -> Known:
    """Each law by the knots, at their times `at` as shares of the age."""
    own = laws.own_time(at)
    ones = np.ones_like(own)
    bases = np.stack([ones, laws.risen(own), laws.faded(at)], axis=2)  # [laws, knots, 3]
    scaled = bases * _PRIOR
    walks = laws.walk[:, None, None] ** 2 * np.minimum(own[:, :, None], own[:, None, :])
    lower = np.linalg.cholesky(scaled @ scaled.transpose(0, 2, 1) + walks + np.diag((knots.std / limit) ** 2))
    # what is asked for together with the knots: level, rate, fading part, and the walk of the last one
    cross = np.concatenate([bases.transpose(0, 2, 1) * (_PRIOR**2)[None, :, None], walks[:, -1:, :]], axis=1)
    prior = np.zeros((own.shape[0], 4, 4))
    prior[:, range(3), range(3)] = _PRIOR**2
    prior[:, 3, 3] = walks[:, -1, -1]
    told = np.concatenate([cross.transpose(0, 2, 1), (ones * knots.value / limit)[:, :, None]], axis=2)
    solved = np.linalg.solve(lower, told)
    gain, white = solved[:, :, :-1], solved[:, :, -1]  # [laws, knots, 4] and [laws, knots]
    evidence = -0.5 * np.sum(white**2, axis=1) - np.sum(np.log(np.diagonal(lower, axis1=1, axis2=2)), axis=1)
    return Known(evidence, np.einsum("lnk,ln->lk", gain, white), prior - np.einsum("lnk,lnm->lkm", gain, gain))
