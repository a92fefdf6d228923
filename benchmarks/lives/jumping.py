"""Wear in jumps by the readings: a particle filter whose numbers are drawn anew from what its path has seen of them.

Storvik 2002, "Particle filters for state-space models in the presence of unknown static parameters".
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import special

from benchmarks.lives.histories import FADES, GREASED, GREASES, LENGTHS, LIMIT, ONSETS
from benchmarks.lives.posterior import DEGREES, Looks, Posterior, between
from ema_tools.base.arrays import Reals

_PARTICLES = 4000  # that follow jumps [effort]
_LENGTH_GRID = 12  # lengths among which a particle draws anew [precision]
_FUTURES = 1500  # of the particles whose future is drawn [effort]
_JUMP_GRID = 20  # ranges of their number among which it does [precision]
_FUTURE_JUMPS = 240  # at most ahead [effort]
_PROPOSED = np.array([0.5, 0.35, 0.1, 0.05])  # chances of 0 .. 3 jumps between two readings, as one half of the particles tries [effort]
_AIM = 2.0  # scales of the scatter about what is read, by which half of the jumps are tried [effort]
_JITTER = 0.02  # % by which copies of a particle part [effort]
_LEFT = 0.5  # share of the particles that still count, below which they are drawn anew [effort]


@dataclass
class JumpPaths:
    """Particles [particles]: where they stand, what they have seen of their own numbers, and these."""

    level: Reals
    seen: Reals
    exposed: Reals
    onset: Reals
    jumps: Reals
    length: Reals
    grease: Reals
    fade: Reals

    def chosen(self, which: np.ndarray) -> JumpPaths:
        return JumpPaths(**{name: one[which] for name, one in vars(self).items()})

    def value(self, day: float) -> Reals:
        return self.level + self.grease * np.expm1(-day / self.fade)


def followed(looks: Looks, to_limit: tuple[int, int], log_prior: float, random: np.random.Generator) -> list[Posterior]:
    """The posterior at each look of jumps of which so many go to the limit."""
    count = _PARTICLES
    greased = random.random(count) < GREASED
    paths = JumpPaths(
        np.zeros(count),
        np.zeros(count),
        np.zeros(count),
        random.uniform(*ONSETS, count),
        np.floor(np.exp(random.uniform(math.log(to_limit[0]), math.log(to_limit[1]), count))),
        random.uniform(*LENGTHS, count),
        np.where(greased, random.uniform(*GREASES, count), 0.0),
        random.uniform(*FADES, count),
    )
    log, before = log_prior, 0.0
    weight = np.zeros(count)
    found = []
    for place, (day, value, scale) in enumerate(zip(looks.days[: looks.counts[-1]], looks.values, looks.scale, strict=False), 1):
        weight += _jumped(paths, before, float(day), float(value), float(scale), random)
        off = (value - paths.value(float(day))) / scale
        weight -= 0.5 * (DEGREES + 1.0) * np.log1p(off**2 / DEGREES)
        weight[paths.value(float(day)) >= LIMIT] = -math.inf
        before = float(day)
        share = np.exp(weight - weight.max())
        if share.sum() ** 2 < _LEFT * count * (share**2).sum() or place in looks.counts:
            log += float(weight.max()) + math.log(share.mean())
            which = np.searchsorted(np.cumsum(share) / share.sum(), (np.arange(count) + random.random()) / count)
            paths = paths.chosen(np.minimum(which, count - 1))
            weight = np.zeros(count)
            _renewed(paths, to_limit, random)
        if place in looks.counts:
            found.append(Posterior(_future(paths, before, random), log))
    return found


def _jumped(paths: JumpPaths, before: float, day: float, value: float, scale: float, random: np.random.Generator) -> Reals:
    """Moves the particles to `day`: half of them jump as they would by themselves, half of the jumps are to about what is read.

    Returns the logarithm of how much likelier it was than drawn so, [particles].
    """
    count = paths.level.size
    open_days = np.maximum(day - np.maximum(before, paths.onset), 0.0)
    mean = paths.jumps / paths.length * open_days
    jumps = np.where(random.random(count) < 0.5, random.choice(_PROPOSED.size, count, p=_PROPOSED), random.poisson(mean))
    jumps = np.where(open_days > 0.0, jumps, 0)
    chance = -mean + np.where(jumps > 0, jumps * np.log(np.maximum(mean, 1e-300)), 0.0) - special.gammaln(jumps + 1.0)
    tried = np.where(jumps < _PROPOSED.size, _PROPOSED[np.minimum(jumps, _PROPOSED.size - 1)], 0.0)
    log = np.where(open_days > 0.0, chance - np.log(0.5 * tried + 0.5 * np.exp(chance)), 0.0)
    shape, width = 2.0 * np.maximum(jumps, 1), 0.5 * LIMIT / paths.jumps
    aimed = random.random(count) < 0.5
    aim = value - paths.value(day)
    spread = _AIM * scale
    size = np.where(aimed, aim + spread * random.normal(size=count), random.gamma(shape, width))
    real = size > 0.0
    safe = np.where(real, size, 1.0)
    true = (shape - 1.0) * np.log(safe) - safe / width - special.gammaln(shape) - shape * np.log(width)
    beside = -0.5 * ((safe - aim) / spread) ** 2 - math.log(spread * math.sqrt(2.0 * math.pi))
    log += np.where(jumps > 0, np.where(real, true - np.logaddexp(true, beside) + math.log(2.0), -math.inf), 0.0)
    paths.level = paths.level + np.where((jumps > 0) & real, size, 0.0)
    paths.seen = paths.seen + jumps
    paths.exposed = paths.exposed + open_days
    return log


def _renewed(paths: JumpPaths, to_limit: tuple[int, int], random: np.random.Generator) -> None:
    """Number and length of each particle drawn anew from what it has seen of them; the level jitters so that copies part."""
    ends = np.unique(np.floor(np.geomspace(*to_limit, _JUMP_GRID + 1)))
    jumps = (0.5 * (ends[1:] + ends[:-1] - 1.0))[:, None]  # the middle of the whole numbers of a range
    length = between(LENGTHS, (np.arange(_LENGTH_GRID)[None, :] + 0.5) / _LENGTH_GRID)
    rate, width = (jumps / length).ravel(), np.broadcast_to(0.5 * LIMIT / jumps, (jumps.size, _LENGTH_GRID)).ravel()
    log = (
        paths.seen[:, None] * (np.log(rate) - 2.0 * np.log(width))[None, :]
        - paths.exposed[:, None] * rate[None, :]
        - paths.level[:, None] / width[None, :]
        + np.repeat(np.log(np.log(ends[1:] / ends[:-1])), _LENGTH_GRID)[None, :]
    )
    drawn = np.argmax(log + random.gumbel(size=log.shape), axis=1)
    paths.jumps = np.broadcast_to(jumps, (jumps.size, _LENGTH_GRID)).ravel()[drawn]
    half = 0.5 * (LENGTHS[1] - LENGTHS[0]) / _LENGTH_GRID
    paths.length = np.broadcast_to(length, (jumps.size, _LENGTH_GRID)).ravel()[drawn] + half * random.uniform(-1.0, 1.0, drawn.size)
    moved = paths.seen > 0
    paths.level = np.where(moved, np.maximum(paths.level + _JITTER * random.normal(size=drawn.size), 0.01), paths.level)


def _future(paths: JumpPaths, now: float, random: np.random.Generator) -> Reals:
    """Time left of some of the particles, by drawing what is to come."""
    paths = paths.chosen(random.integers(0, paths.level.size, _FUTURES))
    waits = random.exponential((paths.length / paths.jumps)[:, None], (_FUTURES, _FUTURE_JUMPS))
    sizes = random.gamma(2.0, (0.5 * LIMIT / paths.jumps)[:, None], (_FUTURES, _FUTURE_JUMPS))
    above = paths.value(now)[:, None] + np.cumsum(sizes, axis=1) >= LIMIT
    at = np.maximum(paths.onset, now)[:, None] + np.cumsum(waits, axis=1)
    return np.ceil(np.where(above.any(axis=1), at[np.arange(_FUTURES), np.argmax(above, axis=1)], at[:, -1])) - now
