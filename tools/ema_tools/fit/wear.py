"""A value of a unit over its days: whether it has changed, since when, and when it will reach a limit.

A change is the step or the ramp from some day on that stands out most, in standard errors, against what the same days show by chance. Remaining life is a mixture of wear laws: a level, wear
that begins at an onset and slows down, goes on evenly, accelerates or stalls for a while, a part that fades (grease that runs in), and a random walk, which is what steps and irregular wear look
like; each law is weighed by its evidence, and levels and rates inside a law are integrated in closed form (a Gaussian process with a linear mean, as Rasmussen and Williams, section 2.7). What
comes may stall, go on again or change its pace at any time, since wear does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ema_tools.base.arrays import Reals

Indices = np.ndarray[Any, np.dtype[np.intp]]

_DRAWS = 4000  # of days by chance: to 0.25 % of a rate of 1 % [precision]
_SIDE = 2  # days on each side of a change [judgement]
READINGS_LEAST = 2 * _SIDE  # below which no change is told [judgement]
_DAYS_MAX = 80  # days that remaining life is found by: more are joined with their neighbours [layout]
_SEED = 20_011  # of the draws: the same days, the same answer [layout]
_LIKELY = 3.84  # twice the logarithm of the likelihood ratio at the end of a 95 % interval [chance]
_OUTLIER = 2.5  # standard deviations off its neighbours beyond which a day counts less [judgement]
_PATHS = 600  # futures [precision]
_AGES = 20.0  # ages ahead that are looked at; what comes later is never [layout]
_TIMES = 160  # in them [layout]
_POWERS = (0.5, 1.0, 1.6, 2.5)  # of the time since the onset [judgement]
_GROWTHS = (2.0, 5.0)  # e-foldings of wear in one age, where it feeds on itself [judgement]
_ONSETS = 12  # places of it [precision]
_WALKS = (0.0, 0.003, 0.01, 0.03, 0.1, 0.3)  # what the walk comes to over the age, as a share of the limit [judgement]
_FADES = (0.0, 0.05, 0.2)  # time in which grease runs in, as a share of the age; 0 is none [judgement]
_STALLS = 8  # places where wear may stall, or go on again [precision]
_PACES = (0.25, 0.75)  # share of the changes of pace that stall it, standard deviation of the logarithm of the others [judgement]
_CHANGES = 0.7  # changes of pace in one age [judgement]
_TEMPER = 0.5  # of the logarithm of the evidence: no law of the library is the machine's own, and days beside each other repeat what the law lacks [judgement]
_FAR = 50.0  # e-foldings [layout]
_CHUNK = 256  # laws at once [layout]


@dataclass(frozen=True)
class Drift:
    """Whether a value has changed: `chance` is how often days without change show as much; `since` is its first day, `since95` between which two days it begins with 95 %."""

    changed: bool
    chance: float
    since: float
    since95: tuple[float, float]
    by: float  # at the last day, by the step or ramp


@dataclass(frozen=True)
class Life:
    """Time from the last day until the limit is reached: median and 90 % interval, infinite where it is not reached in what is looked ahead; `now`: the value of the last day by all days."""

    median: float
    low: float
    high: float
    reached: float  # probability that it is reached at all in what is looked ahead
    now: float


def change(days: Reals, values: Reals, stds: Reals, false_alarm: float = 0.01) -> Drift:
    """Whether `values` [n] of `days` [n], in order, have changed, with standard errors `stds` [n], at a false-alarm rate."""
    count = days.size
    if count < READINGS_LEAST or not days[-1] > days[0]:
        return Drift(False, 1.0, math.inf, (math.inf, math.inf), 0.0)
    std = _robust(values, np.hypot(stds, _beyond(values, stds)))
    shapes, begins = _shapes(days)
    weight = 1.0 / std**2
    centred = shapes - np.average(shapes, axis=0, weights=weight)
    norm = np.sqrt(weight @ centred**2)
    template = weight[:, None] * centred / norm
    score = values @ template
    most = int(np.argmax(np.abs(score)))
    noise = np.random.default_rng(_SEED).normal(0.0, 1.0, (_DRAWS, count)) * std
    chance = float((1 + np.sum(np.max(np.abs(noise @ template), axis=1) >= abs(score[most]))) / (_DRAWS + 1))
    near = begins[score**2 >= score[most] ** 2 - _LIKELY]
    first, last = int(near.min()), int(near.max())
    by = float(score[most] / norm[most]) * float(shapes[-1, most])
    return Drift(chance <= false_alarm, chance, float(days[begins[most]]), (float(days[max(first - 1, 0)]), float(days[last])), by)


def _shapes(days: Reals) -> tuple[Reals, Indices]:
    """Steps and ramps that begin at every day with enough days on both sides, [n, shapes], and the places of those days."""
    places = np.arange(_SIDE, days.size - _SIDE + 1)
    steps = (np.arange(days.size)[:, None] >= places).astype(np.float64)
    onsets = np.arange(0, days.size - _SIDE)
    ramps = np.maximum(days[:, None] - days[onsets], 0.0)
    there = ramps[-1] > 0.0
    return np.hstack([steps, ramps[:, there]]), np.concatenate([places, onsets[there]])


def _beyond(values: Reals, stds: Reals) -> float:
    """What neighbouring days differ by beyond their standard errors, one standard deviation; by the middle of the differences, so that a step or a trend adds little."""
    if values.size < 2 * _SIDE:
        return 0.0
    shown = 1.4826 * float(np.median(np.abs(np.diff(values)))) / math.sqrt(2.0)
    return math.sqrt(max(0.0, shown**2 - float(np.median(stds)) ** 2))


def life(days: Reals, values: Reals, stds: Reals, limit: float) -> Life:
    """Time from the last of `days` [n] until `values` [n], with standard errors `stds` [n], reach `limit`, which lies above the healthy value 0."""
    std = _robust(values, np.hypot(stds, _beyond(values, stds)))
    time, value, error = _joined(days, values, std)
    age = max(time[-1] - time[0], 1e-9)
    at = (time - time[0]) / age
    laws = _all_laws()
    chunks = [np.arange(start, min(start + _CHUNK, laws.onset.size)) for start in range(0, laws.onset.size, _CHUNK)]
    parts = [_known(laws.part(places), at, value / limit, error / limit) for places in chunks]
    evidence = np.concatenate([one.evidence for one in parts])
    mean, root = (np.concatenate([getattr(one, name) for one in parts]) for name in ("mean", "root"))
    weight = np.exp(_TEMPER * (evidence - evidence.max()))
    random = np.random.default_rng(_SEED)
    picked = random.choice(weight.size, _PATHS, p=weight / weight.sum())
    ahead = np.concatenate([[0.0], np.geomspace(1e-3, _AGES, _TIMES)])
    reach = np.full(_PATHS, math.inf)
    levels = np.empty(_PATHS)
    for path, law in enumerate(picked):
        known = mean[law] + root[law] @ random.normal(0.0, 1.0, 4)
        levels[path], reach[path] = _future(laws.part(np.array([law])), known, ahead, random)
    low, middle, high = (float(np.quantile(reach, share, method="nearest")) for share in (0.05, 0.5, 0.95))
    return Life(age * middle, age * low, age * high, float(np.mean(np.isfinite(reach))), limit * float(np.median(levels)))


@dataclass(frozen=True)
class _Laws:
    """Every law, [laws]: onset, stall and going on again (both 1 for none; going on again 1 for one that lasts), shape (a power, or minus e-foldings), fading time and walk."""

    onset: Reals
    stall: Reals
    again: Reals
    shape: Reals
    fade: Reals
    walk: Reals
    share: Reals  # of the kind of law, before the days are seen

    def own_time(self, at: Reals) -> Reals:
        """Time in which wear went on until `at` [days], [laws, days]."""
        gone = np.maximum(at[None, :] - self.onset[:, None], 0.0)
        return gone - np.clip(at[None, :] - self.stall[:, None], 0.0, (self.again - self.stall)[:, None])

    def part(self, places: Indices) -> _Laws:
        """Some of them."""
        return _Laws(**{name: one[places] for name, one in vars(self).items()})


@dataclass(frozen=True)
class _Known:
    """What is known of each law: its logarithm of the evidence [laws], and of level, rate, fading part and walk of the last day mean [laws, 4] and root of the covariance [laws, 4, 4]."""

    evidence: Reals
    mean: Reals
    root: Reals


_PRIOR = np.array([0.3, 1.0, 0.3])  # level, rate over one age and fading part: one standard deviation as a share of the limit [judgement]


def _all_laws() -> _Laws:
    onsets = np.concatenate([[0.0], np.linspace(0.0, 1.0, _ONSETS + 1)[1:-1]])
    shapes = (*_POWERS, *(-one for one in _GROWTHS))
    steady = [(onset, 1.0, 1.0, shape, fade, walk) for onset in onsets for shape in shapes for fade in _FADES for walk in _WALKS]
    places = np.linspace(0.0, 1.0, _STALLS + 2)[1:]
    stalling = [
        (onset, stall, again, 1.0, 0.0, walk)
        for onset in onsets[: _ONSETS // 2]
        for stall in places[:-1]
        for again in places
        if onset < stall < again
        for walk in _WALKS[:-2]
    ]
    share = np.concatenate([np.full(len(one), 0.5 / len(one)) for one in (steady, stalling)])
    onset, stall, again, shape, fade, walk = np.array([*steady, *stalling]).T
    return _Laws(onset, stall, again, shape, fade, walk, share)


def _risen(own_time: Reals, shape: Reals) -> Reals:
    """Wear by its own time, 1 after one age."""
    growth = np.where(shape < 0.0, -shape, 1.0)
    # far beyond the limit it does not matter how far
    grown = np.expm1(np.minimum(growth * own_time, _FAR)) / np.expm1(growth)
    return np.where(shape < 0.0, grown, own_time ** np.where(shape < 0.0, 1.0, shape))


def _faded(at: Reals, fade: Reals) -> Reals:
    """The part that fades, from 0 at the beginning to -1."""
    return np.where(fade > 0.0, np.expm1(-at / np.where(fade > 0.0, fade, 1.0)), 0.0)


def _known(laws: _Laws, at: Reals, value: Reals, error: Reals) -> _Known:
    """The laws on days `at` from 0 to 1, values as a share of the limit."""
    count = laws.onset.size
    own = laws.own_time(at)
    bases = np.stack(
        [np.ones_like(own), _risen(own, laws.shape[:, None]), _faded(at[None, :], laws.fade[:, None])], axis=2
    )  # [laws, days, 3]
    scaled = bases * _PRIOR
    walks = laws.walk[:, None, None] ** 2 * np.minimum(own[:, :, None], own[:, None, :])
    cov = scaled @ scaled.transpose(0, 2, 1) + walks + np.diag(error**2)
    # what is asked for together with the days: level, rate, fading part, and the walk of the last day
    cross = np.concatenate([bases.transpose(0, 2, 1) * (_PRIOR**2)[None, :, None], walks[:, -1:, :]], axis=1)  # [laws, 4, days]
    prior = np.zeros((count, 4, 4))
    prior[:, range(3), range(3)] = _PRIOR**2
    prior[:, 3, 3] = walks[:, -1, -1]
    lower = np.linalg.cholesky(cov)
    white = np.linalg.solve(lower, np.broadcast_to(value, (count, at.size))[:, :, None])[:, :, 0]
    gain = np.linalg.solve(lower, cross.transpose(0, 2, 1))  # [laws, days, 4]
    evidence = -0.5 * np.sum(white**2, axis=1) - np.sum(np.log(np.diagonal(lower, axis1=1, axis2=2)), axis=1) + np.log(laws.share)
    spread, axes = np.linalg.eigh(prior - np.einsum("ldk,ldm->lkm", gain, gain))
    return _Known(evidence, np.einsum("ldk,ld->lk", gain, white), axes * np.sqrt(np.maximum(spread, 0.0))[:, None, :])


def _future(law: _Laws, known: Reals, ahead: Reals, random: np.random.Generator) -> tuple[float, float]:
    """One future by one law with the values `known` [4] at the last day: the value there, and after which time, in ages, the limit is reached."""
    level, rate, part, walked = known
    stalled = law.stall[0] < 1.0 <= law.again[0]
    further = _paced(ahead, stalled, random)
    own = law.own_time(np.array([1.0]))[0, 0] + further
    moved = np.concatenate([[0.0], np.cumsum(law.walk[0] * np.sqrt(np.diff(further)) * random.normal(0.0, 1.0, ahead.size - 1))])
    path = level + rate * _risen(own, law.shape) + part * _faded(1.0 + ahead, law.fade) + walked + moved
    beyond = np.flatnonzero(path >= 1.0)
    if beyond.size == 0:
        return float(path[0]), math.inf
    first = int(beyond[0])
    if first == 0:
        return float(path[0]), 0.0
    share = (1.0 - path[first - 1]) / (path[first] - path[first - 1])
    return float(path[0]), float(ahead[first - 1] + share * (ahead[first] - ahead[first - 1]))


def _paced(ahead: Reals, stalled: bool, random: np.random.Generator) -> Reals:
    """Time in which wear goes on from now: as the clock's, or not at all where it is stalled, until it changes its pace, at times that are as likely as any other; what stalls goes on again."""
    stalls, spread = _PACES
    first, second = np.cumsum(random.exponential(1.0 / _CHANGES, 2))
    paces = np.exp(random.normal(0.0, spread, 2))
    if not stalled and random.random() < stalls:
        paces[0] = 0.0
    now = 0.0 if stalled else 1.0
    return np.asarray(
        now * np.minimum(ahead, first) + paces[0] * np.clip(ahead - first, 0.0, second - first) + paces[1] * np.maximum(ahead - second, 0.0)
    )


def _robust(values: Reals, stds: Reals) -> Reals:
    """Standard errors, larger where a day lies far off those beside it."""
    if values.size < 2 * _SIDE + 1:
        return stds
    beside = np.array([np.median(values[max(0, place - _SIDE) : place + _SIDE + 1]) for place in range(values.size)])
    off = np.abs(values - beside)
    return np.where(off > _OUTLIER * stds, np.maximum(stds, off), stds)


def _joined(days: Reals, values: Reals, stds: Reals) -> tuple[Reals, Reals, Reals]:
    """Days, values and standard errors, neighbours joined where there are many."""
    if days.size <= _DAYS_MAX:
        return days, values, stds
    weight = 1.0 / stds**2
    groups = np.array_split(np.arange(days.size), _DAYS_MAX)

    def mean(of: Reals) -> Reals:
        return np.array([np.average(of[group], weights=weight[group]) for group in groups])

    return mean(days), mean(values), np.array([1.0 / math.sqrt(weight[group].sum()) for group in groups])
