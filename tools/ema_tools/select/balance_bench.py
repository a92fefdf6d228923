"""Samples of the mechanical balance of one record or of several, divided into parts that are fitted and parts that are held out; and fits of base values and effects on them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from ema_tools.balances.effects import adjusted
from ema_tools.balances.filtering import Smoother
from ema_tools.balances.mechanical import MECHANICAL_PARAMETERS, best_placed, mechanical, quiet_smoother
from ema_tools.base import leastsquares
from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.base.jackknife import LEAST_RECORDS, jackknife_std
from ema_tools.data.actuator import Actuator, row_of
from ema_tools.data.motion_records import AnyRecord
from ema_tools.fit.division import Division, divided
from ema_tools.library.definitions import load_definitions
from ema_tools.library.registry import effect_of_base_value
from ema_tools.library.torques import Shape
from ema_tools.select.balance_setting import LEVEL, VISCOUS, Piece, Setting
from ema_tools.select.fixes import NONE, Fixes
from ema_tools.select.torque_patterns import Pattern, continuous_of, pattern_of

Rows = NDArray[np.bool_]

_REST_SHARE = 0.01  # samples next to a rest, where the filter mixes in so much of it, are not of the sliding balance [judgement]
_DETERMINED = 0.25  # an inertia that is known no better than this share is what the actuator states: data sheets err by less [judgement]
_STEP = 0.05  # of a size that is searched, for its slope [precision]
_ABSENT = 1e-3  # what shows so little of a column, as a share of its length, says nothing of it [precision]
_ON_END = 1e-9  # so near to an end of where it may be, relative, a base value lies on it [precision]
_BARELY = 2.0  # standard errors by which a base value may lie beyond its range and still be inside [chance]
_ALIKE = 0.02  # a base value's torque that is the others' but for so much of its length is not told from them [judgement]
_ROUNDS_OF_SHAPE = 2  # over the values of a shape of several [effort]
_SINGULAR = 1e-12  # columns that differ by less, in squares, are one [precision]
# A constant torque is both a base value and an effect: what has changed of it since the actuator was given is the effect's.
LOAD = "screw.load_torque_Nm"
INERTIA = "screw.inertia_kgm2"
# What is taken as stated where it is one with others, in this order: friction is what a record of any motion shows.
_TAKEN_FIRST = (LOAD, VISCOUS, INERTIA)


# Why a base value is not fitted.
BY_USER, BY_RECORDS = "as fixed", "the records do not determine it"


def load_effect() -> str:
    """The effect that is one with the base value LOAD."""
    return effect_of_base_value(LOAD)


def size_of_load() -> str:
    """The name of its size."""
    return load_definitions().effect(load_effect()).size.name


@dataclass(frozen=True)
class FoldErrors:
    """Relative errors in %: of the parts fitted, of the part held out, and of each part when it is held out and the others are fitted."""

    training: float
    holdout: float
    each: tuple[float, ...]

    @property
    def foretold(self) -> float:
        """Of all parts, each as the others tell it; of those fitted where nothing was held out."""
        told = [one**2 for one in self.each if math.isfinite(one)]
        return math.sqrt(sum(told) / len(told)) if told else self.training

    def foretells_each_better(self, other: FoldErrors) -> bool:
        """Whether every part is told better by the others than those of another model tell it."""
        return all(mine < its for mine, its in zip(self.each, other.each, strict=True) if math.isfinite(its))


@dataclass(frozen=True)
class Samples:
    """A setting on the balance's samples: the motor's torque, the part of it that is fitted, and the columns of the base values, [samples] and [samples, 4]."""

    setting: Setting
    drive: Reals
    target: Reals
    base: Reals


@dataclass(frozen=True)
class Fitted:
    """Base values and patterns fitted to the training laps: the patterns' columns [samples, k], all coefficients [4 + k], values by name and the residual of all samples.

    Standard errors and errors are there after `Bench.judged`.
    """

    samples: Samples
    patterns: tuple[Pattern, ...]
    columns: Reals
    coefficients: Reals
    values: Mapping[str, float]
    residual: Reals
    std: Mapping[str, float] = field(default_factory=dict)
    errors: FoldErrors = field(default_factory=lambda: FoldErrors(math.nan, math.nan, ()))

    def square(self, rows: Rows) -> float:
        """Mean squared residual of some samples."""
        return float(np.mean(self.residual[rows] ** 2))

    @property
    def matrix(self) -> Reals:
        """Columns of base values and patterns, [samples, 4 + k]."""
        return np.column_stack([self.samples.base, self.columns])


class Bench:
    """The records' samples, one record after another, which of them are fitted and held out, and fits on them.

    `fixes`: base values that are kept or bounded; `whole`: all is fitted but what the user held out, no part of the rest is left for a check.
    """

    def __init__(
        self,
        actuator: Actuator,
        records: Sequence[AnyRecord],
        holdout: Sequence[AnyRecord] = (),
        fixes: Fixes = NONE,
        whole: bool = False,
    ) -> None:
        self.smoothers: tuple[Smoother, ...] = tuple(quiet_smoother(actuator, record) for record in (*records, *holdout))
        # waves that the model has already are where the record fits them best, if nobody knows where it begins
        self.records: tuple[AnyRecord, ...] = tuple(
            best_placed(actuator, record, smoother) for record, smoother in zip((*records, *holdout), self.smoothers, strict=True)
        )
        self.fixes = fixes
        self.division: Division = divided(records, holdout)
        start = Setting.of(actuator, self.records, self.smoothers)
        # rest is not tested: friction answers whatever there is
        resting = self.decimated(start.joined(lambda piece: piece.model.still.astype(np.float64))[:, None])[:, 0]
        self.sliding: Rows = np.abs(resting) < _REST_SHARE
        self.fold = self.kept(np.concatenate(self.division.fold))
        last = self.fold == self.division.folds - 1
        self.held: Rows = self.sliding & last
        self.training: Rows = self.sliding & ~last
        if whole and not self.division.apart:
            self.training = self.sliding
        if not self.training.any():
            raise InputError(f"{records[0].file}: the machine rests in all that would be fitted: record longer, or while it moves")
        # what the user held out is never fitted
        self.fitted: Rows = self.training if self.division.apart else self.sliding
        # base values that are kept, or that the records do not determine, by their place: the value that is taken
        self.taken: dict[int, float] = {MECHANICAL_PARAMETERS.index(name): actuator[name] for name in fixes.as_stated}
        self.between = {MECHANICAL_PARAMETERS.index(name): ends for name, ends in fixes.between.items()}
        self.start = self.sampled(start)
        self.load_named = False
        self._bent: dict[tuple[tuple[str, float], ...], Samples] = {}

    def by_record(self, values: NDArray[Any]) -> list[NDArray[Any]]:
        """Rows of all records [rows, ...], divided by record."""
        return np.split(values, np.cumsum([record.rows for record in self.records])[:-1])

    def decimated(self, columns: Reals) -> Reals:
        """Columns [rows, k] on the samples, [samples, k]."""
        if not columns.shape[1]:
            return np.zeros((self.fold.size, 0))
        return np.concatenate([smoother.decimated(part) for smoother, part in zip(self.smoothers, self.by_record(columns), strict=True)])

    def kept(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values [rows] at the samples, not filtered, [samples]."""
        return np.concatenate([smoother.kept(part) for smoother, part in zip(self.smoothers, self.by_record(values), strict=True)])

    @property
    def of_record(self) -> NDArray[np.int64]:
        """The record of every sample, [samples]."""
        return self.kept(np.concatenate([np.full(record.rows, number) for number, record in enumerate(self.records)]))

    def motion(self, setting: Setting, of_piece: Callable[[Piece], Reals]) -> Reals:
        """A column of the pieces at the samples, [samples]."""
        return self.kept(setting.joined(of_piece))

    def sampled(self, setting: Setting) -> Samples:
        """A setting on the samples."""
        drive = setting.drive_Nm
        target = setting.joined(lambda piece: piece.model.drive_Nm - piece.model.load_Nm - piece.model.added_Nm)
        base = np.concatenate([piece.model.columns for piece in setting.pieces])
        return self._as_stated(Samples(setting, *self._split(self.decimated(np.column_stack([drive, target, base])))))

    @staticmethod
    def _split(columns: Reals) -> tuple[Reals, Reals, Reals]:
        return columns[:, 0], columns[:, 1], columns[:, 2:]

    def _as_stated(self, samples: Samples) -> Samples:
        """The samples with the base values that are not fitted at work in the target, their columns empty."""
        if not self.taken:
            return samples
        target, base = samples.target.copy(), samples.base.copy()
        for place, value in self.taken.items():
            target -= _coefficient(samples.setting, place, value) * base[:, place]
            base[:, place] = 0.0
        return replace(samples, target=target, base=base)

    def taken_coefficients(self, setting: Setting) -> Reals:
        """Coefficients of the base values that are not fitted, zero for the others, [4]."""
        found = np.zeros(len(MECHANICAL_PARAMETERS))
        for place, value in self.taken.items():
            found[place] = _coefficient(setting, place, value)
        return found

    def _ends(self, setting: Setting) -> dict[int, tuple[float, float]]:
        """Least and largest coefficient of the base values that are bounded, by their place."""
        return {
            place: (_coefficient(setting, place, low), _coefficient(setting, place, high))
            for place, (low, high) in self.between.items()
            if place not in self.taken
        }

    def _solved(self, setting: Setting, matrix: Reals, target: Reals, whole: Reals | None = None) -> Reals:
        """Least squares as `solved` has it, with the base values between their ends, [k]: of every way to put them onto their ends the best that is allowed."""
        found = solved(matrix, target, whole)
        ends = self._ends(setting)
        if all(low <= found[place] <= high for place, (low, high) in ends.items()):
            return found
        best, least = found, math.inf
        for chosen in itertools.product(*((None, low, high) for low, high in ends.values())):
            at = {place: end for place, end in zip(ends, chosen, strict=True) if end is not None}
            if not at:
                continue
            places = list(at)
            free = matrix.copy()
            free[:, places] = 0.0
            rest = target - matrix[:, places] @ np.array(list(at.values()))
            tried = solved(free, rest, whole)
            tried[places] = list(at.values())
            if all(low <= tried[place] <= high for place, (low, high) in ends.items()):
                square = float(np.sum((target - matrix @ tried) ** 2))
                if square < least:
                    best, least = tried, square
        return best

    def at_ends(self, fit: Fitted) -> tuple[str, ...]:
        """Names of the base values that lie on an end of where they may be."""
        return tuple(
            MECHANICAL_PARAMETERS[place]
            for place, ends in self._ends(fit.samples.setting).items()
            if any(math.isclose(float(fit.coefficients[place]), end, rel_tol=_ON_END) for end in ends)
        )

    def pushed_to_ends(self, fit: Fitted) -> tuple[str, ...]:
        """Those of them that would lie beyond it by more than their error if they could; an inertia that is held near what is stated lies there by more than data sheets err anyhow."""
        held = self.at_ends(fit)
        if not held:
            return ()
        between, self.between = self.between, {}
        free = self.fit(fit.samples, fit.patterns, fit.columns)
        std = self._std(free)
        self.between = between
        return tuple(name for name in held if name == INERTIA or abs(free.values[name] - fit.values[name]) > _BARELY * std.get(name, 0.0))

    @property
    def kept_because(self) -> dict[str, str]:
        """Base values that are taken and not fitted, and why."""
        return {
            MECHANICAL_PARAMETERS[place]: BY_USER if MECHANICAL_PARAMETERS[place] in self.fixes.kept else BY_RECORDS for place in self.taken
        }

    def keep_undetermined(self) -> tuple[str, ...]:
        """Takes an inertia as stated that the records do not determine, and a base value whose torque is the others': a load where the machine moves one way only, viscous friction
        where it keeps one speed. Another base value that the records put beyond its range stays inside from here on: an effect that is not yet known may be what pushes it there.
        The names of what was taken.
        """
        for name in _TAKEN_FIRST:
            place = MECHANICAL_PARAMETERS.index(name)
            base = self.start.base[self.training]
            column, others = base[:, place], np.delete(base, place, axis=1)
            left = float(np.linalg.norm(column - others @ solved(others, column)))
            if place not in self.taken and left < _ALIKE * float(np.linalg.norm(column)):
                self.taken[place] = float(np.clip(self.start.setting.actuator[name], *self.between.get(place, (-math.inf, math.inf))))
                self.start = self._as_stated(self.start)
                self._bent.clear()
        while True:
            fit = self.fit(self.start, (), np.zeros((self.fold.size, 0)))
            std = self._std(fit)
            found = [
                place
                for place, name in enumerate(MECHANICAL_PARAMETERS)
                if place not in self.taken
                and name != LOAD
                # what is held inside its range is where it may be, whatever rounding makes of its end
                and (name == INERTIA or place not in self.between)
                and _not_determined(name, fit.values[name], std.get(name, math.inf))
            ]
            if not found:
                return tuple(MECHANICAL_PARAMETERS[place] for place in self.taken)
            # the least determined first: the others may be right without it
            place = max(found, key=lambda place: std.get(MECHANICAL_PARAMETERS[place], math.inf) / _reach(fit, place))
            name, row = MECHANICAL_PARAMETERS[place], row_of(MECHANICAL_PARAMETERS[place])
            if name == INERTIA:
                low, high = self.between.get(place, (row.lower, row.upper))
                self.taken[place] = float(np.clip(self.start.setting.actuator[name], low, high))
                self.start = self._as_stated(self.start)
            else:
                self.between[place] = (row.lower, row.upper)
            self._bent.clear()

    def keep_inertia(self) -> None:
        """Where the records put the inertia as near as data sheets err to what the actuator states, it stays as near beside every effect: one that moves it further stands in for it."""
        self._keep_near_stated(self.fit(self.start, (), np.zeros((self.fold.size, 0))))

    def _keep_near_stated(self, fit: Fitted) -> None:
        place = MECHANICAL_PARAMETERS.index(INERTIA)
        stated = self.start.setting.actuator[INERTIA]
        if (
            place not in self.taken
            and place not in self.between
            and stated > 0.0
            and abs(fit.values[INERTIA] / stated - 1.0) <= _DETERMINED
        ):
            self.between[place] = ((1.0 - _DETERMINED) * stated, (1.0 + _DETERMINED) * stated)

    def release_inertia(self, patterns: Sequence[Pattern], columns: Reals) -> bool:
        """Fits an inertia again that was taken as stated, where the records determine it beside effects with their columns [samples, k]: a weight that nobody knew hid it. Whether they do."""
        place = MECHANICAL_PARAMETERS.index(INERTIA)
        if place not in self.taken or INERTIA in self.fixes.as_stated:
            return False
        stated, start = self.taken.pop(place), self.start
        self.start = self.sampled(start.setting)
        fit = self.fit(self.with_bends(patterns), patterns, columns)
        if _not_determined(INERTIA, fit.values[INERTIA], self._std(fit).get(INERTIA, math.inf)):
            self.taken[place], self.start = stated, start
            return False
        self._bent.clear()
        self._keep_near_stated(fit)
        return True

    def carry(self, torques: Reals) -> None:
        """Counts torques [rows, k] from here on as what the machine carries beside its actuator."""
        self.start = replace(self.start, setting=replace(self.start.setting, carried=torques if torques.shape[1] else None))
        self._bent.clear()

    def keep_barely_outside(self, fit: Fitted) -> bool:
        """Keeps inside its range from here on every base value that a judged fit puts beyond it by no more than its error: that is nothing impossible. Whether there was one."""
        found = False
        for place, name in enumerate(MECHANICAL_PARAMETERS):
            row, value, std = row_of(name), fit.values[name], fit.std.get(name, 0.0)
            beyond = max(row.lower - value, value - row.upper)
            if place not in self.taken and place not in self.between and 0.0 < beyond <= _BARELY * std:
                self.between[place] = (row.lower, row.upper)
                self._bent.clear()
                found = True
        return found

    def stay_in_ranges(self) -> None:
        """From here on every base value that is fitted stays between the ends of its range."""
        for place, name in enumerate(MECHANICAL_PARAMETERS):
            row = row_of(name)
            self.between.setdefault(place, (row.lower, row.upper))

    def changed(self, changes: Mapping[str, float]) -> Samples:
        """The start with some values changed."""
        setting = self.start.setting
        return self.sampled(setting.with_actuator(setting.actuator.changed(changes))) if changes else self.start

    def with_bends(self, patterns: Sequence[Pattern]) -> Samples:
        """The samples with the effects at work that change the balance itself."""
        return self.changed({name: value for pattern in patterns if pattern.bends for name, value in pattern.shape.items()})

    def error_of(self, residual: Reals, drive: Reals, rows: Rows) -> float:
        """Relative error of some samples, %; NaN where nothing slides there, or nothing drives."""
        size = float(np.linalg.norm(drive[rows]))
        return 100.0 * float(np.linalg.norm(residual[rows])) / size if size > 0.0 else math.nan

    def fit(self, samples: Samples, patterns: Sequence[Pattern], columns: Reals) -> Fitted:
        """Base values and patterns with their columns [samples, k], fitted to the training laps."""
        matrix = np.column_stack([samples.base, columns])
        coefficients = self._solved(samples.setting, matrix[self.training], samples.target[self.training])
        values = self.values_of(samples.setting, patterns, coefficients)
        return Fitted(samples, tuple(patterns), columns, coefficients, values, samples.target - matrix @ coefficients)

    def values_of(self, setting: Setting, patterns: Sequence[Pattern], coefficients: Reals) -> dict[str, float]:
        """Values by name for coefficients [4 + k], the constant torque where it belongs."""
        found = values_of(setting, patterns, coefficients)
        found |= {MECHANICAL_PARAMETERS[place]: value for place, value in self.taken.items()}
        if self.load_named:
            known = self.start.setting.actuator[LOAD]
            found[size_of_load()], found[LOAD] = found[LOAD] - known, known
        return found

    def without_load(self) -> Fitted:
        """The base values with the constant torque left as it was given."""
        start, known = self.start, adjusted(self.start.setting.actuator)[LOAD]
        base = start.base * (1.0, 1.0, 1.0, 0.0)
        fit = self.fit(
            Samples(start.setting, start.drive, start.target - known * start.base[:, 3], base), (), np.zeros((self.fold.size, 0))
        )
        return replace(fit, values={**fit.values, LOAD: start.setting.actuator[LOAD]})

    def error_with(self, fit: Fitted, name: str, value: float) -> float:
        """Relative error of the parts fitted, %, when one base value is taken for `value` and all else is fitted anew."""
        samples, place = fit.samples, MECHANICAL_PARAMETERS.index(name)
        target = samples.target - _coefficient(samples.setting, place, value) * samples.base[:, place]
        base = samples.base.copy()
        base[:, place] = 0.0
        held = self.fit(replace(samples, target=target, base=base), fit.patterns, fit.columns)
        return self.error_of(held.residual, samples.drive, self.training)

    def with_load_as_given(self, fit: Fitted) -> Fitted:
        """A fit with the constant torque left as it was given."""
        samples, known = fit.samples, adjusted(self.start.setting.actuator)[LOAD]
        held = replace(samples, target=samples.target - known * samples.base[:, 3], base=samples.base * (1.0, 1.0, 1.0, 0.0))
        return self.fit(held, fit.patterns, fit.columns)

    def judged(self, fit: Fitted) -> Fitted:
        """The fit with errors and standard errors."""
        return replace(fit, errors=self._errors(fit), std=self._std(fit))

    def held_out(self, fit: Fitted) -> Reals:
        """The residual of every part when the others are fitted, [samples]."""
        matrix, target = fit.matrix, fit.samples.target
        found = np.zeros_like(target)
        for part in range(self.division.folds):
            here = self.fold == part
            rest = self.fitted & ~here
            found[here] = target[here] - matrix[here] @ self._solved(fit.samples.setting, matrix[rest], target[rest], matrix)
        return found

    def foretold(self, fit: Fitted, fitted: Rows, told: Rows) -> float:
        """Relative error of some samples when the effects' coefficients come from others, %.

        The base values are those of the samples themselves: what is asked is whether the effects are the same there, not whether friction goes on as a straight line.
        """
        base, target = fit.samples.base, fit.samples.target
        effects = self._solved(fit.samples.setting, fit.matrix[fitted], target[fitted], fit.matrix)[base.shape[1] :]
        left = target[told] - fit.columns[told] @ effects
        left = left - base[told] @ solved(base[told], left)
        return 100.0 * float(np.linalg.norm(left)) / float(np.linalg.norm(fit.samples.drive[told]))

    def foretold_part(self, fit: Fitted, part: int) -> float:
        """Relative error of a part when the effects' coefficients come from the others, %."""
        here = self.fold == part
        return self.foretold(fit, self.fitted & ~here, self.sliding & here)

    def seen_share(self, fit: Fitted, rows: Rows) -> float:
        """How much of the last effect beside the base values these samples show, as a share of the squares of all; 1 for one whose size is not solved for."""
        width = fit.patterns[-1].columns.shape[1] if fit.patterns else 0
        if not width:
            return 1.0
        shown = []
        for here in (rows, self.fitted):
            columns, base = fit.columns[here, -width:], fit.samples.base[here]
            shown.append(sum(float(np.sum((column - base @ solved(base, column)) ** 2)) for column in columns.T))
        return shown[0] / shown[1] if shown[1] > 0.0 else 0.0

    def _errors(self, fit: Fitted) -> FoldErrors:
        drive, held_out = fit.samples.drive, self.held_out(fit)
        each = tuple(self.error_of(held_out, drive, self.sliding & (self.fold == part)) for part in range(self.division.folds))
        return FoldErrors(self.error_of(fit.residual, drive, self.training), self.error_of(fit.residual, drive, self.held), each)

    def stated(self, fit: Fitted) -> Fitted:
        """The fit with standard errors as they are told to people: shapes were fitted too, and a size that hangs on one is no better known than it is; and no value is better known than
        records show it that are left out in turn, since friction itself differs from one to the next."""
        std, apart = self._std(fit, self._shape_slopes(fit)), self.std_of_records(fit)
        return replace(fit, std={name: max(one, apart.get(name, 0.0)) for name, one in std.items()})

    def std_of_records(self, fit: Fitted) -> dict[str, float]:
        """Standard errors by leaving out one record after another (the jackknife); none of fewer than three. Shapes stay."""
        numbers = np.unique(self.of_record[self.fitted])
        if numbers.size < LEAST_RECORDS:
            return {}
        matrix, target, setting = fit.matrix, fit.samples.target, fit.samples.setting
        told: list[dict[str, float]] = []
        for number in numbers:
            rest = self.fitted & (self.of_record != number)
            coefficients = self._solved(setting, matrix[rest], target[rest], matrix)
            told.append(self.values_of(setting, fit.patterns, coefficients))
        return {name: float(jackknife_std([one[name] for one in told])) for name in told[0]}

    def _shape_slopes(self, fit: Fitted) -> dict[str, Reals]:
        """How the fitted torque moves with each shape parameter that lies between those tried, [samples] per unit of it."""
        found: dict[str, Reals] = {}
        setting, first = fit.samples.setting, fit.samples.base.shape[1]
        width = 0
        for pattern in fit.patterns:
            place, width = first + width, width + pattern.columns.shape[1]
            coefficients = fit.coefficients[place : first + width]
            for name in (name for name in continuous_of(pattern.effect) if coefficients.size and name in pattern.shape):
                value, row = pattern.shape[name], row_of(name)
                ends = [float(np.clip(value * (1.0 + sign * _STEP), row.lower, row.upper)) for sign in (-1.0, 1.0)]
                sides = [pattern_of(setting, pattern.effect, {**pattern.shape, name: end}) for end in ends]
                columns = [self.decimated(side.columns) for side in sides if not isinstance(side, str)]
                if len(columns) == len(ends) and ends[1] > ends[0]:
                    found[name] = (columns[1] - columns[0]) @ coefficients / (ends[1] - ends[0])
        return found

    def _std(self, fit: Fitted, shapes: Mapping[str, Reals] | None = None) -> dict[str, float]:
        """Standard errors of the values, jointly; sizes that are searched are taken as linear where they are, and so are `shapes` by their slopes [samples]."""
        values, shapes = fit.values, shapes or {}
        bends = [name for pattern in fit.patterns if pattern.bends for name in pattern.shape]
        held = {name: values[name] for name in bends}
        slopes = []
        for name in bends:
            row = row_of(name)
            ends = tuple(float(np.clip(values[name] * (1.0 + sign * _STEP), row.lower, row.upper)) for sign in (-1.0, 1.0))
            low, high = (self.changed({**held, name: end}) for end in ends)
            slopes.append(((high.base - low.base) @ fit.coefficients[:4] - (high.target - low.target)) / (ends[1] - ends[0]))
        matrix = np.column_stack([fit.matrix, *slopes, *shapes.values()])[self.training]
        # a value on its end does not move
        matrix[:, [MECHANICAL_PARAMETERS.index(name) for name in self.at_ends(fit)]] = 0.0
        covariance = _covariance(matrix, fit.residual[self.training], self.of_record[self.training])
        moving = [*bends, *shapes]
        point = np.concatenate([fit.coefficients, [values[name] for name in moving]])

        def at(moved: Reals) -> Reals:
            found = self.values_of(fit.samples.setting, fit.patterns, moved[: fit.coefficients.size])
            found |= dict(zip(moving, moved[fit.coefficients.size :].tolist(), strict=True))
            return np.array([found[name] for name in values])

        steps = np.maximum(1e-3 * np.sqrt(np.maximum(np.diag(covariance), 0.0)), 1e-12 * np.maximum(np.abs(point), 1e-12))
        # a share of nothing is no size, and has no error
        with np.errstate(invalid="ignore"):
            slope = np.column_stack(
                [
                    (at(point + step * unit) - at(point - step * unit)) / (2.0 * step)
                    for step, unit in zip(steps, np.eye(point.size), strict=True)
                ]
            )
        spread = np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", slope, covariance, slope), 0.0))
        # what stands still is a shape that was chosen from a few
        return {name: float(value) for name, value in zip(values, spread, strict=True) if value > 0.0}

    def searched(self, accepted: Fitted, effect: str, known: Sequence[Pattern]) -> Fitted:
        """The best shape of an effect that changes the balance itself, beside what was accepted: of those given, then, value by value, between the neighbours of the best."""

        def at(shape: Shape, samples: Samples | None = None) -> Fitted:
            patterns = (*accepted.patterns, replace(known[0], shape=shape))
            return self.fit(samples or self.with_bends(patterns), patterns, accepted.columns)

        begun = tuple(sorted(one for pattern in accepted.patterns if pattern.bends for one in pattern.shape.items()))
        fits = []
        for pattern in known:
            changes = (*begun, *pattern.shape.items())
            if changes not in self._bent:
                self._bent[changes] = self.changed(dict(changes))
            fits.append(at(pattern.shape, self._bent[changes]))
        first = min(range(len(fits)), key=lambda k: fits[k].square(self.training))
        best, shape = fits[first], known[first].shape
        for name in list(shape) * (1 if len(shape) == 1 else _ROUNDS_OF_SHAPE):
            sizes = sorted({pattern.shape[name] for pattern in known})
            row, place = row_of(name), sizes.index(known[first].shape[name])
            ends = (
                sizes[place - 1] if place else max(row.lower, 1e-3 * sizes[0]),
                sizes[place + 1] if place + 1 < len(sizes) else row.upper,
            )
            moved = _moved(at, shape, name, ends, 5e-3 * sizes[place], self.training)
            if moved.square(self.training) < best.square(self.training):
                best, shape = moved, moved.patterns[-1].shape
        return best


def _moved(
    at: Callable[[Shape], Fitted], shape: Shape, name: str, ends: tuple[float, float], near: float, rows: NDArray[np.bool_]
) -> Fitted:
    """The fit with one value of a shape where it is best between two ends, to `near`."""

    def square(value: float) -> float:
        return at({**shape, name: float(value)}).square(rows)

    found = minimize_scalar(square, bounds=ends, method="bounded", options={"xatol": near})
    return at({**shape, name: float(found.x)})


def _coefficient(setting: Setting, place: int, value: float) -> float:
    """The coefficient of a base value's column where the actuator states this value."""
    name = MECHANICAL_PARAMETERS[place]
    here = adjusted(setting.actuator.changed({name: value}))
    return here[name] * (here["screw.dynamic_ratio"] if name == LEVEL else 1.0)


def _not_determined(name: str, value: float, std: float) -> bool:
    row = row_of(name)
    return not row.lower <= value <= row.upper or (name == INERTIA and std > _DETERMINED * abs(value))


def _reach(fit: Fitted, place: int) -> float:
    """What a base value is measured by: what the actuator states."""
    return abs(fit.samples.setting.actuator[MECHANICAL_PARAMETERS[place]]) or 1.0


def solved(matrix: Reals, target: Reals, whole: Reals | None = None) -> Reals:
    """Least squares with columns [samples, k] brought to one scale, [k]; zero for a column without content, or with next to none of what it has in `whole` [all samples, k]."""
    scale = _scale_of(matrix)
    if whole is not None:
        seen = np.linalg.norm(matrix, axis=0) > _ABSENT * np.linalg.norm(whole, axis=0)
        matrix = matrix * seen
    scaled = matrix / scale
    return np.asarray(np.linalg.pinv(scaled.T @ scaled, rcond=_SINGULAR, hermitian=True) @ (scaled.T @ target) / scale)


def _scale_of(matrix: Reals) -> Reals:
    """Lengths of the columns, [k]; one for a column without content."""
    scale = np.linalg.norm(matrix, axis=0)
    return np.where(scale > 0.0, scale, 1.0)


def values_of(setting: Setting, patterns: Sequence[Pattern], coefficients: Reals) -> dict[str, float]:
    """Base and effects' values by name for coefficients [4 + k]."""
    actuator = setting.actuator
    here = adjusted(actuator)
    effective = dict(
        zip(MECHANICAL_PARAMETERS, (coefficients[:4] / (1.0, 1.0, here["screw.dynamic_ratio"] or 1.0, 1.0)).tolist(), strict=True)
    )
    found = {}
    for name, value in effective.items():
        # effects on parameters are linear
        step = max(abs(actuator[name]), 1e-6)
        slope = (adjusted(actuator.changed({name: actuator[name] + step}))[name] - here[name]) / step
        found[name] = actuator[name] + (value - here[name]) / slope
    levels = {**effective, LEVEL: float(coefficients[2])}
    place = 4
    for pattern in patterns:
        width = pattern.columns.shape[1]
        found |= pattern.values(coefficients[place : place + width], levels)
        place += width
    return found


def _covariance(columns: Reals, residual: Reals, of_record: NDArray[np.int64]) -> Reals:
    """Covariance of the coefficients for a residual whose neighbours in one record are alike, [k, k]."""
    scale = _scale_of(columns)
    scaled = columns / scale
    inverse = np.linalg.pinv(scaled.T @ scaled, rcond=_SINGULAR, hermitian=True)
    scores = scaled * residual[:, None]
    total = sum(leastsquares.long_run(scores[of_record == number]) for number in np.unique(of_record))
    return np.asarray(inverse @ total @ inverse / np.outer(scale, scale))


def floor_of(bench: Bench, fit: Fitted) -> float:
    """How far one complete lap is from the others in what a fit leaves of the torque where it slides, as relative error in %: no model of a lap can beat it. NaN where no record repeats itself.

    Laps are never the same motion, and friction answers at rest whatever there is: neither is chance, and with either the floor would be one of the model, and no property of the records.
    """
    squares = total = 0.0
    for number, (laps, smoother) in enumerate(zip(bench.division.laps, bench.smoothers, strict=True)):
        here = bench.of_record == number
        moved = fit.samples.base[here]
        found = _scatter_of_laps(fit.residual[here], fit.samples.drive[here], moved, bench.sliding[here], laps.period_rows / smoother.every)
        if found is not None:
            squares, total = squares + found[0], total + found[1]
    return 100.0 * math.sqrt(squares / total) if total > 0.0 else math.nan


def _scatter_of_laps(residual: Reals, drive: Reals, moved: Reals, sliding: Rows, period: float) -> tuple[float, float] | None:
    """Squared distance of the laps of one record from their mean, `period` samples each, and the square of the drive, where all laps slide; None where no lap is repeated, or none slides.

    What the laps' motions differ by, in the columns of the base values [samples, 4], is left out.
    """
    count = int(residual.size / period) if period else 0
    if count < 2:
        return None
    # laps need not be a whole number of samples long
    places = np.arange(int(period))

    def of_laps(values: Reals) -> Reals:
        return np.array([np.interp(places + lap * period, np.arange(values.size), values) for lap in range(count)])

    slides = np.all(of_laps(sliding.astype(np.float64)) >= 1.0, axis=0)
    if not slides.any():
        return None
    left, of_drive, *columns = (of_laps(values)[:, slides] for values in (residual, drive, *moved.T))
    apart, *others = ((one - one.mean(axis=0)).ravel() for one in (left, *columns))
    differ = np.column_stack(others)
    apart = apart - differ @ solved(differ, apart)
    return count / (count - 1.0) * float(np.sum(apart**2)), float(np.sum(of_drive**2))


def given_errors(actuator: Actuator, bench: Bench) -> FoldErrors:
    """Errors of the actuator as it was given, from the balance as `ema compare` draws it."""
    found = [mechanical(actuator, record, smoother) for record, smoother in zip(bench.records, bench.smoothers, strict=True)]
    residual, measured = (np.concatenate([getattr(one, name) for one in found]) for name in ("residual", "measured"))
    parts = [bench.fold == part for part in range(bench.division.folds)]
    *training, held = (bench.error_of(residual, measured, part) for part in parts)
    return FoldErrors(bench.error_of(residual, measured, ~parts[-1]), held, (*training, held))


def compared_percent(actuator: Actuator, records: Sequence[AnyRecord]) -> float:
    """Relative error in % of all rows of the records together, as `ema compare` has it of each."""
    found = [mechanical(actuator, record) for record in records]
    residual, measured = (math.sqrt(sum(float(np.sum(getattr(one, name) ** 2)) for one in found)) for name in ("residual", "measured"))
    return 100.0 * residual / measured if measured > 0.0 else math.nan
