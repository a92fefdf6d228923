"""Effects fitted together to the evidence: values, standard errors, bounds hit, the cost that is left."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.base.parallel import each
from ema_tools.data.actuator import Row, row_of
from ema_tools.data.records import Record
from ema_tools.fit import bounded
from ema_tools.fit.bounded import PROMISE, FreeValue, OneSided, Stop
from ema_tools.fit.evidence import ROUGHNESS, Evidence, View, settled
from ema_tools.fit.misfit import DIRECTIONS, misfit, whole_std
from ema_tools.library.definitions import is_size
from ema_tools.library.faults import FAULTS, effect_of
from ema_tools.library.registry import record_of
from ema_tools.library.shapes import penalty

Start = TypeVar("Start")

_RUNS = 8  # points of one fit at most, each of which costs a simulation for every value [effort]
# A slope is taken over this share of a value, or over as much more as it takes to show beyond the model's own roughness, in standard
# deviations of noise [precision]
_JACOBIAN_STEPS = (0.05, 0.2, 0.6)
_PHASE_SCALE = 0.5  # rad: what a phase is stepped in [judgement]
_DETERMINED = 2.0  # standard errors by which a size differs from the machine's own [chance]
_AT_BOUND = 1e-6  # of its range: so near to an end a value lies on it [precision]
POLISHED = 3  # of fits with the nuisance parameters linear at the last one [effort]
_WORN_START = 1.3  # where both faults are fitted together: where they begin, in healthy values [judgement]
_JOINT_ROUNDS = 8  # of steps together with what scatters [effort]
# Shares of a value over which a slope is taken to both sides: the first, or the second where that one does not show [precision]
_JOINT_STEPS = (0.1, 0.3)
_JOINT_SHARES = (1.0, 0.5, 0.2)  # of a step that are tried, until one lowers the cost [judgement]
_JOINT_DONE = 0.1  # of the cost: a step that lowers it by less was the last [precision]


@dataclass(frozen=True)
class Fit:
    """Effects fitted together: their values, the covariance of those that are fitted [fitted, fitted] (they come first), the cost left, the values that lie on a bound,
    and the evidence seen from there.

    `cost` is that of the residual; `judged` adds what the choice of shapes explains of noise.
    """

    effects: tuple[str, ...]
    values: Mapping[str, float]
    covariance: Reals
    at_bound: tuple[str, ...]
    view: View
    cost: float

    @property
    def judged(self) -> float:
        """What fits of different effects are compared by."""
        return self.cost + penalty(self.effects)

    @property
    def fitted(self) -> tuple[str, ...]:
        """Names of the values that are free, in the order of the covariance."""
        return tuple(self.values)[: len(self.covariance)]

    @property
    def std(self) -> dict[str, float]:
        """Standard errors by name: of noise and scatter, larger by what the misfit may have bent, and no smaller than the share to which the model is trusted."""
        known = self.view.evidence.actuator
        evidence = self.view.evidence
        left = misfit(self.cost, evidence.expected_cost(), evidence.numbers, evidence.counting)
        found = {}
        for k, name in enumerate(self.fitted):
            by_noise = float(np.sqrt(max(self.covariance[k, k], 0.0)))
            change = self.values[name] - known[row_of(name).name]
            if evidence.relative:
                std = whole_std(by_noise, left, name, change)
            else:
                # the form of the whole machine errs, and not of one effect; what a parameter does as well is known as the data sheet knows that one
                std = whole_std(by_noise, 0.0 if _is_confounded(name) else left, name, change, 1.0 / DIRECTIONS)
            found[name] = max(std, _least_std(evidence, name))
        return found

    def shown(self, effect: str) -> float:
        """By how many standard errors, of noise and scatter alone, the size of an effect differs from the machine's own."""
        size = next(name for name in self.fitted if effect_of(name) == effect)
        k = self.fitted.index(size)
        change = abs(self.values[size] - self.view.evidence.actuator[row_of(size).name])
        return float(change / max(np.sqrt(max(self.covariance[k, k], 0.0)), 1e-300))

    def determined(self, effect: str) -> bool:
        """Whether the size of an effect differs from the machine's own by more than its whole standard error leaves open, that of the misfit included."""
        size = next((name for name in self.fitted if effect_of(name) == effect), None)
        return size is None or abs(self.values[size] - self.view.evidence.actuator[row_of(size).name]) >= _DETERMINED * self.std[size]

    def deviations(self) -> Reals:
        """What scatters, at its best beside the fitted values, in spreads."""
        return self.view.best_deviations(self.view.moved(self.values))

    def of_effect(self, effect: str) -> dict[str, float]:
        """Values of one effect."""
        return {name: value for name, value in self.values.items() if effect_of(name) == effect}


def _is_confounded(name: str) -> bool:
    return is_size(name) and record_of(effect_of(name)).confounded is not None


def _least_std(evidence: Evidence, name: str) -> float:
    """What a parameter that scatters from run to run makes of the size of an effect that does the same: the two can differ in the model's own roughness alone, which is no knowledge."""
    confounded = record_of(effect_of(name)).confounded if is_size(name) else None
    if confounded is None or not evidence.relative:
        return 0.0
    vary = (*evidence.spread, *evidence.varies)
    return max((abs(confounded.size_per_change) * one.std for one in vary if one.title == confounded.parameter), default=0.0)


def _scale_of(name: str, first: float) -> float:
    if name.endswith("phase_rad"):
        return _PHASE_SCALE
    return max(abs(first), 1e-9)


def _ends(name: str, record: Record) -> tuple[float, float]:
    """Where a value may lie: in its range, and a spot of the stroke on what the record moves over, which shows nothing of any other, and no wider than that."""
    row, effect = row_of(name), effect_of(name)
    local = record_of(effect).local if effect not in FAULTS else None
    if local is None or not local.spot or is_size(name):
        return row.lower, row.upper
    low, high = float(np.min(record.command_mm)), float(np.max(record.command_mm))
    if name.endswith(f".{local.spot}"):
        return row.lower, min(max(high - low, 2.0 * row.lower), row.upper)
    return max(low, row.lower), min(high, row.upper)


def _unknown(name: str, first: float, record: Record) -> FreeValue:
    """A value of the fit: a size that ends at none is on no bound, and a phase has none."""
    row, (lower, upper) = row_of(name), _ends(name, record)
    turns = name.endswith("phase_rad")
    walls = (not turns and row.lower != row.nominal, not turns)
    first = min(max(first, lower), upper)
    return FreeValue(name, first, _scale_of(name, first), lower, upper, _AT_BOUND * (upper - lower), walls)


def refit(view: View, start: Mapping[str, float], shape: Mapping[str, float] | None = None) -> Fit:
    """Fits the values named in `start`, those that the view holds among them, beginning there; what scatters stays linear as the view has it.

    `shape` values stay as they are, as do periods per turn, which are whole numbers.
    """
    kept = {name: value for name, value in start.items() if name.endswith(".periods")} | dict(shape or {})
    names = [name for name in start if name not in kept]
    unknowns = [_unknown(name, start[name], view.evidence.record) for name in names]

    def vectors(asked: Sequence[Mapping[str, float]]) -> list[Reals]:
        return _shown(view, [{**changes, **kept} for changes in asked])

    found = bounded.fit(
        unknowns,
        lambda changes: vectors([changes])[0],
        OneSided(_JACOBIAN_STEPS, ROUGHNESS),
        Stop(_RUNS, 1e-4, 1e-5, of_promise=PROMISE),
        view.residual,
        many=vectors,
    )
    values = {**found.values, **kept}
    return Fit(tuple(dict.fromkeys(map(effect_of, names))), values, found.covariance, found.at_bound, view, found.cost)


def slopes(view: View, fit: Fit) -> list[Reals]:
    """What small changes of the fitted values make of the view, vectors [n]: the directions in which they give way to a further effect."""
    return _shown(view, _small_changes(fit))


def shares_left(view: View, fit: Fit) -> list[float]:
    """Of what a small change of each fitted value makes of the view from the fit, in squares, the share that what scatters leaves; none of a value that shows nothing."""
    found = view.sensitivities(_small_changes(fit))
    return [one.square / whole for one in found if not isinstance(one, InputError) and (whole := float(one.vector @ one.vector)) > 0.0]


def _small_changes(fit: Fit) -> list[dict[str, float]]:
    def moved(name: str, row: Row) -> dict[str, float]:
        value = fit.values[name]
        step = _JACOBIAN_STEPS[0] * _scale_of(name, value)
        return {name: value + step if value + step <= row.upper else value - step}

    return [moved(name, row_of(name)) for name in fit.fitted]


def _shown(view: View, asked: Sequence[Mapping[str, float]]) -> list[Reals]:
    """The view's signatures of several changes; nothing where the model refuses one."""
    return [np.zeros_like(view.residual) if isinstance(one, InputError) else one for one in view.signatures(asked)]


def seen_from(fit: Fit) -> View:
    """The evidence with what scatters linear at the fit itself."""
    return settled(fit.view.evidence, fit.values, fit.deviations(), 1)


def polished(fit: Fit, rounds: int) -> Fit:
    """The fit again with what scatters linear at the fit itself, `rounds` times or until the cost stays."""
    for _ in range(rounds):
        again = refit(seen_from(fit), fit.values)
        done = abs(again.cost - fit.cost) < 0.5 + 1e-4 * fit.cost
        fit = again
        if done:
            break
    return fit


def pruned(fit: Fit, effects: Sequence[str], must: Callable[[str, Fit], float], rounds: int = 0) -> Fit:
    """The fit without each of some of its effects whose absence costs less than it `must` take off beside a fit; what is left is polished by so many rounds."""
    current = fit
    for effect in effects:
        without = without_effect(current.values, effect)
        if without:
            smaller = polished(refit(settled(current.view.evidence, without, current.view.deviations, 1), without), rounds)
            if smaller.cost - current.cost < must(effect, current):
                current = smaller
    return current


def worn(view: View) -> Fit | None:
    """CSJ and BLK fitted together, since wear moves both; None where the machine has neither."""
    actuator = view.evidence.actuator
    values = {name: _WORN_START * actuator[name] for name in FAULTS.values() if actuator[name] > 0.0}
    return polished(refit(view, values), 1) if values else None


def fitted_from(evidence: Evidence, start: Mapping[str, float]) -> Fit:
    """The values named in `start` fitted from there, the nuisance parameters linear at the start first and at the fit itself then."""
    return polished(refit(settled(evidence, start, rounds=1), start), POLISHED)


def joint(fit: Fit, rounds: int = _JOINT_ROUNDS) -> Fit:
    """The fit again with what scatters as free unknowns beside the values, by damped Gauss-Newton steps on the model itself.

    Without repeats the scatter is wide, and an effect may do what a parameter of the machine does too (a hot winding, a resistance off its data sheet): then a view that is linear in the
    scatter sees of the effect only how it bends, and the size would stay where the scatter ran into its limit.
    """
    here = fit
    rows = {name: row_of(name) for name in fit.fitted}
    for _ in range(rounds):
        seen = here.view
        columns = seen.free_slopes({name: _around(name, here.values[name], row) for name, row in rows.items()})
        step = np.asarray(np.linalg.lstsq(columns, seen.plain, rcond=None)[0], dtype=float)
        covariance = np.asarray(np.linalg.pinv(columns.T @ columns)[: len(rows), : len(rows)], dtype=float)
        here = replace(here, covariance=covariance)
        before = here.view.plain_cost
        if before - float(np.sum((seen.plain - columns @ step) ** 2)) < _JOINT_DONE:
            break
        own = columns[:, len(rows) : len(rows) + len(seen.evidence.spread)]
        moves = (_joint_move(here, step, own, rows, exact) for exact in (False, True))
        # the cheap move first: where it comes to nothing, the way may bend
        there = next((move for move in moves if move is not None and before - move.view.plain_cost >= _JOINT_DONE), None)
        if there is None:
            break
        here = there
    if here.view is not fit.view:
        # at the edge of what the model takes the directions of the last step stay
        with suppress(InputError):
            here = replace(here, view=here.view.linear_here())
        here = replace(here, cost=here.view.cost)
    return here


def jointly(fit: Fit, rounds: int = _JOINT_ROUNDS) -> Fit:
    """`joint` from the fit's own values."""
    there = seen_from(fit)
    return joint(replace(fit, view=there, cost=there.cost), rounds)


def _around(name: str, value: float, row: Row) -> list[tuple[float, float]]:
    steps = [width * _scale_of(name, value) for width in _JOINT_STEPS]
    return [(max(value - step, row.lower), min(value + step, row.upper)) for step in steps]


def _joint_move(fit: Fit, step: Reals, scatter: Reals, rows: Mapping[str, Row], exact: bool) -> Fit | None:
    """The fit after a share of a step that lowers its cost, what of `spread` scatters moving it there as the columns `scatter` say, or, `exact`, as it does there; None when none does."""
    seen = fit.view
    for share in _JOINT_SHARES:
        values = dict(fit.values)
        for place, name in enumerate(rows):
            values[name] = float(np.clip(values[name] + share * step[place], *_ends(name, seen.evidence.record)))
        try:
            there = seen.at(values, seen.deviations + share * step[len(rows) :], scatter)
            # where an effect and the scatter do the same, the way between them is narrow and bends
            there = there.at(values, (there.linear_here() if exact else there).best_deviations(reach=np.inf), scatter)
        except InputError:
            continue
        if there.plain_cost < seen.plain_cost:
            at_bound = tuple(name for name in rows if _unknown(name, values[name], seen.evidence.record).on_bound(values[name]))
            return replace(fit, values=values, at_bound=at_bound, view=there, cost=there.cost)
    return None


def joined(start: Mapping[str, float], more: Mapping[str, float]) -> dict[str, float]:
    """Values of effects fitted so far and of one more."""
    return {**start, **more}


def without_effect(values: Mapping[str, float], effect: str) -> dict[str, float]:
    """Values of all effects but one."""
    return {name: value for name, value in values.items() if effect_of(name) != effect}


def fits_from(fitted: Callable[[Start], Fit], starts: Iterable[Start]) -> list[Fit]:
    """What is `fitted` from each of several starts, side by side, without those near which the model refuses."""

    def taken(start: Start) -> Fit | None:
        with suppress(InputError):
            return fitted(start)
        return None

    return [fit for fit in each(taken, list(starts)) if fit is not None]


def best_of_each(fits: Sequence[Fit]) -> tuple[Fit, ...]:
    """The best fit of each set of effects, best first."""
    best: dict[frozenset[str], Fit] = {}
    for fit in sorted(fits, key=lambda fit: fit.judged):
        best.setdefault(frozenset(fit.effects), fit)
    return tuple(best.values())
