"""The bank of named wear laws, and what readings say of each: a Gaussian process with a linear mean (Rasmussen and Williams, section 2.7), whose levels and rates are integrated in closed form.

A law is a level, wear that begins at an onset and slows down, goes on evenly, accelerates, feeds on itself or stalls for a while, a part that fades (grease that runs in), and a random walk, which
is what steps and irregular wear look like. Times are shares of the time since the first reading, values shares of the limit. Equations: docs/DESIGN.md, "Trend and time to a limit"; firmware works
out the same law by law (include/ema/ema_trend.h), here all of them go from knot to knot together.
"""

from __future__ import annotations

import functools
import itertools
from dataclasses import dataclass

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.fit.kept import Knots

_PARTS = 8  # places of onsets, and of the edges of two stalls [precision]
_PARTS_ONCE = 16  # of the edges of one stall [precision]
_POWERS = (0.7, 1.0)  # of the time in which wear went on [judgement]
_GROWTHS = (0.7, 1.1, 1.5, 2.0, 2.5, 3.2, 4.5)  # e-foldings of wear in one age, where its rate rises with what has worn [judgement]
_POLES = (
    3.0,
    2.2,
    1.8,
    1.6,
    1.4,
    1.25,
    1.15,
    1.07,
)  # ages after which it would be without bound, where its rate rises with the square of what has worn [judgement]
_POLES_TWO = (6.0, 4.0, 3.0, 2.5, 2.1, 1.8, 1.6, 1.4, 1.25, 1.15)  # the same where it rises with its power of 3 / 2 [judgement]
_FADES = (0.0, 0.1)  # time in which grease runs in; 0 is none [judgement]
_WALKS = (0.0, 0.04, 0.2)  # what the walk comes to over the age [judgement]
_STALLING = 0.125  # share of the laws that stall once, and of those that do twice [judgement]
_EDGE = 0.24  # standard deviation of the level over an onset or an end of a stall, times the parts: what wears until one is there is a step [judgement]
_AT_ONCE = 512  # laws whose covariances are worked out together [effort]
_PRIOR = np.array([0.2, 0.4, 0.2])  # level, rate over one age and fading part: one standard deviation [judgement]
_FAR = 20.0  # e-foldings beyond which it does not matter how far beyond the limit [layout]
_POLE_LEAST = 0.001  # of an age: nearer to a pole it does not matter any more, either [layout]
_BEGUN = 0.001  # of an age, from which on the rate is told of wear that begins infinitely fast [layout]


@dataclass(frozen=True)
class Laws:
    """Every law, [laws]: parts at whose ends its edges stand, onset, stalls and going on again [laws, 2] (both 1 for none; again 1 for one that lasts), shape, fading time, walk, prior share.

    The shape is a power, e-foldings or a pole and its order (1 where the rate rises with the square, 2 with the power of 3 / 2), 0 for none of these.
    """

    parts: Reals
    onset: Reals
    stall: Reals
    again: Reals
    power: Reals
    growth: Reals
    pole: Reals
    order: Reals
    fade: Reals
    walk: Reals
    share: Reals

    def chosen(self, which: slice) -> Laws:
        """Some of them."""
        return Laws(**{name: one[which] for name, one in vars(self).items()})

    @property
    def still(self) -> np.ndarray:
        """Those that do not wear."""
        return np.asarray(self.power + self.growth + self.pole == 0.0)

    @property
    def stalled_for(self) -> Reals:
        """For how long each is stalled at the last reading; 0 for those that go on."""
        return np.asarray(np.max(np.where(self.again >= 1.0, 1.0 - self.stall, 0.0), axis=1))

    def own_time(self, at: Reals) -> Reals:
        """Time in which wear went on until `at` [times], [laws, times]."""
        lost = np.clip(at - self.stall[:, :, None], 0.0, (self.again - self.stall)[:, :, None])
        return np.asarray(np.maximum(at[None, :] - self.onset[:, None], 0.0) - lost.sum(axis=1))

    def passed(self, at: Reals) -> list[Reals]:
        """How much of onset, stalls and their ends has gone by at each of `at` [times], spread over the part about it, [laws, times] each; 0 of one at the ends of the age."""
        parts = self.parts[:, None]
        edges = (self.onset, *self.stall.T, *self.again.T)
        return [
            np.where((edge > 0.0) & (edge < 1.0), np.clip(parts * (at[None, :] - edge) + 0.5, 0.0, 1.0), 0.0)
            for edge in (one[:, None] for one in edges)
        ]

    def risen(self, own_time: Reals) -> Reals:
        """Wear of rate 1 by its own time [laws, times], 1 after 1."""
        found = np.zeros_like(own_time)
        by_power, by_growth, by_pole = self.power > 0.0, self.growth > 0.0, self.pole > 0.0
        found[by_power] = own_time[by_power] ** self.power[by_power, None]
        growth = self.growth[by_growth, None]
        found[by_growth] = np.expm1(np.minimum(growth * own_time[by_growth], _FAR)) / np.expm1(growth)
        pole, order, own = self.pole[by_pole, None], self.order[by_pole, None], own_time[by_pole]
        over = own / np.maximum(pole - own, _POLE_LEAST)
        found[by_pole] = ((1.0 + over) ** order - 1.0) / ((pole / (pole - 1.0)) ** order - 1.0)
        return found

    def rises(self, own_time: Reals) -> Reals:
        """How fast that rises, [laws], before any pole."""
        begun = np.maximum(own_time, _BEGUN)
        found = self.power * begun ** (self.power - 1.0)
        by_growth, by_pole = self.growth > 0.0, self.pole > 0.0
        growth, pole, order = self.growth[by_growth], self.pole[by_pole], self.order[by_pole]
        found[by_growth] = growth * np.exp(growth * begun[by_growth]) / np.expm1(growth)
        left = pole - begun[by_pole]
        found[by_pole] = order / left * (pole / left) ** order / ((pole / (pole - 1.0)) ** order - 1.0)
        return found

    def faded(self, at: Reals) -> Reals:
        """The part that fades, from 0 towards -1, [laws, times]."""
        fade = self.fade[:, None]
        return np.where(fade > 0.0, np.expm1(-at[None, :] / np.where(fade > 0.0, fade, 1.0)), 0.0)


@functools.cache
def all_laws() -> Laws:
    """Those that do not wear, those that do steadily, and those that stall once or twice; the last three share what wears."""
    shapes = [
        *((one, 0.0, 0.0, 0.0) for one in _POWERS),
        *((0.0, one, 0.0, 0.0) for one in _GROWTHS),
        *((0.0, 0.0, one, 1.0) for one in _POLES),
        *((0.0, 0.0, one, 2.0) for one in _POLES_TWO),
    ]
    never = (1.0, 1.0, 1.0, 1.0)
    still = [(_PARTS, 0.0, *never, 0.0, 0.0, 0.0, 0.0, fade, 0.0) for fade in _FADES]
    steady = [
        (_PARTS, count / _PARTS, *never, *shape, fade, walk)
        for count, shape, fade, walk in itertools.product(range(_PARTS), shapes, _FADES, _WALKS)
    ]
    once, twice = (
        [
            (parts, edges[0], *edges[1:], *never[len(edges) - 1 :], 1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
            for edges in itertools.combinations(np.arange(parts + 1) / parts, count)
        ]
        for parts, count in ((_PARTS_ONCE, 3), (_PARTS, 5))
    )
    kinds = ((still, 1.0), (steady, 1.0 - 2.0 * _STALLING), (once, _STALLING), (twice, _STALLING))
    share = np.concatenate([np.full(len(one), part / len(one)) for one, part in kinds])
    parts, onset, stall, again, second, again_second, power, growth, pole, order, fade, walk = np.array([*still, *steady, *once, *twice]).T
    stalls = np.stack([stall, second], axis=1), np.stack([again, again_second], axis=1)
    return Laws(parts, onset, *stalls, power, growth, pole, order, fade, walk, share)


@dataclass(frozen=True)
class Known:
    """What is known of each law: its logarithm of the evidence [laws], and of level, rate, fading part and walk at the last reading mean [laws, 4] and covariance [laws, 4, 4]."""

    evidence: Reals
    mean: Reals
    cov: Reals


def known(laws: Laws, at: Reals, knots: Knots, limit: float) -> Known:
    """Each law by the knots, at their times `at` as shares of the age; some at a time, which stay in the processor's cache."""
    count = laws.onset.size
    parts = [_known(laws.chosen(slice(first, first + _AT_ONCE)), at, knots, limit) for first in range(0, count, _AT_ONCE)]
    return Known(*(np.concatenate([getattr(one, name) for one in parts]) for name in ("evidence", "mean", "cov")))


def _known(laws: Laws, at: Reals, knots: Knots, limit: float) -> Known:
    """One knot after the other (Rasmussen and Williams, appendix B.2): what walks and edges add is independent from knot to knot, since each is a walk over a time of its own."""
    own = laws.own_time(at)
    count = own.shape[0]
    walked = laws.walk[:, None] ** 2 * own
    for passed in laws.passed(at):
        walked += (_EDGE / laws.parts[:, None]) ** 2 * passed
    added = np.diff(walked, axis=1, prepend=0.0)
    risen, faded = laws.risen(own), laws.faded(at)
    mean, cov = np.zeros((4, count)), np.zeros((4, 4, count))
    cov[range(3), range(3)] = _PRIOR[:, None] ** 2
    evidence = np.zeros(count)
    for place, (value, std) in enumerate(zip(knots.value / limit, knots.std / limit, strict=True)):
        cov[3, 3] += added[:, place]
        rise, fade = risen[:, place], faded[:, place]
        seen = cov[0] + rise * cov[1] + fade * cov[2] + cov[3]
        doubt = seen[0] + rise * seen[1] + fade * seen[2] + seen[3] + std**2
        off = value - (mean[0] + rise * mean[1] + fade * mean[2] + mean[3])
        gain = seen / doubt
        evidence -= 0.5 * (off**2 / doubt + np.log(doubt))
        mean += gain * off
        cov -= seen[:, None, :] * gain[None, :, :]
    return Known(evidence, mean.T, cov.transpose(2, 0, 1))
