"""Bounded least squares: named unknowns fitted to what a function of them leaves, with slopes by finite differences."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from scipy.optimize import least_squares

from ema_tools.base.arrays import Reals
from ema_tools.base.parallel import each, in_step

# The first point lies inside its bounds by this share of them: from a bound itself the solver would not move along it [precision]
_INSIDE = 1e-9
# Where noise has unit variance: a fit that a tenth of a standard error parts from the best is there [precision]
PROMISE = 0.01


@dataclass(frozen=True)
class FreeValue:
    """One unknown in its own unit: where the fit begins, what it is stepped and measured in, and the range that it never leaves.

    `near`: so close to an end it lies on it; `walls`: whether its lower and its upper end are bounds that a value can run into. A size that ends at none runs into nothing, nor does a phase.
    """

    name: str
    start: float
    scale: float
    lower: float
    upper: float
    near: float = 0.0
    walls: tuple[bool, bool] = (True, True)

    def held(self, value: float) -> float:
        """The value, or the end that it lies beyond."""
        return float(np.clip(value, self.lower, self.upper))

    def on_bound(self, value: float) -> bool:
        """Whether a value lies on one of its walls."""
        return (self.walls[0] and value <= self.lower + self.near) or (self.walls[1] and value >= self.upper - self.near)


Values = Mapping[str, float]
Vector = Callable[[Values], Reals]
Vectors = Callable[[Sequence[Reals]], Sequence[Reals]]


class Slopes(Protocol):
    """A rule for slopes: columns [n, unknowns] per scale, at a point in scales [unknowns], `here` [n] there; `vectors` takes such points, the ends are in scales too."""

    def __call__(self, vectors: Vectors, point: Reals, here: Reals, lower: Reals, upper: Reals) -> Reals:
        """The columns."""
        ...


@dataclass(frozen=True)
class OneSided:
    """Each unknown moved by the first of `steps`, in scales, that changes the vector by more than `rough`, its length; by the last where none does. Never over an end of its range. All at once.

    One rule serves one fit: a step that was too small at one point is not tried again at the next.
    """

    steps: tuple[float, ...]
    rough: float = 0.0
    _first: dict[int, int] = field(default_factory=dict, init=False, repr=False, compare=False)

    def __call__(self, vectors: Vectors, point: Reals, here: Reals, lower: Reals, upper: Reals) -> Reals:
        """The columns."""
        return np.column_stack(
            in_step([self._column(point, here, place, lower[place], upper[place]) for place in range(point.size)], vectors)
        )

    def _column(self, point: Reals, here: Reals, place: int, lower: float, upper: float) -> Generator[Reals, Reals, Reals]:
        column = np.zeros_like(here)
        first = self._first.get(place, 0)
        for at, width in enumerate(self.steps[first:], first):
            self._first[place] = at
            step = _inside(float(point[place]), width, lower, upper)
            moved = point.copy()
            moved[place] += step
            change = (yield moved) - here
            column = change / step
            if float(change @ change) > self.rough**2:
                break
        return column


def _inside(value: float, width: float, lower: float, upper: float) -> float:
    """A step of this width up, or else down; where neither stays inside the ends, to the farther of them."""
    if value + width <= upper:
        return width
    if value - width >= lower:
        return -width
    return max(upper - value, lower - value, key=abs)


@dataclass(frozen=True)
class TwoSided:
    """Each unknown moved both ways by the share `step` of itself, or of a `least` size in scales where it is smaller; as far as its range goes. All points at once."""

    step: float
    least: float

    def __call__(self, vectors: Vectors, point: Reals, here: Reals, lower: Reals, upper: Reals) -> Reals:
        """The columns."""
        width = self.step * np.maximum(np.abs(point), self.least)
        low, high = np.maximum(point - width, lower), np.minimum(point + width, upper)
        moved = np.repeat(point[None], 2 * point.size, axis=0)
        places = np.arange(point.size)
        moved[places, places], moved[point.size + places, places] = low, high
        found = vectors(list(moved))
        return np.column_stack(
            [
                (above - below) / (high[k] - low[k])
                for k, (below, above) in enumerate(zip(found[: point.size], found[point.size :], strict=True))
            ]
        )


@dataclass(frozen=True)
class Stop:
    """When a fit ends: after so many `points`, where a step changes the point, the cost or the slope by less than these shares, or where the slopes promise no step that lowers
    the cost by as much as `of_promise`, in squares of the vector's unit."""

    points: int
    of_point: float
    of_cost: float
    of_slope: float = 1e-8  # as the solver has it [precision]
    of_promise: float = 0.0


@dataclass(frozen=True)
class Found:
    """Where the fit ended: `values` by name, those `at_bound`, what is left there [n] with its squared length `cost`, and the `slopes` of it [n, unknowns] per `scale` of each."""

    values: dict[str, float]
    at_bound: tuple[str, ...]
    residual: Reals
    cost: float
    slopes: Reals
    scale: Reals

    @property
    def covariance(self) -> Reals:
        """Of the values, in their units [unknowns, unknowns], when the residual is white with a variance of 1; nothing along what the residual does not show."""
        return np.asarray(np.linalg.pinv(self.slopes.T @ self.slopes) * np.outer(self.scale, self.scale), dtype=float)


class _Arrived(Exception):
    """Ends the solver's work from within, at a point [unknowns] with what is left there [n] and its slopes [n, unknowns]."""

    def __init__(self, point: Reals, left: Reals, slopes: Reals) -> None:
        super().__init__()
        self.end = (point, left, slopes)


def _promised(left: Reals, slopes: Reals) -> float:
    """By how much a step would lower the cost if the slopes held all the way."""
    down = slopes.T @ left
    return float(down @ np.linalg.pinv(slopes.T @ slopes) @ down)


def fit(
    unknowns: Sequence[FreeValue],
    vector: Vector,
    slopes: Slopes,
    stop: Stop,
    target: Reals | None = None,
    told: Callable[[], None] | None = None,
    many: Callable[[Sequence[Values]], Sequence[Reals]] | None = None,
) -> Found:
    """The unknowns where `vector` of them [n] is nearest to `target` [n], to zero when absent. `told` hears of every new point.

    `vector` gets all values, inside their ranges. `many`: the same of several points, where they take less time than each alone.
    """
    scale = np.array([one.scale for one in unknowns])
    lower, upper = np.array([one.lower for one in unknowns]) / scale, np.array([one.upper for one in unknowns]) / scale

    def values(point: Reals) -> dict[str, float]:
        return {one.name: one.held(value) for one, value in zip(unknowns, point * scale, strict=True)}

    def at(point: Reals) -> Reals:
        return vector(values(point))

    def at_each(points: Sequence[Reals]) -> Sequence[Reals]:
        asked = [values(point) for point in points]
        return each(vector, asked) if many is None else many(asked)

    last: tuple[Reals, Reals] | None = None

    def here(point: Reals) -> Reals:
        # slopes are asked for at the point whose residual was the last
        nonlocal last
        if last is None or not np.array_equal(last[0], point):
            last = (point.copy(), at(point))
        return last[1]

    def residual(point: Reals) -> Reals:
        if told is not None:
            told()
        return here(point) if target is None else here(point) - target

    def jacobian(point: Reals) -> Reals:
        columns = slopes(at_each, point, here(point), lower, upper)
        left = here(point) if target is None else here(point) - target
        if _promised(left, columns) < stop.of_promise:
            raise _Arrived(point.copy(), left, columns)
        return columns

    margin = _INSIDE * (upper - lower)
    begun = np.clip(np.array([one.start for one in unknowns]) / scale, lower + margin, upper - margin)
    try:
        solved = least_squares(
            residual,
            begun,
            jac=jacobian,
            bounds=(lower, upper),
            max_nfev=stop.points,
            xtol=stop.of_point,
            ftol=stop.of_cost,
            gtol=stop.of_slope,
        )
        end, left, columns = solved.x, np.asarray(solved.fun, dtype=float), np.asarray(solved.jac, dtype=float)
    except _Arrived as arrived:
        end, left, columns = arrived.end
    best = values(end)
    at_bound = tuple(one.name for one in unknowns if one.on_bound(best[one.name]))
    return Found(best, at_bound, left, float(left @ left), columns, scale)
