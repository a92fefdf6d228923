"""What a model lacks, named by the mechanical balance alone: for a record without healthy repeats, in a loop so stiff that the position hardly shows the mechanics.

The motor's torque is linear in the base values and in the sizes of most effects, so that every effect of the library, in every shape, is fitted together with the base values in a
moment. Greedy: the effect that lowers the error of the fitted laps most joins, if the laps that were held out confirm it; the rest is tried again beside it; what has become needless is
dropped. Standard errors hold for a residual that is missing model rather than noise, which repeats from lap to lap (`ema_tools.base.leastsquares`).

All errors are relative: 100 * norm of the balance's residual over norm of the motor's torque. The floor is how far the torque of one lap is from that of the others.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize, minimize_scalar

from ema_tools.balances.effects import adjusted
from ema_tools.balances.filtering import Smoother
from ema_tools.balances.mechanical import MECHANICAL_PARAMETERS, mechanical, quiet_smoother
from ema_tools.base import leastsquares
from ema_tools.base.arrays import Reals
from ema_tools.base.progress import Report, untold
from ema_tools.data.actuator import Actuator, row_of
from ema_tools.data.records import Record
from ema_tools.fit.laps import Laps, laps_of
from ema_tools.library.definitions import load_definitions
from ema_tools.library.registry import effect_of_base_value
from ema_tools.library.torques import Shape
from ema_tools.select.torque_patterns import LEVEL, NOT_HERE, Pattern, Setting, continuous_of, pattern_of, patterns_of

Rows = NDArray[np.bool_]

EFFECTS_MAX = 8  # more at once are not believed from one record [judgement]
MANY = f"{EFFECTS_MAX} effects have been added: confirm them on another record before adding more"
SIZE_IN_STD = 3.0  # an effect must show a size of so many standard errors ... [chance]
FALL_IN_STD = 2.5  # ... a fall of the held-out squared error of so many of its own ... [chance]
LEAST_SHARE = 0.03  # ... that takes off this share of the squared error above the floor ... [judgement]
# ... and of that of the refitted base values: products of large effects look like small effects of their own [judgement]
LEAST_OF_FIRST = 0.005
WORSE_ELSEWHERE = 1.01  # by how much it may raise the error at places and speeds to which nothing was fitted [judgement]
_OWN = 1e-3  # a column is the base values' own when they leave less than this of it [precision]
_SHAPE_SHARE = 0.02  # a shape that explains less than this share of the best one's is no shape of the effect [judgement]
_ROUND_SHARE = 0.15  # of the bar that shows how far it is, for one effect [layout]
_CLASS_GAIN = 0.8  # effects that lower the fitted error by nearly as much as the best ... [judgement]
_CLASS_COSINE = 0.8  # ... and look like it, are its class [judgement]
_REST_SHARE = 0.01  # samples next to a rest, where the filter mixes in so much of it, are not of the sliding balance [judgement]
_BOUND = 1e-6  # so near to an end of its range, relative, a value lies on it [precision]
_MOST_FLOOR = 0.9  # of the error: a floor beyond it would make any gain look like all there is [judgement]
_SINGULAR = 1e-12  # columns that differ by less, in squares, are one [precision]
# A constant torque is both a base value and an effect: what has changed of it since the actuator was given is the effect's.
LOAD = "screw.load_torque_Nm"


def load_effect() -> str:
    """The effect that is one with the base value LOAD."""
    return effect_of_base_value(LOAD)


def _size_of_load() -> str:
    return load_definitions().effect(load_effect()).size.name


@dataclass(frozen=True)
class FoldErrors:
    """Relative errors in %: of the laps fitted, of the laps held out, and of each part when it is held out and the others are fitted."""

    training: float
    holdout: float
    each: tuple[float, ...]


@dataclass(frozen=True)
class ForceStep:
    """One step: the effect added, with its values and those of the base refitted beside it, their standard errors, what looks alike, and the errors after it."""

    effect: str
    values: Mapping[str, float]
    std: Mapping[str, float]
    alike: tuple[str, ...]
    errors: FoldErrors
    elsewhere: Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class Refusal:
    """An effect that was not added, why, and its values and errors beside the accepted ones where it could be fitted."""

    effect: str
    reason: str
    values: Mapping[str, float] = field(default_factory=dict)
    std: Mapping[str, float] = field(default_factory=dict)
    errors: FoldErrors | None = None


@dataclass(frozen=True)
class ForceSteps:
    """The whole answer: the actuator with everything that was accepted, the errors of the given model and of its refitted base values, the steps, what was refused, the floor in %
    and how the record was divided. `curves` are the torque and the residuals before and after, [samples], for a picture."""

    actuator: Actuator
    given: FoldErrors
    refitted: FoldErrors
    steps: tuple[ForceStep, ...]
    refused: tuple[Refusal, ...]
    floor_percent: float
    laps: Laps
    period_s: float
    curves: Mapping[str, Reals]


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
    """One record's samples, which of them are fitted and held out, and fits on them."""

    def __init__(self, actuator: Actuator, record: Record) -> None:
        self.record = record
        self.smoother: Smoother = quiet_smoother(actuator, record)
        self.laps = laps_of(record)
        start = Setting.of(actuator, record, self.smoother)
        # rest is not tested: friction answers whatever there is
        resting = self.smoother.decimated(start.model.resting.astype(np.float64))
        self.sliding: Rows = np.abs(resting) < _REST_SHARE
        self.fold = self.smoother.kept(self.laps.fold)
        self.held: Rows = self.sliding & (self.fold == self.laps.folds - 1)
        self.training: Rows = self.sliding & ~self.held
        self.start = self.sampled(start)
        self.load_named = False
        self._bent: dict[tuple[tuple[str, float], ...], Samples] = {}

    def decimated(self, columns: Reals) -> Reals:
        """Columns [rows, k] on the samples, [samples, k]."""
        return (
            np.column_stack([self.smoother.decimated(column) for column in columns.T])
            if columns.shape[1]
            else np.zeros((self.fold.size, 0))
        )

    def sampled(self, setting: Setting) -> Samples:
        """A setting on the samples."""
        model, decimated = setting.model, self.smoother.decimated
        return Samples(
            setting, decimated(model.drive_Nm), decimated(model.drive_Nm - model.load_Nm - model.added_Nm), self.decimated(model.columns)
        )

    def changed(self, changes: Mapping[str, float]) -> Samples:
        """The start with some values changed."""
        return self.sampled(Setting.of(self.start.setting.actuator.changed(changes), self.record, self.smoother)) if changes else self.start

    def with_bends(self, patterns: Sequence[Pattern]) -> Samples:
        """The samples with the effects at work that change the balance itself."""
        return self.changed({name: value for pattern in patterns if pattern.bends for name, value in pattern.shape.items()})

    def relative(self, residual: Reals, drive: Reals, rows: Rows) -> float:
        """Relative error of some samples, %."""
        return 100.0 * float(np.linalg.norm(residual[rows])) / float(np.linalg.norm(drive[rows]))

    def fit(self, samples: Samples, patterns: Sequence[Pattern], columns: Reals) -> Fitted:
        """Base values and patterns with their columns [samples, k], fitted to the training laps."""
        matrix = np.column_stack([samples.base, columns])
        coefficients = solved(matrix[self.training], samples.target[self.training])
        values = self.values_of(samples.setting, patterns, coefficients)
        return Fitted(samples, tuple(patterns), columns, coefficients, values, samples.target - matrix @ coefficients)

    def values_of(self, setting: Setting, patterns: Sequence[Pattern], coefficients: Reals) -> dict[str, float]:
        """Values by name for coefficients [4 + k], the constant torque where it belongs."""
        found = values_of(setting, patterns, coefficients)
        if self.load_named:
            known = self.start.setting.actuator[LOAD]
            found[_size_of_load()], found[LOAD] = found[LOAD] - known, known
        return found

    def without_load(self) -> Fitted:
        """The base values with the constant torque left as it was given."""
        start, known = self.start, adjusted(self.start.setting.actuator)[LOAD]
        base = start.base * (1.0, 1.0, 1.0, 0.0)
        fit = self.fit(
            Samples(start.setting, start.drive, start.target - known * start.base[:, 3], base), (), np.zeros((self.fold.size, 0))
        )
        return replace(fit, values={**fit.values, LOAD: start.setting.actuator[LOAD]})

    def judged(self, fit: Fitted) -> Fitted:
        """The fit with errors and standard errors."""
        return replace(fit, errors=self._errors(fit), std=self._std(fit))

    def held_out(self, fit: Fitted) -> Reals:
        """The residual of every part when the others are fitted, [samples]."""
        matrix, target = fit.matrix, fit.samples.target
        found = np.zeros_like(target)
        for part in range(self.laps.folds):
            here = self.fold == part
            rest = self.sliding & ~here
            found[here] = target[here] - matrix[here] @ solved(matrix[rest], target[rest])
        return found

    def foretold(self, fit: Fitted, fitted: Rows, told: Rows) -> float:
        """Relative error of some samples when the coefficients come from others, %."""
        matrix, target = fit.matrix, fit.samples.target
        return self.relative(target - matrix @ solved(matrix[fitted], target[fitted]), fit.samples.drive, told)

    def _errors(self, fit: Fitted) -> FoldErrors:
        drive, held_out = fit.samples.drive, self.held_out(fit)
        each = tuple(self.relative(held_out, drive, self.sliding & (self.fold == part)) for part in range(self.laps.folds))
        return FoldErrors(self.relative(fit.residual, drive, self.training), self.relative(fit.residual, drive, self.held), each)

    def _std(self, fit: Fitted) -> dict[str, float]:
        """Standard errors of the values, jointly; sizes that are searched are taken as linear where they are."""
        values = fit.values
        bends = [name for pattern in fit.patterns if pattern.bends for name in pattern.shape]
        held = {name: values[name] for name in bends}
        slopes = []
        for name in bends:
            step = 0.05 * values[name]
            low, high = (self.changed({**held, name: values[name] + sign * step}) for sign in (-1.0, 1.0))
            slopes.append(((high.base - low.base) @ fit.coefficients[:4] - (high.target - low.target)) / (2.0 * step))
        matrix = np.column_stack([fit.matrix, *slopes])[self.training]
        covariance = _covariance(matrix, fit.residual[self.training])
        point = np.concatenate([fit.coefficients, [values[name] for name in bends]])

        def at(moved: Reals) -> Reals:
            found = self.values_of(fit.samples.setting, fit.patterns, moved[: fit.coefficients.size])
            found |= dict(zip(bends, moved[fit.coefficients.size :].tolist(), strict=True))
            return np.array([found[name] for name in values])

        steps = np.maximum(1e-3 * np.sqrt(np.maximum(np.diag(covariance), 0.0)), 1e-12 * np.maximum(np.abs(point), 1e-12))
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
        """The best size of an effect that changes the balance itself, beside what was accepted: of those given, then between the neighbours of the best."""
        (name,) = known[0].shape
        row = row_of(name)

        def at(size: float, samples: Samples | None = None) -> Fitted:
            patterns = (*accepted.patterns, replace(known[0], shape={name: size}))
            return self.fit(samples or self.with_bends(patterns), patterns, accepted.columns)

        sizes = [pattern.shape[name] for pattern in known]
        begun = tuple(sorted(one for pattern in accepted.patterns if pattern.bends for one in pattern.shape.items()))
        fits = []
        for size in sizes:
            changes = (*begun, (name, size))
            if changes not in self._bent:
                self._bent[changes] = self.changed(dict(changes))
            fits.append(at(size, self._bent[changes]))
        place = min(range(len(fits)), key=lambda k: fits[k].square(self.training))
        ends = (sizes[place - 1] if place else max(row.lower, 1e-3 * sizes[0]), sizes[place + 1] if place + 1 < len(sizes) else row.upper)
        found = minimize_scalar(
            lambda size: at(float(size)).square(self.training), bounds=ends, method="bounded", options={"xatol": 5e-3 * sizes[place]}
        )
        refined = at(float(found.x))
        return min(refined, fits[place], key=lambda fit: fit.square(self.training))


def solved(matrix: Reals, target: Reals) -> Reals:
    """Least squares with columns [samples, k] brought to one scale, [k]; zero for a column without content."""
    scale = _scale_of(matrix)
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


def _covariance(columns: Reals, residual: Reals) -> Reals:
    """Covariance of the coefficients for a residual whose neighbours are alike, [k, k]."""
    scale = _scale_of(columns)
    scaled = columns / scale
    inverse = np.linalg.pinv(scaled.T @ scaled, rcond=_SINGULAR, hermitian=True)
    return np.asarray(inverse @ leastsquares.long_run(scaled * residual[:, None]) @ inverse / np.outer(scale, scale))


@dataclass(frozen=True)
class _Tried:
    """The best shape of an effect beside what was accepted: its fit, by how much it lowers the squared error of the training laps, and what it explains of them, [training samples]."""

    effect: str
    fit: Fitted
    gain: float
    part: Reals


class _Search:
    """The greedy search on one record."""

    def __init__(self, actuator: Actuator, record: Record, report: Report) -> None:
        self.bench = Bench(actuator, record)
        self.report = report
        self.effects = [effect.name for effect in load_definitions().physical if effect.name not in actuator.active_effects]
        self.first = float(np.sum(self.bench.without_load().residual[self.bench.training] ** 2))
        self.setting: Setting | None = None
        self.patterns: dict[str, Sequence[Pattern] | str] = {}
        self.columns: dict[str, list[Reals]] = {}

    def prepare(self, setting: Setting) -> None:
        """All patterns in a setting."""
        same_current = self.setting is not None and np.array_equal(self.setting.motion.current_A, setting.motion.current_A)
        self.setting = setting
        for effect in self.effects:
            # torques and loads do not look at the contact, so that without another current they are what they were
            if same_current and load_definitions().effect(effect).site in ("TORQUE", "LOAD"):
                continue
            self.patterns[effect] = found = patterns_of(setting, effect)
            self.columns[effect] = [] if isinstance(found, str) else [self.bench.decimated(pattern.columns) for pattern in found]

    def settled(self, fit: Fitted) -> Fitted:
        """A fit whose last effect changed the balance itself, with all patterns made again from it."""
        self.prepare(fit.samples.setting)
        return self.with_patterns(fit.patterns, fit.samples)

    def with_patterns(self, patterns: Sequence[Pattern], samples: Samples) -> Fitted:
        """A fit of known shapes, their columns from the present setting."""
        found = []
        for pattern in patterns:
            known = self.patterns[pattern.effect]
            same = [one for one in known if one.shape == pattern.shape] if not isinstance(known, str) else []
            again = same[0] if same and samples.setting is self.setting else pattern_of(samples.setting, pattern.effect, pattern.shape)
            found.append(pattern if isinstance(again, str) else again)
        columns = [self.bench.decimated(pattern.columns) for pattern in found]
        return self.bench.fit(samples, found, np.column_stack([np.zeros((self.bench.fold.size, 0)), *columns]))

    def refined(self, fit: Fitted) -> Fitted:
        """A fit with the continuous shape parameters of its last effect between the shapes tried."""
        *others, last = fit.patterns
        names = continuous_of(last.effect)
        if not names:
            return fit
        rows, rest = self.bench.training, fit.columns[:, : fit.columns.shape[1] - last.columns.shape[1]]
        scale = np.array([abs(last.shape[name]) or 1.0 for name in names])
        ranges = [(row_of(name).lower, row_of(name).upper) for name in names]

        def shape_at(point: Reals) -> Shape:
            return {
                **last.shape,
                **{name: float(np.clip(value, *limits)) for name, value, limits in zip(names, point * scale, ranges, strict=True)},
            }

        def at(point: Reals) -> Fitted:
            pattern = pattern_of(fit.samples.setting, last.effect, shape_at(point))
            assert not isinstance(pattern, str)
            return self.bench.fit(fit.samples, (*others, pattern), np.column_stack([rest, self.bench.decimated(pattern.columns)]))

        def square(point: Reals) -> float:
            return at(point).square(rows)

        start = np.array([last.shape[name] for name in names]) / scale
        found = minimize(square, start, method="Nelder-Mead", options={"xatol": 0.01, "fatol": 1e-4 * fit.square(rows), "maxfev": 60})
        best = at(found.x)
        return best if best.square(rows) < fit.square(rows) and not outside(best, last.effect) else fit

    def tried(self, accepted: Fitted, effect: str) -> _Tried | Refusal:
        """The best permitted shape of an effect beside the accepted ones."""
        known = self.patterns[effect]
        if isinstance(known, str):
            return Refusal(effect, known)
        bench, rows = self.bench, self.bench.training
        if known[0].bends:
            fit = bench.searched(accepted, effect, known)
            if fit.square(rows) >= accepted.square(rows):
                return Refusal(effect, "in no size it lowers the error of the laps fitted")
            return self._tried(accepted, effect, fit)
        basis, _ = np.linalg.qr(accepted.matrix[rows])
        ranked = []
        for pattern, columns in zip(known, self.columns[effect], strict=True):
            here = columns[rows]
            own = here - basis @ (basis.T @ here)
            if np.linalg.norm(own) < _OWN * np.linalg.norm(here):
                continue
            solved_own = solved(own, accepted.residual[rows])
            ranked.append((float(np.sum((own @ solved_own) ** 2)), pattern, columns))
        if not ranked:
            return Refusal(effect, self.taken_up(self.columns[effect][0][rows], accepted.samples.base[rows]))
        if len(known) == 1 and _like(ranked[0][2][rows, 0], np.column_stack([accepted.samples.base, accepted.samples.drive])[rows]):
            return Refusal(effect, "it scales every torque alike: beside a given torque constant only ratios are known")
        ranked.sort(key=lambda one: -one[0])
        first: Fitted | None = None
        for gain, pattern, columns in ranked:
            if gain < _SHAPE_SHARE * ranked[0][0]:
                break
            fit = bench.fit(accepted.samples, (*accepted.patterns, pattern), np.column_stack([accepted.columns, columns]))
            first = first or fit
            if not outside(fit, pattern.effect):
                return self._tried(accepted, effect, fit)
        assert first is not None
        return Refusal(effect, f"physically impossible: {outside(first, effect)}", _of(effect, first.values))

    def taken_up(self, columns: Reals, base: Reals) -> str:
        """Which base value takes a pattern [samples, k] up."""
        if not np.any(columns):
            return NOT_HERE
        name = MECHANICAL_PARAMETERS[int(np.argmax(np.abs(base.T @ columns[:, 0]) / np.linalg.norm(base, axis=0)))]
        shown = load_effect() if name == LOAD and self.bench.load_named else name
        return f"no gain over {shown}, which is refitted at every step and takes the same torque up"

    def constant(self) -> tuple[_Tried, Fitted, str]:
        """The change of the constant torque as the first effect, the base values without it, and why it is not added."""
        bench = self.bench
        before = bench.judged(bench.without_load())
        bench.load_named = True
        found = self._tried(before, load_effect(), bench.judged(bench.fit(bench.start, (), np.zeros((bench.fold.size, 0)))))
        why = self.refusal(before, found)
        bench.load_named = not why
        return found, before, why

    def same_as_load(self) -> tuple[str, ...]:
        """Effects that nothing but a constant torque is seen of."""
        load = self.bench.start.base[:, 3:]
        return tuple(
            effect
            for effect in self.effects
            if effect != load_effect()
            and len(self.columns[effect]) == 1
            and np.any(self.columns[effect][0])
            and _like(self.columns[effect][0][:, 0], load)
        )

    def _tried(self, accepted: Fitted, effect: str, fit: Fitted) -> _Tried:
        rows = self.bench.training
        gain = float(np.sum(accepted.residual[rows] ** 2) - np.sum(fit.residual[rows] ** 2))
        return _Tried(effect, fit, gain, (accepted.residual - fit.residual)[rows])

    def refusal(self, accepted: Fitted, tried: _Tried) -> str:
        """Why an effect, judged, is not added; empty when it is."""
        bench, fit = self.bench, tried.fit
        beyond = outside(fit)
        if beyond:
            return f"beside it {beyond}"
        size = load_definitions().effect(tried.effect).size.name
        std = fit.std.get(size, math.inf)
        if abs(fit.values[size]) < SIZE_IN_STD * std:
            return f"its size {fit.values[size]:.3g} is not distinguishable from zero: standard error {std:.2g}"
        if _at_bound(size, fit.values[size]):
            return f"at a bound: {size} = {fit.values[size]:.3g}"
        # every part held out once
        change = (bench.held_out(accepted) ** 2 - bench.held_out(fit) ** 2)[bench.sliding]
        fall = float(np.mean(change))
        spread = math.sqrt(float(leastsquares.long_run((change - fall)[:, None])[0, 0])) / change.size
        if fall < FALL_IN_STD * spread:
            return f"it does not lower the error of the held-out laps significantly: {accepted.errors.holdout:.3g} % to {fit.errors.holdout:.3g} %"
        if any(after >= before for before, after in zip(accepted.errors.each, fit.errors.each, strict=True)):
            return "it raises the error of a lap when that one is held out"
        here = self.elsewhere(accepted, fit)
        before, after = (math.hypot(*(errors[side] for errors in here.values())) / math.sqrt(len(here)) for side in (0, 1))
        if after > WORSE_ELSEWHERE * before:
            return f"it does not carry over to places and speeds to which nothing was fitted: {before:.3g} % to {after:.3g} %"
        share = self.share(accepted, tried.gain)
        if share < LEAST_SHARE:
            return f"it takes off {100.0 * share:.1f} % of what is above the floor, less than {100.0 * LEAST_SHARE:g} %"
        matter = tried.gain / self.first
        if matter < LEAST_OF_FIRST:
            return f"it takes off {100.0 * matter:.2f} % of what the first model left, less than {100.0 * LEAST_OF_FIRST:g} %"
        return ""

    def share(self, accepted: Fitted, gain: float) -> float:
        """Part of the squared error above the floor that a gain is."""
        rows = self.bench.training
        total = float(np.sum(accepted.residual[rows] ** 2))
        floor = (0.01 * floor_of(self.bench, accepted)) ** 2 * float(np.sum(accepted.samples.drive[rows] ** 2))
        # the floor is itself known from a few laps only
        return gain / (total - min(floor, _MOST_FLOOR * total)) if math.isfinite(floor) else gain / total

    def round(self, accepted: Fitted, share: float) -> tuple[list[_Tried], list[Refusal]]:
        """Every effect that is left: those that may be added, best first, and the others with the reason."""
        here = {pattern.effect for pattern in accepted.patterns} | ({load_effect()} if self.bench.load_named else set())
        left = [effect for effect in self.effects if effect not in here]
        added: list[_Tried] = []
        refused: list[Refusal] = []
        for place, effect in enumerate(left):
            self.report(share + _ROUND_SHARE * place / len(left), effect)
            found = self.tried(accepted, effect)
            if isinstance(found, Refusal):
                refused.append(found)
                continue
            judged = replace(found, fit=self.bench.judged(found.fit))
            why = self.refusal(accepted, judged)
            if why:
                refused.append(Refusal(effect, why, _of(effect, judged.fit.values), _of(effect, judged.fit.std), judged.fit.errors))
            else:
                added.append(judged)
        return sorted(added, key=lambda one: -one.gain), refused

    def pruned(self, accepted: Fitted) -> tuple[Fitted, tuple[str, ...]]:
        """Without each earlier effect that the others have made needless, and their names."""
        dropped = []
        for pattern in accepted.patterns[:-1]:
            rest = tuple(one for one in accepted.patterns if one.effect != pattern.effect)
            owners = [one.effect for one in accepted.patterns for _ in range(one.columns.shape[1])]
            columns = accepted.columns[:, [owner != pattern.effect for owner in owners]]
            without = self.bench.fit(self.bench.with_bends(rest) if pattern.bends else accepted.samples, rest, columns)
            gain = float(np.sum(without.residual[self.bench.training] ** 2) - np.sum(accepted.residual[self.bench.training] ** 2))
            if self.share(without, gain) < LEAST_SHARE:
                accepted = self.settled(without)
                dropped.append(pattern.effect)
        if self.bench.load_named and accepted.patterns:
            size = _size_of_load()
            judged = self.bench.judged(accepted)
            if abs(judged.values[size]) < SIZE_IN_STD * judged.std.get(size, math.inf):
                self.bench.load_named = False
                accepted = self.with_patterns(accepted.patterns, accepted.samples)
                dropped.append(load_effect())
        return (self.bench.judged(accepted) if dropped else accepted), tuple(dropped)

    def elsewhere(self, before: Fitted, after: Fitted) -> dict[str, tuple[float, float]]:
        """Errors in % without and with the last effect where neither was fitted: the middle third of the places, and of the speeds, told from the others."""
        motion, smoother = before.samples.setting.motion, self.bench.smoother
        found: dict[str, tuple[float, float]] = {}
        for by, values in (("place", motion.motor_mm), ("speed", np.abs(motion.speed_rad_s))):
            seen = smoother.kept(values)
            low, high = np.quantile(seen[self.bench.sliding], (1.0 / 3.0, 2.0 / 3.0))
            told = self.bench.sliding & (seen >= low) & (seen < high)
            found[by] = (
                self.bench.foretold(before, self.bench.sliding & ~told, told),
                self.bench.foretold(after, self.bench.sliding & ~told, told),
            )
        return found


def _of(effect: str, values: Mapping[str, float]) -> dict[str, float]:
    """The values of one effect."""
    return {name: value for name, value in values.items() if name.startswith(f"{effect}.")}


def _like(column: Reals, others: Reals) -> bool:
    """Whether a column [samples] is a sum of others [samples, k]."""
    return float(np.linalg.norm(column - others @ solved(others, column))) < _OWN * float(np.linalg.norm(column))


def outside(fit: Fitted, effect: str = "") -> str:
    """The first value that lies outside its range, of one effect or of all and the base; empty when all lie inside."""
    for name, value in (_of(effect, fit.values) if effect else fit.values).items():
        row = row_of(name)
        if not row.lower <= value <= row.upper:
            return f"{name} would be {value:.3g}, outside {row.lower:g} .. {row.upper:g}{' ' + row.unit if row.unit else ''}"
    return ""


def _at_bound(name: str, value: float) -> bool:
    row = row_of(name)
    return value >= row.upper - _BOUND * abs(row.upper) or value <= row.lower + _BOUND * abs(row.lower)


def floor_of(bench: Bench, fit: Fitted) -> float:
    """How far one complete lap is from the others in what a fit leaves of the torque, as relative error in %: no model of a lap can beat it. NaN when no lap is repeated."""
    every, period = bench.smoother.every, bench.laps.period_rows
    samples = period / every
    count = int(fit.residual.size / samples) if period else 0
    if count < 2:
        return math.nan
    # laps need not be a whole number of samples long
    places = np.arange(int(samples))
    laps, drive = (
        np.array([np.interp(places + lap * samples, np.arange(values.size), values) for lap in range(count)])
        for values in (fit.residual, fit.samples.drive)
    )
    return 100.0 * math.sqrt(count / (count - 1.0)) * float(np.linalg.norm(laps - laps.mean(axis=0))) / float(np.linalg.norm(drive))


def _class_of(best: _Tried, tried: Sequence[_Tried]) -> tuple[str, ...]:
    """What lowers the error nearly as much as the best and by the same torque, and what the library says looks like it."""
    found = []
    for other in tried:
        cosine = abs(float(best.part @ other.part)) / float(np.linalg.norm(best.part) * np.linalg.norm(other.part))
        if other is not best and other.gain > _CLASS_GAIN * best.gain and cosine > _CLASS_COSINE:
            found.append(other.effect)
    declared = [
        name
        for name in load_definitions().effect(best.effect).look_alikes
        if any(other.effect == name and other.gain > _CLASS_GAIN * best.gain for other in tried)
    ]
    return tuple(dict.fromkeys([*found, *declared]))


def improve_by_forces(actuator: Actuator, record: Record, progress: Report | None = None) -> ForceSteps:
    """Add what the mechanical balance of one record asks for, effect by effect; `progress` is told the share done and what is at work.

    Raises MissingSignal when the record has no mechanical balance.
    """
    report = progress or untold
    report(0.0, "laps and balance")
    search = _Search(actuator, record, report)
    bench = search.bench
    search.prepare(bench.start.setting)
    given = _given(actuator, bench)
    steps: list[ForceStep] = []
    refused: list[Refusal] = []
    needless: list[Refusal] = []
    constant, first, why = search.constant()
    if why:
        first = accepted = bench.judged(bench.fit(bench.start, (), np.zeros((bench.fold.size, 0))))
    else:
        accepted = constant.fit
        steps.append(
            ForceStep(
                load_effect(), accepted.values, accepted.std, search.same_as_load(), accepted.errors, search.elsewhere(first, accepted)
            )
        )
    while True:
        added, refused = search.round(accepted, min(0.1 + _ROUND_SHARE * len(steps), 0.85))
        if not added:
            break
        if len(steps) == EFFECTS_MAX:
            refused += [
                Refusal(one.effect, MANY, _of(one.effect, one.fit.values), _of(one.effect, one.fit.std), one.fit.errors) for one in added
            ]
            break
        best = added[0]
        before, accepted = accepted, best.fit
        accepted = bench.judged(search.settled(best.fit) if best.fit.patterns[-1].bends else search.refined(best.fit))
        steps.append(
            ForceStep(
                best.effect, accepted.values, accepted.std, _class_of(best, added), accepted.errors, search.elsewhere(before, accepted)
            )
        )
        accepted, dropped = search.pruned(accepted)
        needless += [Refusal(name, f"needless beside {best.effect}, which came later") for name in dropped]
    report(1.0, "done")
    curves = {
        "time_s": bench.smoother.kept(record.time_s),
        "position_mm": bench.smoother.kept(accepted.samples.setting.motion.motor_mm),
        "speed_rad_s": bench.smoother.kept(accepted.samples.setting.motion.speed_rad_s),
        "torque_Nm": accepted.samples.drive,
        "residual_before_Nm": first.residual,
        "residual_after_Nm": accepted.residual,
    }
    refusals = (*needless, *(one for one in refused if one.effect not in {gone.effect for gone in needless}))
    return ForceSteps(
        actuator.changed(accepted.values),
        given,
        first.errors,
        tuple(steps),
        refusals,
        floor_of(bench, accepted),
        bench.laps,
        record.period_s,
        curves,
    )


def _given(actuator: Actuator, bench: Bench) -> FoldErrors:
    """Errors of the actuator as it was given, from the balance as `ema compare` draws it."""
    balance = mechanical(actuator, bench.record, bench.smoother)
    parts = [bench.fold == part for part in range(bench.laps.folds)]
    *training, held = (bench.relative(balance.residual, balance.measured, part) for part in parts)
    return FoldErrors(bench.relative(balance.residual, balance.measured, ~parts[-1]), held, (*training, held))
