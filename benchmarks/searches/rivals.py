"""The searches: each gets the cost of a point in the unit box, a start and a seed, and goes on until it ends by itself, arrives, or has used up its model runs.

All but the two of least squares see one number per model run, the flight's own cost; these see every residual, which is more.
"""

from __future__ import annotations

import contextlib
import math
import time
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import cma
import nlopt
import numpy as np
from scipy.optimize import Bounds, differential_evolution, dual_annealing, least_squares, minimize

from benchmarks.searches.problems import CAP, NOISE, Problem
from ema_tools.base.arrays import Reals
from ema_tools.data.actuator import reference_actuator
from ema_tools.plant.least_squares import Searched, SquaresSettings
from ema_tools.plant.least_squares import least_squares as least_squares_onboard
from ema_tools.plant.native import AnnealerSettings, library

CLOSE = 1e-3
# What a plain annealer falls to of its first temperature, the paper's objective before the search (case A).
_TEXTBOOK_FIRST, _TEXTBOOK_LAST = 0.66, 1e-9
_FIRST_STEP = 0.2
_LOCAL_STEP = 0.1
_DIFFERENCE = 1e-4
_COST_DIFFERENCE = 1e-3
_SHIPPED_DIMENSION = 2


class Over(Exception):
    """The search has arrived, or its model runs are used up."""


@dataclass
class Count:
    """Counts model runs and the time of the search, and keeps the best point and when it was good enough: `close`, every value within CLOSE of its scale from the lowest point, and
    `noise`, a cost that the sensor's noise cannot tell from the lowest."""

    problem: Problem
    begun_s: float = field(default_factory=time.thread_time)
    runs: int = 0
    cost: float = math.inf
    theta: Reals | None = None
    when: dict[str, tuple[int, float]] = field(default_factory=dict)

    @property
    def cap(self) -> int:
        """Most model runs."""
        return CAP[self.problem.dimension]

    def _seen(self, theta: Reals, cost: float) -> None:
        self.runs += 1
        if cost < self.cost:
            self.cost, self.theta = cost, theta
            now = (self.runs, time.thread_time() - self.begun_s)
            lowest = self.problem.lowest
            if "close" not in self.when and np.all(np.abs(theta - lowest.theta) <= CLOSE * self.problem.objective.scale):
                self.when["close"] = now
            if "noise" not in self.when and cost <= lowest.cost + self.problem.level:
                self.when["noise"] = now
        if len(self.when) == 2 or self.runs >= self.cap:
            raise Over

    def __call__(self, unit: Reals) -> float:
        """The flight's cost at a point of the unit box."""
        theta = self.problem.objective.inside(np.clip(unit, 0.0, 1.0))
        cost = self.problem.objective.cost(theta)
        self._seen(theta, cost)
        return cost

    def march(self, runs: int, theta: Reals) -> None:
        """A search that counts its own model runs, and searches by itself, has come to `theta` [p] with them."""
        self.runs = runs - 1
        self._seen(theta, self.problem.objective.cost(theta))

    def residuals(self, unit: Reals) -> Reals:
        """Every residual at a point of the unit box."""
        theta = self.problem.objective.inside(np.clip(unit, 0.0, 1.0))
        found = self.problem.objective.residuals(theta)
        self._seen(theta, float(found @ found))
        return found


Rival = Callable[[Count, Reals, int], None]


def _onboard(count: Count, start: Reals, seed: int) -> None:
    """The module's annealer, float32, settings of the shipped actuator; in more dimensions it cools as many times slower."""
    search = {name.partition(".")[2]: reference_actuator()[name] for name in _SETTINGS}
    more = start.size / _SHIPPED_DIMENSION
    settings = AnnealerSettings(
        start=tuple(start),
        initial_temperature=search["initial_temperature_mm2s"],
        cooling=search["cooling"] ** (1.0 / more),
        function_tolerance=search["function_tolerance_mm2s"],
        evaluation_budget=count.cap,
        stall_evaluations=20 * start.size,
        reanneal_interval=int(search["reanneal_interval"]),
        seed=seed,
    )
    library(32).anneal(settings, lambda unit, _limit: count(unit))


def _module_squares(count: Count, start: Reals, _seed: int) -> None:
    """The module's least squares, float32, as it is onboard; it sees the residuals of the signals that the objective weighs."""
    objective = count.problem.objective
    searched = tuple(
        Searched(one.names[0], one.lower, one.upper, at, one.names[1] if len(one.names) > 1 else None)
        for one, at in zip(objective.parameters, objective.inside(start), strict=True)
    )
    noise = tuple(std if weight > 0.0 else 0.0 for std, weight in zip(NOISE, objective.weight, strict=True))
    settings = SquaresSettings(searched, (noise[0], noise[1], noise[2], noise[3]), run_budget=count.cap)
    values, options = objective.actuator.arrays()
    found = least_squares_onboard(
        values,
        options,
        objective.command_mm,
        objective.channels,
        settings,
        progress=lambda runs, _misfit, lowest: count.march(runs, lowest),
    )
    count.runs = found.runs


_SETTINGS = (
    "search.initial_temperature_mm2s",
    "search.cooling",
    "search.function_tolerance_mm2s",
    "search.reanneal_interval",
)


def _textbook(count: Count, start: Reals, seed: int) -> None:
    """Metropolis with geometric cooling over all of its model runs; all coordinates move at once, by less as it cools."""
    rng = np.random.default_rng(seed)
    factor = _TEXTBOOK_LAST ** (1.0 / count.cap)
    temperature, here = _TEXTBOOK_FIRST, start
    cost = count(here)
    while True:
        width = _FIRST_STEP * math.sqrt(temperature / _TEXTBOOK_FIRST)
        there = np.abs(here + width * rng.standard_normal(here.size))
        there = np.clip(np.where(there > 1.0, 2.0 - there, there), 0.0, 1.0)
        found = count(there)
        if found <= cost - temperature * math.log(1.0 - rng.random()):
            here, cost = there, found
        temperature *= factor


def _dual(count: Count, start: Reals, seed: int) -> None:
    # its local searches would take differences far below what a float32 cost resolves
    local: Any = {"method": "L-BFGS-B", "jac": "3-point", "options": {"finite_diff_rel_step": _COST_DIFFERENCE}}
    dual_annealing(count, [(0.0, 1.0)] * start.size, x0=start, maxfun=10 * count.cap, minimizer_kwargs=local, rng=seed)


def _evolution(count: Count, start: Reals, seed: int) -> None:
    differential_evolution(
        count, Bounds(np.zeros(start.size), np.ones(start.size)), x0=start, tol=0.0, maxiter=count.cap, polish=False, rng=seed
    )


def _simplex(count: Count, start: Reals, _seed: int) -> None:
    inward = np.where(start > 0.5, -_LOCAL_STEP, _LOCAL_STEP)
    corners = start + np.vstack([np.zeros(start.size), np.diag(inward)])
    minimize(
        count,
        start,
        method="Nelder-Mead",
        bounds=[(0.0, 1.0)] * start.size,
        options={"initial_simplex": corners, "xatol": 1e-8, "fatol": 1e-15, "maxfev": 10 * count.cap, "adaptive": start.size > 2},
    )


def _squares(count: Count, start: Reals, _seed: int) -> None:
    least_squares(
        count.residuals,
        start,
        bounds=(0.0, 1.0),
        diff_step=[_DIFFERENCE] * start.size,
        xtol=1e-12,
        ftol=1e-12,
        gtol=1e-14,
        max_nfev=10 * count.cap,
    )


def _nlopt(algorithm: int) -> Rival:
    def search(count: Count, start: Reals, seed: int) -> None:
        nlopt.srand(seed)
        solver = nlopt.opt(algorithm, start.size)
        solver.set_lower_bounds(0.0)
        solver.set_upper_bounds(1.0)
        solver.set_initial_step(_LOCAL_STEP)
        solver.set_xtol_abs(1e-9)
        solver.set_maxeval(10 * count.cap)
        over = False

        def cost(x: Reals, _gradient: Reals) -> float:
            # an exception would not stop all of its algorithms at once
            nonlocal over
            if not over:
                try:
                    return count(np.array(x))
                except Over:
                    over = True
                    solver.force_stop()
            return math.inf

        solver.set_min_objective(cost)
        with contextlib.suppress(nlopt.RoundoffLimited, nlopt.ForcedStop):
            solver.optimize(start)

    return search


def _cma(count: Count, start: Reals, seed: int) -> None:
    options = {"bounds": [0.0, 1.0], "seed": seed, "verbose": -9, "tolfun": 1e-15, "tolfunhist": 1e-16, "tolx": 1e-9}
    strategy = cma.CMAEvolutionStrategy(start, 0.3, options)
    while not strategy.stop():
        points = strategy.ask()
        strategy.tell(points, [count(point) for point in points])


RIVALS: Mapping[str, Rival] = {
    "this annealer": _onboard,
    "this module's least squares (sees residuals)": _module_squares,
    "textbook annealer": _textbook,
    "SciPy dual_annealing": _dual,
    "SciPy differential_evolution": _evolution,
    "SciPy Nelder-Mead": _simplex,
    "SciPy least_squares (sees residuals)": _squares,
    "NLopt DIRECT": _nlopt(nlopt.GN_DIRECT),
    "NLopt CRS2": _nlopt(nlopt.GN_CRS2_LM),
    "NLopt BOBYQA": _nlopt(nlopt.LN_BOBYQA),
    "NLopt SBPLX": _nlopt(nlopt.LN_SBPLX),
    "CMA-ES": _cma,
}
# Neither start nor seed changes DIRECT: it searches once. The textbook annealer uses all of its model runs from every start.
FEWER_STARTS: Mapping[str, int] = {"NLopt DIRECT": 1, "textbook annealer": 25}


def search(problem: Problem, rival: str, start: Reals, seed: int) -> Count:
    """One search of one rival from `start` [p] in the unit box."""
    count = Count(problem)
    with contextlib.suppress(Over), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        RIVALS[rival](count, start, seed)
    return count
