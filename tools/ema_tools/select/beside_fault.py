"""Whether an effect that the model lacks stands behind a CSJ or BLK: the guard of the identification.

The machine is taken for known, by its actuator file or by healthy repeats of the same command: CSJ and BLK are free, grease and winding scatter as from run to run, and everything
else stays. A missing effect then moves CSJ and BLK far from where they belong, where signatures mislead; so every effect is fitted beside them in the nonlinear model, and the
costs are compared. Where the one that is named leaves more than noise, without repeats, its size is that of a unit which differs from its file as units do.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.base.parallel import each
from ema_tools.compare.validity import judge
from ema_tools.data.actuator import Actuator, row_of
from ema_tools.data.records import Record
from ema_tools.fit import bounded
from ema_tools.fit import nuisance as spreads
from ema_tools.fit.bounded import FreeValue, OneSided, Stop
from ema_tools.fit.evidence import FAR, FAR_ROUNDS, Evidence, settled, simulate_channels, view
from ema_tools.fit.nuisance import Spread
from ema_tools.fit.refit import refit
from ema_tools.library.definitions import load_definitions
from ema_tools.library.faults import FAULTS
from ema_tools.library.registry import record_of
from ema_tools.library.shapes import penalty
from ema_tools.select.baseline import common_channels, gather, same_command
from ema_tools.select.candidates import candidates
from ema_tools.select.matched_filter import Screen
from ema_tools.select.strategies.strategy import LEAST_LIMIT

# Values that have a spread of their own beside CSJ and BLK, relative.
_SCATTER = {name: std for name, std in spreads.FROM_RUN_TO_RUN.items() if name not in FAULTS.values()}
_FREE = 0.3  # how far CSJ and BLK may move while the starts are sought, relative [judgement]
_CREDIBLE = 3.0  # what scatters goes no farther than this, in its spreads: it would stand in for what is missing [chance]
# Steps of one fit: all effects by size alone, the better ones from two starts, the few best with all their values [effort]
_FIRST_STEPS, _SECOND_STEPS, _LAST_STEPS = 4, 8, 20
_SECOND, _LAST = 6, 3  # how many effects go on to the second and the last of these fits [effort]
_STEP = 0.02  # of a value's scale: large against reversals that jump a step [precision]
_PHASE_SCALE = 0.5  # rad: what a phase is stepped in [judgement]
_ALIKE = 9.0  # fits whose costs differ by less than three standard deviations cannot be told apart [chance]
_LEAST_SHARE = 0.05  # the share of the excess over sensor noise that a named effect must take off ... [judgement]
_UNEXPLAINED = 0.1  # ... and with more than this share left the answer is that something is missing, not what [judgement]
_LEAST_ERRORS = 2.0  # a named effect's size differs from none by so many standard errors [chance]
_PLAIN = 1.1  # a model whose residual stays below this many times the noise in every signal lacks nothing that matters [judgement]
_NOISELESS = 2e-4  # of a record without noise: what integration and rounding leave, relative to the signal [precision]


@dataclass(frozen=True)
class Guarded:
    """What the guard says. `verdict`: adequate, missing or unknown; `effects`: the class of the missing effect, itself first; `values`, `std`: of that effect;
    `faults`: CSJ and BLK beside it by name; `against`: healthy repeats that it was compared with; `skipped`: why nothing was sought; `there`: the model holds the effect, at another size."""

    verdict: str
    effects: tuple[str, ...]
    values: Mapping[str, float]
    std: Mapping[str, float]
    faults: Mapping[str, float]
    against: int
    skipped: str
    wall_s: float
    there: bool = False

    @property
    def unusable(self) -> bool:
        """Whether nothing was sought because the record cannot answer."""
        return self.verdict == "unknown" and bool(self.skipped)


@dataclass(frozen=True)
class _Fit:
    effect: str
    values: Mapping[str, float]
    std: Mapping[str, float]
    cost: float


class _Known:
    """A record of a machine that is known but for CSJ and BLK: whitened residuals of the model with any values, what sensors and every machine's slight effects add taken off."""

    def __init__(self, evidence: Evidence) -> None:
        self.evidence = evidence
        self.actuator = evidence.actuator
        self.faults = tuple(name for name in FAULTS.values() if self.actuator[name] > 0.0)
        self.scatter = tuple(name for name in _SCATTER if self.actuator[name] > 0.0)
        self._level = np.sqrt(evidence.noise[:, :1])  # [channels, 1]: white without repeats
        count = len(evidence.additive)
        added = (
            np.array([self._weighted(signal) for signal in evidence.additive]).reshape(count, -1)
            if count
            else np.empty((0, self._weighted(evidence.target).size))
        )
        self._basis, _ = np.linalg.qr(np.vstack([added.T, -np.eye(count)]))
        costs = [float(repeat @ repeat) for repeat in evidence.of_repeats]
        self.floor = float(np.mean(costs)) if costs else evidence.floor
        self._largest = max(costs, default=0.0)

    def _weighted(self, signals: Reals) -> Reals:
        return self.evidence.whiten(signals) if self.evidence.relative else (signals / self._level).ravel()

    def signals(self, changes: Mapping[str, float]) -> Reals:
        """The model, [channels, rows]. Raises InputError when it refuses the values."""
        evidence = self.evidence
        return simulate_channels(self.actuator.changed(changes), evidence.record, evidence.channels, evidence.start_mm)

    def residual(self, changes: Mapping[str, float]) -> Reals:
        """[whitened numbers + additive], the squared length is the cost."""
        plain = self._weighted(self.evidence.target - self.signals(changes))
        tall = np.concatenate([plain, np.zeros(self._basis.shape[1])])
        return np.asarray(tall - self._basis @ (self._basis.T @ tall))

    def fit(self, effect: str, start: Mapping[str, float], free: Sequence[str], steps: int) -> _Fit | None:
        """Fits the values `free` of those in `start`; None where the model refuses the start."""
        first = {**{name: self.actuator[name] for name in (*self.faults, *self.scatter)}, **start}
        unknowns = [self._unknown(name, value) for name, value in first.items() if name in free]
        scatter = [
            (one.name, self.actuator[one.name], _SCATTER[one.name] * self.actuator[one.name])
            for one in unknowns
            if one.name in self.scatter
        ]
        try:
            refused = self.residual(first)
        except InputError:
            return None

        def vector(values: Mapping[str, float]) -> Reals:
            try:
                plain = self.residual({**first, **values})
            except InputError:
                plain = 2.0 * refused
            return np.concatenate([plain, [(values[name] - healthy) / std for name, healthy, std in scatter]])

        found = bounded.fit(unknowns, vector, OneSided((_STEP,)), Stop(steps, 1e-5, 1e-6))
        std = dict(zip(found.values, np.sqrt(np.maximum(np.diag(found.covariance), 0.0)).tolist(), strict=True))
        return _Fit(effect, {**first, **found.values}, std, found.cost)

    def _unknown(self, name: str, first: float) -> FreeValue:
        lower, upper = self._ends(name)
        return FreeValue(name, first, self._scale(name, first), lower, upper)

    def _ends(self, name: str) -> tuple[float, float]:
        """Where a value may lie."""
        row = row_of(name)
        if name in self.scatter:
            reach = _CREDIBLE * _SCATTER[name]
            return (1.0 - reach) * self.actuator[name], (1.0 + reach) * self.actuator[name]
        return row.lower, row.upper

    def _scale(self, name: str, first: float) -> float:
        if name.endswith("phase_rad"):
            return _PHASE_SCALE
        return max(abs(first), 1e-9 if name.startswith("effects.") else 0.3 * abs(self.actuator[name]))

    def base(self, estimates: Mapping[str, float]) -> _Fit:
        """CSJ and BLK alone, from their healthy values and from `estimates`: the better of both."""
        healthy = {name: self.actuator[name] for name in self.faults}
        starts = (healthy, {name: max(estimates.get(name, healthy[name]), 0.2 * healthy[name]) for name in healthy})
        fits = each(lambda start: self.fit("", start, (*self.faults, *self.scatter), _LAST_STEPS), starts)
        return min((one for one in fits if one is not None), key=lambda one: one.cost)

    def plain(self, base: _Fit) -> bool:
        """Whether the residual is as small as those of healthy repeats; without them, in every signal as small as its sensor's noise."""
        if self.evidence.relative:
            return base.cost < _PLAIN * self._largest
        left = self.evidence.target - self.signals(base.values)
        left = left - left.mean(axis=1, keepdims=True)
        size = np.sqrt(np.mean(self.evidence.target**2, axis=1))
        rms = np.sqrt(np.mean(left**2, axis=1))
        return bool(np.all(rms <= np.maximum(_PLAIN * self._level[:, 0], _NOISELESS * size)))

    def starts(self, base: _Fit, only: str | None = None) -> list[tuple[str, dict[str, float]]]:
        """Where the fit of each effect, or of `only` one, begins, one start for each sign: the shape and size whose signature at the base explains most."""
        machine = self.actuator.changed(base.values)
        free = tuple(Spread((name,), _FREE, True) for name in self.faults if machine[name] > 0.0)
        here = view(
            replace(
                self.evidence, actuator=machine, spread=(*free, *spreads.from_run_to_run({name: _SCATTER[name] for name in self.scatter}))
            ),
            {},
        )
        tasks = [
            (candidate, first)
            for candidate in candidates(Screen(here), only=only)
            if candidate.effect not in FAULTS
            for first in candidate.first
        ]

        def scored(task: tuple[Any, float]) -> tuple[float, float]:
            candidate, first = task
            try:
                vector = here.signature(candidate.changes(first))
            except InputError:
                return 0.0, 0.0
            length = float(vector @ vector)
            share = float(np.clip(float(vector @ here.residual) / length, 0.0, 100.0)) if length > 0.0 else 0.0
            kept = min(share, 1.0)
            return 2.0 * kept * float(vector @ here.residual) - kept**2 * length, share

        best: dict[tuple[str, bool], tuple[float, dict[str, float]]] = {}
        for (candidate, first), (gain, share) in zip(tasks, each(scored, tasks), strict=True):
            key = (candidate.effect, first > candidate.zero)
            if key not in best or gain > best[key][0]:
                wanted = candidate.zero + (first - candidate.zero) * float(np.clip(share, 0.5, 20.0))
                best[key] = (gain, candidate.changes(float(np.clip(wanted, candidate.lower, candidate.upper))))
        return [(effect, start) for (effect, _), (_, start) in best.items()]


def _beside(known: _Known, base: _Fit, only: str | None = None) -> list[_Fit]:
    """Every effect, or `only` one, fitted beside CSJ and BLK, best first; the few best with all their values."""
    sizes = {effect.name: f"effects.{effect.size.name}" for effect in load_definitions().effects}
    healthy = {name: known.actuator[name] for name in known.faults}
    beside = (*known.faults, *known.scatter)
    tasks: list[tuple[str, Mapping[str, float]]] = [
        (effect, {**start, **{name: base.values[name] for name in known.faults}}) for effect, start in known.starts(base, only)
    ]
    first = _best_of_each(each(lambda task: known.fit(task[0], task[1], (sizes[task[0]], *known.faults), _FIRST_STEPS), tasks))[:_SECOND]
    tasks = [(one.effect, values) for one in first for values in (one.values, {**one.values, **healthy})]
    second = _best_of_each(each(lambda task: known.fit(task[0], task[1], (sizes[task[0]], *known.faults), _SECOND_STEPS), tasks))[:_LAST]

    def free(one: _Fit) -> list[str]:
        return [*beside, *(name for name in one.values if name.startswith("effects.") and not name.endswith(".periods"))]

    return _best_of_each(each(lambda one: known.fit(one.effect, one.values, free(one), _LAST_STEPS), second))


def _best_of_each(fits: Sequence[_Fit | None]) -> list[_Fit]:
    """The best fit of each effect, best first."""
    best: dict[str, _Fit] = {}
    for one in sorted((one for one in fits if one is not None), key=lambda one: one.cost + penalty([one.effect])):
        best.setdefault(one.effect, one)
    return list(best.values())


def _named(known: _Known, base: _Fit) -> tuple[str, _Fit | None, tuple[str, ...]]:
    """Verdict, the best effect, what looks like it."""
    numbers = known.evidence.numbers
    excess = max(base.cost - known.floor, 1e-9)
    fits = _beside(known, base)
    if not fits:
        return "unknown", None, ()
    best = fits[0]
    size, zero = next((name, row_of(name).nominal) for name in best.values if name.startswith(f"effects.{best.effect}."))
    if abs(best.values[size] - zero) < _LEAST_ERRORS * best.std.get(size, 0.0):
        return "unknown", None, ()
    unit = max(1.0, best.cost / numbers)  # where the misfit that is left is more than noise, it is the yardstick
    if base.cost - best.cost - penalty([best.effect]) < max(LEAST_LIMIT * unit, _LEAST_SHARE * excess):
        return "unknown", None, ()
    if best.cost - known.floor > max(_UNEXPLAINED * excess, 6.0 * np.sqrt(2.0 * numbers)):
        return "unknown", None, ()
    alike = [one.effect for one in fits[1:] if one.cost - best.cost < _ALIKE * unit]
    alike += record_of(best.effect).inseparable
    return "missing", best, tuple(dict.fromkeys(alike))


def beside_faults(evidence: Evidence, effect: str) -> tuple[dict[str, float], dict[str, float]]:
    """On the evidence of a machine that is known: CSJ and BLK as they are without `effect`, and the values of all three fitted together.

    Raises InputError when the record shows nothing of the effect.
    """
    known = _Known(evidence)
    base = known.base({})
    fits = _beside(known, base, effect)
    if not fits:
        raise InputError(f"{effect}: the record shows nothing of it: nothing can be fitted")
    own = {name: value for name, value in fits[0].values.items() if name.startswith("effects.")}
    return {name: base.values[name] for name in known.faults}, {**own, **{name: fits[0].values[name] for name in known.faults}}


def _live(*records: Record) -> tuple[str, ...]:
    """Signals that all records have and that change: a sensor that is not connected says nothing."""
    return tuple(name for name in common_channels(records) if all(np.ptp(one.recorded(name)) > 0.0 for one in records))


def _blocked(actuator: Actuator, record: Record) -> str:
    """Why no answer from a record means anything, by its validity; empty where it may answer. Sensors that are not connected are left out."""
    live = _live(record)
    silent: dict[str, Any] = {name: None for name in common_channels([record]) if name not in live and name != "position_mm"}
    gate = judge(actuator, replace(record, **silent))
    return next((f"{one.text}: {one.next}" for one in gate.remarks if one.severity == "blocks"), "")


def known_machine(actuator: Actuator, record: Record) -> Evidence:
    """Evidence of a record of a machine that is as `actuator` says, of which only grease and winding scatter from run to run; CSJ and BLK are left to be fitted."""
    return _as_known(gather(actuator, record, channels=_live(record)))


def _as_known(unit: Evidence) -> Evidence:
    return replace(unit, spread=spreads.from_run_to_run({name: std for name, std in _SCATTER.items() if unit.actuator[name] > 0.0}))


def _on_unit(unit: Evidence, named: _Fit) -> _Fit:
    """The named effect's size where the machine may differ from its file as units do from their data sheet; `named` itself where that leaves nothing of the effect."""
    values = {name: value for name, value in named.values.items() if name.startswith(f"effects.{named.effect}.")}
    try:
        fit = refit(settled(unit, values, rounds=FAR_ROUNDS, reach=FAR), values)
    except InputError:
        return named
    if not fit.determined(named.effect):
        return named
    machine = spreads.moved(unit.actuator, unit.spread, fit.deviations())
    return _Fit(
        named.effect,
        {**named.values, **{name: machine[name] for name in named.values if name in machine}, **fit.values},
        {**named.std, **fit.std},
        named.cost,
    )


def guard(actuator: Actuator, record: Record, healthy: Sequence[Record], estimates: Mapping[str, float], doubted: bool) -> Guarded:
    """Whether an effect is missing behind `estimates` of CSJ and BLK, by name. `doubted`: the search itself found the model not adequate.

    Two or more `healthy` records of the record's command are what it is compared with. Raises InputError as `gather` does.
    """
    begun = time.perf_counter()
    same = [other for other in healthy if same_command(record, other)]
    repeats = same if len(same) > 1 else []
    blocked = _blocked(actuator, record)
    if blocked:
        return Guarded("unknown", (), {}, {}, {}, len(repeats), blocked, time.perf_counter() - begun)
    gathered = gather(actuator, record, repeats, _live(record, *repeats))
    known = _Known(gathered if repeats else _as_known(gathered))
    base = known.base(estimates)
    faults = {name: base.values[name] for name in known.faults}
    if (repeats or not doubted) and known.plain(base):
        why = "the residual is as small as those of the healthy records" if repeats else "every residual is as small as its sensor's noise"
        return Guarded("adequate", (), {}, {}, faults, len(repeats), why, time.perf_counter() - begun)
    verdict, best, alike = _named(known, base)
    if best is None:
        return Guarded(verdict, (), {}, {}, {}, len(repeats), "", time.perf_counter() - begun)
    # what the effect leaves beyond noise says that the machine is not as its file says
    as_filed = bool(repeats) or best.cost - known.floor < 6.0 * np.sqrt(2.0 * known.evidence.numbers)
    best = best if as_filed else _on_unit(gathered, best)
    own = {name: value for name, value in best.values.items() if name.startswith(f"effects.{best.effect}.")}
    beside = {name: best.values[name] for name in known.faults}
    std = {name: best.std[name] for name in own if name in best.std}
    return Guarded(
        verdict,
        (best.effect, *alike),
        own,
        std,
        beside,
        len(repeats),
        "",
        time.perf_counter() - begun,
        best.effect in actuator.active_effects,
    )
