"""The flight's objective as a function of a few values, and its lowest point by a search of its own kind: a dense grid, least squares from its best cells, and a simplex at the end.

What is held against it takes nothing of that: the annealer sees one number per model run, least squares every residual in float64.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from scipy.optimize import least_squares, minimize

from ema_tools.base.arrays import Integers, Reals
from ema_tools.data.actuator import Actuator
from ema_tools.library.definitions import load_definitions
from ema_tools.plant.native import CHANNELS, library

POSITION_ALONE = (1.0, 0.0, 0.0, 0.0)
# Relative step of a finite difference: far above float64's rounding of a simulated run, far below where the model bends.
_DIFFERENCE = 1e-4
# Changes of this share of a value move the cost by less than it is rounded to in float32: what differs there is rounding.
_STILL = 1e-5
_STILL_POINTS = 16


@dataclass(frozen=True)
class Parameter:
    """One value that is searched: the names that it sets (each its nominal value times the same factor, where there are several), bounds and healthy value, and what its shifts are
    counted in."""

    title: str
    names: tuple[str, ...]
    lower: float
    upper: float
    healthy: float
    scale: float


@dataclass(frozen=True)
class Objective:
    """Cost of a record [rows] for values of `parameters`; `channels` [rows, 4] of CHANNELS, `weight` of them. The model is `actuator` with these values."""

    actuator: Actuator
    parameters: tuple[Parameter, ...]
    command_mm: Reals
    channels: Reals
    weight: tuple[float, float, float, float] = POSITION_ALONE

    @cached_property
    def lower(self) -> Reals:
        """Bounds, [p]."""
        return np.array([one.lower for one in self.parameters])

    @cached_property
    def upper(self) -> Reals:
        """Bounds, [p]."""
        return np.array([one.upper for one in self.parameters])

    @cached_property
    def scale(self) -> Reals:
        """What shifts are counted in, [p]."""
        return np.array([one.scale for one in self.parameters])

    @cached_property
    def healthy(self) -> Reals:
        """Healthy values, [p]."""
        return np.array([one.healthy for one in self.parameters])

    @cached_property
    def _arrays(self) -> tuple[Reals, Integers]:
        return self.actuator.arrays()

    @cached_property
    def _period_s(self) -> float:
        return float(self.actuator["timing.step_s"] * self.actuator["timing.record_every_steps"])

    def values(self, theta: Reals) -> Reals:
        """The model's values with `theta` [p] in them."""
        ids = load_definitions().ids
        values = self._arrays[0].copy()
        for one, number in zip(self.parameters, theta, strict=True):
            for name in one.names:
                values[ids[name]] = number if len(one.names) == 1 else values[ids[name]] * number / one.healthy
        return values

    def cost(self, theta: Reals) -> float:
        """The flight's own objective, float32."""
        return library(32).objective(self.values(theta), self._arrays[1], self.command_mm, self.channels, self.weight)

    def residuals(self, theta: Reals) -> Reals:
        """Residuals of the weighted channels, whose squares sum to the objective, float64."""
        made = library(64).simulate(self.values(theta), self._arrays[1], self.command_mm)
        used = [place for place, weight in enumerate(self.weight) if weight > 0.0]
        return np.concatenate([(self.channels[:, k] - getattr(made, CHANNELS[k])) * np.sqrt(self.weight[k] * self._period_s) for k in used])

    def inside(self, unit: Reals) -> Reals:
        """The values at a point [p] of the unit box."""
        return self.lower + np.asarray(unit) * (self.upper - self.lower)

    def jacobian(self, theta: Reals) -> Reals:
        """Sensitivities of the residuals per scale of each value, [n, p], by central differences."""
        columns = []
        for place, scale in enumerate(self.scale):
            step = np.zeros(len(self.parameters))
            step[place] = _DIFFERENCE * scale
            columns.append((self.residuals(theta + step) - self.residuals(theta - step)) / (2.0 * _DIFFERENCE))
        return np.column_stack(columns)


@dataclass(frozen=True)
class Optimum:
    """The lowest point [p] inside the bounds, the flight's cost there, and by how much that cost differs between points that are the same to it: rounding."""

    theta: Reals
    cost: float
    rounding: float

    def at_bound(self, objective: Objective) -> bool:
        """Whether it lies on a bound, so that the lowest point of all may lie beyond."""
        range_ = objective.upper - objective.lower
        return bool(np.any((self.theta - objective.lower < 5e-4 * range_) | (objective.upper - self.theta < 5e-4 * range_)))


def grid(objective: Objective, cells: int) -> list[Reals]:
    """Centres of `cells` to a side of the box."""
    sides = (np.arange(cells) + 0.5) / cells
    return [objective.inside(np.array(unit)) for unit in product(sides, repeat=len(objective.parameters))]


def optimum(objective: Objective, starts: Sequence[Reals], cells: int = 0, polish: bool = True) -> Optimum:
    """The lowest point by least squares from `starts` and from the best three of a grid of `cells` to a side, polished by a simplex on the flight's own cost."""
    begin = list(starts)
    if cells:
        points = grid(objective, cells)
        costs = [objective.cost(point) for point in points]
        begin += [points[place] for place in np.argsort(costs)[:3]]
    margin = 1e-6 * (objective.upper - objective.lower)
    found: list[tuple[float, Reals]] = []
    for start in begin:
        solved = least_squares(
            objective.residuals,
            np.clip(start, objective.lower + margin, objective.upper - margin),
            bounds=(objective.lower, objective.upper),
            x_scale=objective.scale,
            diff_step=[_DIFFERENCE] * len(objective.parameters),
            xtol=1e-12,
            ftol=1e-12,
            gtol=1e-14,
        )
        found.append((objective.cost(solved.x), solved.x))
    found.sort(key=lambda one: one[0])
    cost, theta = found[0]
    if polish:
        for _, start in found[:2]:
            lowered = _polished(objective, start)
            if (there := objective.cost(lowered)) < cost:
                cost, theta = there, lowered
    return Optimum(theta, cost, _rounding(objective, theta))


def _polished(objective: Objective, start: Reals) -> Reals:
    """A simplex of a thousandth of each scale around `start`."""

    def cost(z: Reals) -> float:
        return objective.cost(np.clip(z * objective.scale, objective.lower, objective.upper))

    corners = start / objective.scale + np.vstack([np.zeros(start.size), 1e-3 * np.eye(start.size)])
    solved = minimize(
        cost, start / objective.scale, method="Nelder-Mead", options={"xatol": 1e-6, "fatol": 1e-14, "initial_simplex": corners}
    )
    return np.clip(solved.x * objective.scale, objective.lower, objective.upper)


def _rounding(objective: Objective, theta: Reals) -> float:
    rng = np.random.default_rng(1)
    moved = theta + _STILL * objective.scale * rng.uniform(-1.0, 1.0, (_STILL_POINTS, theta.size))
    return float(np.ptp([objective.cost(np.clip(one, objective.lower, objective.upper)) for one in moved]))
