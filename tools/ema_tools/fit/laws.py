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
_POWERS = (0.7, 1.0, 1.6)  # of the time in which wear went on [judgement]
_GROWTHS = (2.0, 5.0)  # e-foldings of wear in one age, where its rate rises with what has worn [judgement]
_POLES = (2.4, 1.5, 1.25)  # ages after which it would be without bound, where its rate rises with the square of what has worn [judgement]
_FADES = (0.0, 0.1)  # time in which grease runs in; 0 is none [judgement]
_WALKS = (0.0, 0.04, 0.2)  # what the walk comes to over the age [judgement]
_STALL_WALK = 0.04  # the same beside a stall [judgement]
_STALLING = 0.25  # share of the laws that stall [judgement]
_EDGE = 0.02  # standard deviation of the level over an onset or an end of a stall: they stand at twelfths, and what wears until one is there is a step [judgement]
_PRIOR = np.array([0.2, 0.4, 0.2])  # level, rate over one age and fading part: one standard deviation [judgement]
_FAR = 20.0  # e-foldings beyond which it does not matter how far beyond the limit [layout]
_POLE_LEAST = 0.001  # of an age: nearer to a pole it does not matter any more, either [layout]
_BEGUN = 0.001  # of an age, from which on the rate is told of wear that begins infinitely fast [layout]


@dataclass(frozen=True)
class Laws:
    """Every law, [laws]: onset, stall and going on again (both 1 for none; again 1 for one that lasts), shape (power, e-foldings or pole, 0 for none of these), fading time, walk, prior share."""

    onset: Reals
    stall: Reals
    again: Reals
    power: Reals
    growth: Reals
    pole: Reals
    fade: Reals
    walk: Reals
    share: Reals

    @property
    def still(self) -> np.ndarray:
        """Those that do not wear."""
        return np.asarray(self.power + self.growth + self.pole == 0.0)

    @property
    def stalls(self) -> np.ndarray:
        """Those that are stalled at the last reading."""
        return np.asarray((self.stall < 1.0) & (self.again >= 1.0))

    def own_time(self, at: Reals) -> Reals:
        """Time in which wear went on until `at` [times], [laws, times]."""
        gone = np.maximum(at[None, :] - self.onset[:, None], 0.0)
        return gone - np.clip(at[None, :] - self.stall[:, None], 0.0, (self.again - self.stall)[:, None])

    def passed(self, at: Reals) -> list[Reals]:
        """How much of onset, stall and its end has gone by at each of `at` [times], spread over the twelfth about it, [laws, times] each; 0 of one at the ends of the age."""
        return [
            np.where((edge > 0.0) & (edge < 1.0), np.clip(_PARTS * (at[None, :] - edge) + 0.5, 0.0, 1.0), 0.0)
            for edge in (one[:, None] for one in (self.onset, self.stall, self.again))
        ]

    def risen(self, own_time: Reals) -> Reals:
        """Wear of rate 1 by its own time [laws, times], 1 after 1."""
        found = np.zeros_like(own_time)
        by_power, by_growth, by_pole = self.power > 0.0, self.growth > 0.0, self.pole > 0.0
        found[by_power] = own_time[by_power] ** self.power[by_power, None]
        growth = self.growth[by_growth, None]
        found[by_growth] = np.expm1(np.minimum(growth * own_time[by_growth], _FAR)) / np.expm1(growth)
        pole, own = self.pole[by_pole, None], own_time[by_pole]
        found[by_pole] = (pole - 1.0) * own / np.maximum(pole - own, _POLE_LEAST)
        return found

    def rises(self, own_time: Reals) -> Reals:
        """How fast that rises, [laws], before any pole."""
        begun = np.maximum(own_time, _BEGUN)
        found = self.power * begun ** (self.power - 1.0)
        by_growth, by_pole = self.growth > 0.0, self.pole > 0.0
        growth, pole = self.growth[by_growth], self.pole[by_pole]
        found[by_growth] = growth * np.exp(growth * begun[by_growth]) / np.expm1(growth)
        found[by_pole] = pole * (pole - 1.0) / (pole - begun[by_pole]) ** 2
        return found

    def faded(self, at: Reals) -> Reals:
        """The part that fades, from 0 towards -1, [laws, times]."""
        fade = self.fade[:, None]
        return np.where(fade > 0.0, np.expm1(-at[None, :] / np.where(fade > 0.0, fade, 1.0)), 0.0)


@functools.cache
def all_laws() -> Laws:
    """Those that do not wear, those that do steadily, and those that stall; the last two share what wears."""
    still = [(0.0, 1.0, 1.0, 0.0, 0.0, 0.0, fade, 0.0) for fade in _FADES]
    onsets = [count / _PARTS for count in range(_PARTS)]
    shapes = [*((one, 0.0, 0.0) for one in _POWERS), *((0.0, one, 0.0) for one in _GROWTHS), *((0.0, 0.0, one) for one in _POLES)]
    steady = [(onset, 1.0, 1.0, *shape, fade, walk) for onset, shape, fade, walk in itertools.product(onsets, shapes, _FADES, _WALKS)]
    stalling = [
        (onset / _PARTS, stall / _PARTS, again / _PARTS, 1.0, 0.0, 0.0, 0.0, _STALL_WALK)
        for onset, stall, again in itertools.combinations(range(_PARTS + 1), 3)
    ]
    kinds = ((still, 1.0), (steady, 1.0 - _STALLING), (stalling, _STALLING))
    share = np.concatenate([np.full(len(one), part / len(one)) for one, part in kinds])
    onset, stall, again, power, growth, pole, fade, walk = np.array([*still, *steady, *stalling]).T
    return Laws(onset, stall, again, power, growth, pole, fade, walk, share)


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
    for passed in laws.passed(at):
        walks += _EDGE**2 * np.minimum(passed[:, :, None], passed[:, None, :])
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
