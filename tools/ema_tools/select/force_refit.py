"""Base values refitted by the balance of forces together with the effects that a model holds, and one more effect put in: on the bench of the search, so that it says what the search says."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ema_tools.balances.mechanical import MECHANICAL_PARAMETERS
from ema_tools.base.errors import InputError
from ema_tools.base.progress import Report
from ema_tools.data.actuator import Actuator, row_of
from ema_tools.data.motion_records import AnyRecord
from ema_tools.fit.division import Division
from ema_tools.library.definitions import load_definitions
from ema_tools.library.registry import named
from ema_tools.select.balance_bench import INERTIA, LOAD, Bench, Fitted, FoldErrors, floor_of, given_errors, load_effect, solved
from ema_tools.select.drive_lag import with_lag_fitted
from ema_tools.select.fixes import NONE, Fixes
from ema_tools.select.force_balance import ForceSearch
from ema_tools.select.force_judge import outside, unphysical
from ema_tools.select.force_steps import Refusal
from ema_tools.select.foretold_drive import foretold_percent
from ema_tools.select.torque_patterns import Pattern, pattern_of

_NEAR = 1e-6  # so near to an end of its range, relative, a value lies on it [precision]
_OWN = 1e-3  # an effect whose torque is the base values' own but for so much of it is not refitted beside them [precision]


@dataclass(frozen=True)
class ForceRefit:
    """A model refitted: errors as it was given, with base values and its own effects refitted, and, where one was asked for, with the effect put in.

    `values`, `std`: of the last fit, by name; `kept`: base values that were taken and not fitted, with why: the user, or the records; `held`: effects of the model that were not refitted;
    `at_ends`: values on an end of where they may be;
    `foretold`: error in % of the drive foretold from the motion alone, before and after; `reason`: why the effect is not recommended, empty where it is.
    """

    actuator: Actuator
    given: FoldErrors
    refitted: FoldErrors
    errors: FoldErrors
    values: Mapping[str, float]
    std: Mapping[str, float]
    kept: Mapping[str, str]
    held: tuple[str, ...]
    at_ends: tuple[str, ...]
    floor_percent: float
    division: Division
    foretold: tuple[float, float]
    reason: str = ""


class _Refit:
    """The bench of a model whose own effects are fitted anew."""

    def __init__(
        self,
        actuator: Actuator,
        records: Sequence[AnyRecord],
        holdout: Sequence[AnyRecord],
        fixes: Fixes,
        added: str,
        whole: bool,
        report: Report,
    ) -> None:
        zeros = {name: (size, zero) for name, size, zero in load_definitions().sizes}
        free = [name for name in actuator.active_effects if name in named() and name not in fixes.effects]
        self.actuator, self.added = actuator, added
        while True:
            bare = actuator.changed(dict(zeros[name] for name in free))
            self.bench = Bench(bare, records, holdout, fixes, whole)
            others = [name for name in free if name not in (load_effect(), added)]
            self.search = ForceSearch(self.bench, report, [*others, added] if added else others)
            if load_effect() in free and MECHANICAL_PARAMETERS.index(LOAD) in self.bench.taken:
                # a load that nobody can tell from friction stays the model's
                free = [name for name in free if name != load_effect()]
                continue
            self.bench.load_named = load_effect() in free or added == load_effect()
            self.search.prepare(self.bench.start.setting)
            self.standing = [self._shape(name) for name in others]
            stuck = [name for name, one in zip(others, self.standing, strict=True) if one is None or self._is_base(one)]
            if not stuck:
                break
            # what the balance cannot tell from a base value, or does not show, stays at work as it is
            free = [name for name in free if name not in stuck]
        # the constant torque as the model states it is the one that was refitted beside its effects
        self.search.without_effects()
        self.held = tuple(name for name in actuator.active_effects if name not in free and name != added)

    def _shape(self, effect: str) -> Pattern | None:
        """An effect of the model in the shape that the model states."""
        known = self.search.patterns[effect]
        if isinstance(known, str):
            return None
        shape = {name: self.actuator[name] for name in known[0].shape}
        found = pattern_of(self.bench.start.setting, effect, shape)
        return None if isinstance(found, str) else found

    def _is_base(self, pattern: Pattern) -> bool:
        """Whether its torque is one of the base values'."""
        if pattern.bends:
            return False
        rows, base = self.bench.training, self.bench.start.base
        columns = self.bench.decimated(pattern.columns)[rows]
        left = columns - np.column_stack([base[rows] @ solved(base[rows], column) for column in columns.T])
        return float(np.linalg.norm(left)) <= _OWN * float(np.linalg.norm(columns))

    def begun(self) -> Fitted:
        """Base values and the model's own effects."""
        patterns = [one for one in self.standing if one is not None]
        samples = self.bench.with_bends(patterns)
        if any(one.bends for one in patterns):
            self.search.prepare(samples.setting)
        return self.search.carrying(self.search.with_patterns(patterns, samples))

    def finished(self, given: FoldErrors, before: Fitted, last: Fitted, reason: str = "") -> ForceRefit:
        """What the last fit came to. Raises InputError where the model cannot be written."""
        beyond = outside(last)
        if beyond:
            raise InputError(
                f"{f'add {self.added}' if self.added else 'calibrate'}: {beyond}: keep an effect of the model by --fix EFFECT, or bound a base value by --fix NAME=LOW..HIGH"
            )
        bench, last = self.bench, self.bench.stated(last)
        sizes = {load_definitions().effect(one.effect).size.name for one in last.patterns}
        ends = tuple(name for name in sizes if _on_end(name, last.values[name]))
        return ForceRefit(
            bench.start.setting.actuator.changed(last.values),
            given,
            before.errors,
            last.errors,
            last.values,
            last.std,
            bench.kept_because,
            self.held,
            (*bench.at_ends(last), *ends),
            floor_of(bench, last),
            bench.division,
            (foretold_percent(bench, before), foretold_percent(bench, last)),
            reason,
        )


def _impossible(fit: Fitted) -> frozenset[str]:
    """Effects of a fit whose values lie outside their ranges."""
    return frozenset(pattern.effect for pattern in fit.patterns if outside(fit, pattern.effect))


def _on_end(name: str, value: float) -> bool:
    row = row_of(name)
    return any(math.isclose(value, end, rel_tol=_NEAR) for end in (row.lower, row.upper))


def refit_by_forces(actuator: Actuator, records: Sequence[AnyRecord], fixes: Fixes = NONE, report: Report | None = None) -> ForceRefit:
    """Base values and the sizes of the model's own effects, fitted to all of the records, and how late the drive records where the actuator does not state it. Raises MissingSignal, InputError."""
    return with_lag_fitted(lambda known, tell: _refit_by_forces(known, records, fixes, tell), actuator, records, (), fixes, report)


def _refit_by_forces(actuator: Actuator, records: Sequence[AnyRecord], fixes: Fixes, tell: Report) -> ForceRefit:
    """The same with the drive as late as the actuator says."""
    tell(0.1, "parts and balance")
    while True:
        refit = _Refit(actuator, records, (), fixes, "", True, tell)
        refit.bench.stay_in_ranges()
        tell(0.6, "fitting")
        last = refit.bench.judged(refit.begun())
        impossible = _impossible(last)
        if not impossible:
            break
        # what the records would make impossible stays as the model states it
        fixes = fixes.with_effects(impossible)
    return refit.finished(given_errors(actuator, refit.bench), last, last)


def add_by_forces(
    actuator: Actuator,
    effect: str,
    records: Sequence[AnyRecord],
    holdout: Sequence[AnyRecord] = (),
    fixes: Fixes = NONE,
    report: Report | None = None,
) -> ForceRefit:
    """One effect in its best shape, fitted together with base values and the model's own effects; judged as the search judges it.

    Raises MissingSignal, and InputError for one that the records do not show.
    """
    return with_lag_fitted(
        lambda known, tell: _add_by_forces(known, effect, records, holdout, fixes, tell), actuator, records, holdout, fixes, report
    )


def _add_by_forces(
    actuator: Actuator, effect: str, records: Sequence[AnyRecord], holdout: Sequence[AnyRecord], fixes: Fixes, tell: Report
) -> ForceRefit:
    """The same with the drive as late as the actuator says."""
    tell(0.1, "parts and balance")
    refit = _Refit(actuator, records, holdout, fixes, effect, False, tell)
    bench, search = refit.bench, refit.search
    given = given_errors(actuator, bench)
    bench.keep_inertia()
    bench.stay_in_ranges()
    tell(0.5, f"fitting {effect}")
    begun = refit.begun()
    impossible = _impossible(begun)
    if impossible:
        return _add_by_forces(actuator, effect, records, holdout, fixes.with_effects(impossible), tell)
    if effect == load_effect():
        if LOAD in fixes.kept:
            raise InputError(f"add {effect}: {LOAD} is kept by --fix, and is the same torque: leave one of the two out")
        if MECHANICAL_PARAMETERS.index(LOAD) in bench.taken:
            raise InputError(f"add {effect}: the records move one way only, where a load is the same as friction: record the other way too")
        before = bench.judged(bench.with_load_as_given(begun))
        last = bench.judged(begun)
        return refit.finished(given, before, last, search.judged_against(before, effect, last))
    before = bench.judged(begun)
    found = search.tried(before, effect, asked=True)
    if isinstance(found, Refusal) and INERTIA not in fixes.as_stated:
        # a free inertia may hide it, as in the search of ema diagnose
        return _add_by_forces(actuator, effect, records, holdout, fixes.without(INERTIA), tell)
    if isinstance(found, Refusal):
        raise InputError(f"add {effect}: {found.reason}: ema diagnose says what these records ask for")
    if INERTIA not in fixes.as_stated and unphysical(INERTIA, found.fit):
        return _add_by_forces(actuator, effect, records, holdout, fixes.without(INERTIA), tell)
    doubt = search.indistinct(before, effect)
    last = bench.judged(found.fit)
    reason = doubt or search.judged_against(before, effect, last)
    last = search.settled(last) if last.patterns[-1].bends else search.refined(last)
    last = bench.judged(search.consistent(last))
    return refit.finished(given, before, last, reason)
