"""The objective round the answer of `ema identify`: its profile along each value, its map over both, and whether the record determines them at all.

All of it is the objective of the C module that was searched. Along a profile the other values go along the valley that the sensitivities at the estimate show, or stay where that is better; so the
profile lies nowhere above what a plain cut shows, and no value has to be searched again.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.parallel import each
from ema_tools.data.actuator import row_of
from ema_tools.data.records import start_of
from ema_tools.fit.interval import slopes
from ema_tools.plant.native import CHANNELS, IdentifiedValue, library
from ema_tools.tasks.identify import Identified
from ema_tools.tasks.onboard_search import BOUNDS, POSITION_ALONE, POSITION_NOISE

_SIDE = 12  # points of a profile on either side of the estimate [effort]
_MAP = 15  # points of the map along each value [effort]
_CHANCE = 3.84  # of the squared residual over the noise: a value that raises it by less lies inside the 95 % region [chance]
_NEAREST = 1.0  # standard errors: the point of a profile next to the estimate [precision]
_LEAST = 1e-4  # of the bounds' width: the same where that is smaller [precision]
_ROOM = 0.6  # of the distance from healthy to estimate, which the map shows beyond them ... [layout]
_LEAST_ROOM = 0.15  # ... and at least this share of the healthy value [layout]
_CORRELATED = 0.99  # neighbouring residuals count as no more alike than this [precision]

# Why a value is not determined: the interval is wider than the bounds, the profile is flat between them, or nothing of the record moves with it.
Why = Literal["interval", "flat", "nothing"]


@dataclass(frozen=True)
class Profile:
    """The objective along one value, the others at their best as far as a line goes: `values` [k] in its unit, `objective` [k]; `limit`: up to there the value lies inside the 95 % region by what
    the residual is."""

    name: str
    values: Reals
    objective: Reals
    limit: float


@dataclass(frozen=True)
class Surface:
    """The objective over two values: `values` [m], [n] in their units, `objective` [n, m]."""

    names: tuple[str, str]
    values: tuple[Reals, Reals]
    objective: Reals


@dataclass(frozen=True)
class Undetermined:
    """A value that the record does not determine between the `bounds` of the search; `interval`: the 95 % interval, None without ends."""

    name: str
    why: Why
    bounds: tuple[float, float]
    interval: tuple[float, float] | None


@dataclass(frozen=True)
class Shape:
    """The objective round an answer. `tried`: the values of the search's runs by name [runs], where they are known; `surface` is None where it was not wanted or one value is searched alone."""

    profiles: tuple[Profile, ...]
    surface: Surface | None
    tried: Mapping[str, Reals]
    cost: Reals
    undetermined: tuple[Undetermined, ...]


class _Objective:
    """The objective that was searched, as a function of the identified values."""

    def __init__(self, found: Identified) -> None:
        self.found = found
        self.weight = found.settings.weight or POSITION_ALONE
        self.table = found.seen.table()
        every = (*found.answer.identified, *found.answer.day)
        self.names = tuple(one.name for one in every)
        self.at = np.array([one.today for one in every])
        ends = [_bounds(found, one.name) for one in every]
        self.lower, self.upper = (np.array([end[side] for end in ends]) for side in (0, 1))
        here = found.healthy.changed(dict(zip(self.names, np.clip(self.at, self.lower, self.upper).tolist(), strict=True)))
        self.start_mm = start_of(here, found.seen)
        columns = slopes(here, found.seen, self.names, dict(zip(CHANNELS, self.weight, strict=True)))
        self.columns = np.column_stack([columns[name] for name in self.names])

    def __call__(self, values: Reals) -> float:
        inside = np.clip(values, self.lower, self.upper).tolist()
        machine = self.found.healthy.changed(dict(zip(self.names, inside, strict=True)))
        return library(self.found.precision).objective(
            *machine.arrays(), self.found.seen.command_mm, self.table, self.weight, self.start_mm
        )

    def along(self, held: Sequence[int]) -> Reals:
        """How the other values go along the valley per unit of each held one, [held, values]; the held ones go by themselves."""
        others = [place for place in range(len(self.names)) if place not in held]
        steps = np.zeros((len(held), len(self.names)))
        steps[range(len(held)), held] = 1.0
        if others:
            steps[:, others] = -(np.linalg.pinv(self.columns[:, others]) @ self.columns[:, held]).T
        return steps


def _bounds(found: Identified, name: str) -> tuple[float, float]:
    """Of the search; the range of a value that differs from day to day."""
    if name in BOUNDS:
        lower, upper = BOUNDS[name]
        return found.healthy[lower], found.healthy[upper]
    row = row_of(name)
    return row.lower, row.upper


def shape_of(found: Identified, mapped: bool = True) -> Shape:
    """The shape of the objective round an answer: some hundred model runs, fewer where no map is wanted, and none of them a search."""
    objective = _Objective(found)
    values = found.answer.identified
    noise = _noise(found)
    profiles = [_profile(objective, place, one.std, noise) for place, one in enumerate(values)]
    surface = _surface(objective, found) if mapped and len(values) == 2 else None
    pairs = [(cost, tried) for cost, tried in zip(found.costs, found.tried, strict=True) if tried]
    tried = {one.name: np.array([point[place] for _, point in pairs]) for place, one in enumerate(values)}
    unsure = [_undetermined(found, one, profile) for one, profile in zip(values, profiles, strict=True)]
    return Shape(tuple(profiles), surface, tried, np.array([cost for cost, _ in pairs]), tuple(one for one in unsure if one is not None))


def _half(found: Identified, one: IdentifiedValue) -> float:
    low, high = found.interval95(one)
    return 0.5 * (high - low) if low is not None and high is not None else 0.0


def _noise(found: Identified) -> float:
    """What one squared standard deviation of a row's noise adds to the objective; neighbours that are alike tell less."""
    answer, record = found.answer, found.seen
    left = answer.objective_after / (record.rows * record.period_s)
    if found.settings.weight in (None, POSITION_ALONE):
        left = max(left, found.healthy[POSITION_NOISE] ** 2)
    alike = min(max(answer.residual_correlation, 0.0), _CORRELATED)
    return left * record.period_s * (1.0 + alike) / (1.0 - alike)


def _profile(objective: _Objective, place: int, std: float, noise: float) -> Profile:
    at, lower, upper = (float(ends[place]) for ends in (objective.at, objective.lower, objective.upper))
    near = max(_NEAREST * std if math.isfinite(std) else 0.0, _LEAST * (upper - lower))
    sides = [
        at + sign * np.geomspace(min(near, reach), reach, _SIDE)
        for sign, reach in ((-1.0, at - lower), (1.0, upper - at))
        if reach > _LEAST * (upper - lower)
    ]
    values = np.unique(np.concatenate([[at], *sides]))
    cut, valley = np.zeros(len(objective.names)), objective.along([place])[0]
    cut[place] = 1.0
    points = [objective.at + (value - at) * way for value in values for way in (cut, valley)]
    found = np.array(each(objective, points)).reshape(len(values), 2)
    least = np.min(found, axis=1)
    return Profile(objective.names[place], values, least, float(np.min(least)) + _CHANCE * noise)


def _surface(objective: _Objective, found: Identified) -> Surface:
    axes = []
    for place, one in enumerate(found.answer.identified):
        healthy, half = found.healthy[one.name], _half(found, one)
        room = max(_ROOM * abs(one.today - healthy), _LEAST_ROOM * healthy, 3.0 * half)
        low = max(min(healthy, one.today) - room, float(objective.lower[place]))
        high = min(max(healthy, one.today) + room, float(objective.upper[place]))
        # denser near the estimate, where the valley is narrow
        steps = np.linspace(-1.0, 1.0, _MAP)
        away = np.where(steps < 0.0, one.today - low, high - one.today)
        axes.append(np.unique(one.today + np.sign(steps) * steps**2 * away))
    ways = objective.along([0, 1])
    points = [
        objective.at + (first - objective.at[0]) * ways[0] + (second - objective.at[1]) * ways[1] for second in axes[1] for first in axes[0]
    ]
    names = (objective.names[0], objective.names[1])
    return Surface(names, (axes[0], axes[1]), np.array(each(objective, points)).reshape(len(axes[1]), len(axes[0])))


def _undetermined(found: Identified, one: IdentifiedValue, profile: Profile) -> Undetermined | None:
    bounds = _bounds(found, one.name)
    low, high = found.interval95(one)
    interval = (low, high) if low is not None and high is not None else None
    if interval is None or not math.isfinite(one.std):
        return Undetermined(one.name, "nothing", bounds, None)
    if interval[1] - interval[0] >= bounds[1] - bounds[0]:
        return Undetermined(one.name, "interval", bounds, interval)
    if float(np.max(profile.objective)) <= profile.limit:
        return Undetermined(one.name, "flat", bounds, interval)
    return None
