"""Draws of what a few numbers are by the readings: tempering from look to look (Del Moral, Doucet and Jasra 2006, "Sequential Monte Carlo samplers").

Moves are by differences of other draws (ter Braak 2006), one half of them by the other, so that several places of high likelihood are kept.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable

import numpy as np

from benchmarks.lives.few_numbers import FewNumbers
from benchmarks.lives.posterior import Looks, Posterior
from ema_tools.base.arrays import Reals

_DRAWS = 600  # of a kind, that are moved [effort]
_MOVES = 4  # of each after every step of the temperature [effort]
_KEPT = 0.5  # share of the draws that a step leaves [effort]
_SIZES = (1.0, 0.3, 0.1)  # of a move, over the one that is best for a normal posterior [effort]
_WHOLE = 0.1  # share of the moves by a whole difference, from one place of high likelihood to another [effort]
_JITTER = 1e-5  # beside it, so that every place can be reached [effort]
_HALVINGS = 30  # by which the temperature is found [precision]


def drawn(looks: Looks, family: FewNumbers, log_prior: float, random: np.random.Generator) -> list[Posterior]:
    """One family's draws at each look."""
    cube = random.random((_DRAWS, family.numbers))
    log, before = log_prior, 0
    found = []
    for count in looks.counts:
        now = float(looks.days[count - 1])
        cube, gained = _tempered(cube, functools.partial(_by, looks, family, count, before), random)
        log += gained
        found.append(Posterior(np.ceil(family.end(cube, now)) - now, log))
        before = count
    return found


def _by(looks: Looks, family: FewNumbers, count: int, before: int, cube: Reals) -> tuple[Reals, Reals]:
    """Logarithm of the likelihood of the first `count` readings and of a unit that is in service then, and of the first `before` readings, [draws]."""
    wear = family.wear(cube, looks.days[:count])
    now = float(looks.days[count - 1])
    whole = np.where(family.end(cube, now) > now, looks.log_likelihood(count, wear), -math.inf)
    return whole, looks.log_likelihood(before, wear[:, :before]) if before else np.zeros(cube.shape[0])


def _tempered(cube: Reals, by: Callable[[Reals], tuple[Reals, Reals]], random: np.random.Generator) -> tuple[Reals, float]:
    """Draws [draws, numbers] of the earlier likelihood carried to the whole one, and what the logarithm of the evidence gains."""
    whole, earlier = by(cube)
    heat, gained = 0.0, 0.0
    while heat < 1.0:
        more = np.where(np.isfinite(whole), whole - earlier, -math.inf)
        if not np.isfinite(more).any():
            return cube, -math.inf
        step = _step(more, 1.0 - heat)
        weight = step * more
        top = weight.max()
        share = np.exp(weight - top)
        gained += top + math.log(share.mean())
        heat += step
        chosen = np.searchsorted(np.cumsum(share) / share.sum(), (np.arange(len(cube)) + random.random()) / len(cube))
        chosen = np.minimum(chosen, len(cube) - 1)
        cube, whole, earlier = cube[chosen], whole[chosen], earlier[chosen]
        for _ in range(_MOVES):
            cube, whole, earlier = _moved(cube, whole, earlier, heat, by, random)
    return cube, gained


def _step(more: Reals, most: float) -> float:
    """The largest step of the temperature that leaves so many draws."""

    def left(step: float) -> float:
        share = np.exp(step * (more - more.max()))
        return float(share.sum() ** 2 / (share**2).sum() / more.size)

    alive = float(np.isfinite(more).mean())
    goal = _KEPT * alive
    if left(most) >= goal:
        return most
    low, high = 0.0, most
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if left(middle) >= goal else (low, middle)
    return max(low, 1e-9)


def _moved(
    cube: Reals, whole: Reals, earlier: Reals, heat: float, by: Callable[[Reals], tuple[Reals, Reals]], random: np.random.Generator
) -> tuple[Reals, Reals, Reals]:
    """Every draw tried elsewhere, one half by differences of the other."""
    cube, whole, earlier = cube.copy(), whole.copy(), earlier.copy()
    order = random.permutation(len(cube))
    half = len(cube) // 2
    for mine, others in ((order[:half], order[half:]), (order[half:], order[:half])):
        first, second = random.choice(others, mine.size), random.choice(others, mine.size)
        size = random.choice(_SIZES, (mine.size, 1)) * 2.38 / math.sqrt(2.0 * cube.shape[1])
        size = np.where(random.random((mine.size, 1)) < _WHOLE, 1.0, size)
        tried = cube[mine] + size * (cube[first] - cube[second]) + _JITTER * random.normal(size=(mine.size, cube.shape[1]))
        tried = np.abs(tried)
        tried = np.where(tried > 1.0, 2.0 - tried, tried)
        inside = ((tried >= 0.0) & (tried <= 1.0)).all(axis=1)
        new, old = by(np.clip(tried, 0.0, 1.0))
        target = heat * whole[mine] + (1.0 - heat) * earlier[mine]
        aim = np.where(np.isfinite(new), heat * new + (1.0 - heat) * old, -math.inf)
        taken = inside & (np.log(random.random(mine.size)) < aim - target)
        cube[mine[taken]], whole[mine[taken]], earlier[mine[taken]] = tried[taken], new[taken], old[taken]
    return cube, whole, earlier
