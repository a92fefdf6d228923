"""A record of a machine that is taken for known: CSJ and BLK are free, grease and winding scatter as from run to run, and everything else stays.

What is known is the actuator file, or healthy repeats of the same command. Costs are squared residuals of all signals that are connected, in units of their noise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.base.parallel import each
from ema_tools.compare.validity import RecordRemark, judge
from ema_tools.data.actuator import Actuator, row_of
from ema_tools.data.records import Record
from ema_tools.fit import bounded
from ema_tools.fit import nuisance as spreads
from ema_tools.fit.bounded import PROMISE, FreeValue, OneSided, Stop
from ema_tools.fit.evidence import Evidence, simulate_channels, simulate_side_by_side, view
from ema_tools.fit.misfit import misfit, whole_std
from ema_tools.fit.nuisance import Spread
from ema_tools.library.faults import FAULTS
from ema_tools.select.baseline import common_channels, gather, same_command
from ema_tools.select.candidates import candidates
from ema_tools.select.matched_filter import Screen

_FREE = 0.3  # how far CSJ and BLK may move while the starts are sought, relative [judgement]
_CREDIBLE = 3.0  # what scatters goes no farther than this, in its spreads: it would stand in for what is missing [chance]
_NEAR = 0.01  # of the way between the ends of what a day does: nearer to one, and it lies on it [precision]
_FAR = 3.0  # and beside healthy records no farther than so many of the spreads of any day [chance]
_STEP = 0.02  # of a value's scale: large against reversals that jump a step [precision]
LAST_STEPS = 20  # of a fit of all values [effort]
_PHASE_SCALE = 0.5  # rad: what a phase is stepped in [judgement]
_PLAIN = 1.1  # a model whose residual stays below this many times the noise in every signal lacks nothing that matters [judgement]
_PARTS = 10  # of the record, each of which must be plain: an effect may begin late [judgement]
_BLOCK_ROWS = 25  # whose mean tells what lasts from noise [judgement]
_LASTING = 0.5  # as much may last in a signal, in the noise of one row: noise alone leaves a fifth of it [judgement]
_OVER_REPEATS = 2.0  # times what healthy repeats show against each other [judgement]
SMALL_SHARE = 0.25  # of a spread: large against the model's roughness, small against what bends [precision]
_NOISELESS = 2e-4  # of a record without noise: what integration and rounding leave, relative to the signal [precision]


@dataclass(frozen=True)
class MachineFit:
    """A fit of CSJ, BLK, what scatters and, where it has a name, an effect: values and standard errors by name, and the cost that is left."""

    effect: str
    values: Mapping[str, float]
    std: Mapping[str, float]
    cost: float


@dataclass(frozen=True)
class Start:
    """Where the fit of an effect begins, and the cost that it takes off there."""

    effect: str
    values: Mapping[str, float]
    gain: float


class KnownMachine:
    """A record of a machine that is known but for CSJ and BLK: whitened residuals of the model with any values, what sensors and every machine's slight effects add taken off."""

    def __init__(self, evidence: Evidence) -> None:
        self.evidence = evidence = evidence.of_known or evidence
        self.actuator = evidence.actuator
        self.faults = tuple(name for name in FAULTS.values() if self.actuator[name] > 0.0)
        shown = {one.title: one for one in evidence.spread} if evidence.relative else {}
        self.scatter = {one.title: shown.get(one.title, one) for one in spreads.from_day_to_day(self.actuator)}
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

    def of_repeat(self, place: int) -> KnownMachine:
        """The same of a healthy repeat against the others."""
        other = copy(self)
        other.evidence = replace(self.evidence, target=self.evidence.repeats[place])
        return other

    def today(self, base: MachineFit) -> dict[str, float]:
        """Grease, winding and what else scatters as they are today, by name."""
        return {name: base.values[name] for name in self.scatter}

    @property
    def free(self) -> tuple[str, ...]:
        """What is free beside any effect: CSJ, BLK and what scatters."""
        return (*self.faults, *self.scatter)

    def _weighted(self, signals: Reals) -> Reals:
        return self.evidence.whiten(signals) if self.evidence.relative else (signals / self._level).ravel()

    def signals(self, changes: Mapping[str, float]) -> Reals:
        """The model, [channels, rows]. Raises InputError when it refuses the values."""
        evidence = self.evidence
        return simulate_channels(self.actuator.changed(changes), evidence.record, evidence.channels, evidence.start_mm)

    def residual(self, changes: Mapping[str, float]) -> Reals:
        """[whitened numbers + additive], the squared length is the cost."""
        return self._left(self.signals(changes))

    def residuals(self, asked: Sequence[Mapping[str, float]]) -> list[Reals | InputError]:
        """`residual` of each of several changes, side by side; the error in the place of changes that the model refuses."""
        evidence = self.evidence
        return simulate_side_by_side(
            self.actuator, asked, evidence.record, evidence.channels, evidence.start_mm, lambda _, run: self._left(run)
        )

    def _left(self, run: Reals) -> Reals:
        plain = self._weighted(self.evidence.target - run)
        tall = np.concatenate([plain, np.zeros(self._basis.shape[1])])
        return np.asarray(tall - self._basis @ (self._basis.T @ tall))

    def fit(
        self,
        effect: str,
        start: Mapping[str, float],
        free: Sequence[str],
        steps: int,
        ends: Mapping[str, tuple[float, float]] | None = None,
    ) -> MachineFit | None:
        """Fits the values `free` of those in `start`, inside `ends` where given; None where the model refuses the start."""
        first = {**{name: self.actuator[name] for name in self.free}, **start}
        inside = ends or {}
        unknowns = [self._unknown(name, value, inside.get(name)) for name, value in first.items() if name in free]
        scatter = [
            (one.name, self.actuator[one.name], self.scatter[one.name].in_unit(self.actuator))
            for one in unknowns
            if one.name in self.scatter
        ]
        try:
            refused = self.residual(first)
        except InputError:
            return None

        def vectors(asked: Sequence[Mapping[str, float]]) -> list[Reals]:
            left = self.residuals([{**first, **values} for values in asked])
            return [
                np.concatenate(
                    [
                        2.0 * refused if isinstance(plain, InputError) else plain,
                        [(values[name] - healthy) / std for name, healthy, std in scatter],
                    ]
                )
                for values, plain in zip(asked, left, strict=True)
            ]

        found = bounded.fit(
            unknowns, lambda values: vectors([values])[0], OneSided((_STEP,)), Stop(steps, 1e-5, 1e-6, of_promise=PROMISE), many=vectors
        )
        std = dict(zip(found.values, np.sqrt(np.maximum(np.diag(found.covariance), 0.0)).tolist(), strict=True))
        return MachineFit(effect, {**first, **found.values}, std, found.cost)

    def with_whole_std(self, fit: MachineFit) -> MachineFit:
        """The fit with standard errors that hold what it leaves unexplained, beside those of noise and scatter."""
        evidence = self.evidence
        left = misfit(fit.cost, self.floor, evidence.numbers, evidence.counting)
        own = {name: whole_std(std, left, name, fit.values[name] - self.actuator[row_of(name).name]) for name, std in fit.std.items()}
        return replace(fit, std=own)

    def _unknown(self, name: str, first: float, ends: tuple[float, float] | None) -> FreeValue:
        lower, upper = ends or self._ends(name)
        return FreeValue(name, first, self._scale(name, first), lower, upper)

    def _ends(self, name: str) -> tuple[float, float]:
        """Where a value may lie."""
        row = row_of(name)
        if name in self.scatter:
            lower, upper = self._day(name)
            return max(lower, row.lower), min(upper, row.upper)
        return row.lower, row.upper

    def _day(self, name: str) -> tuple[float, float]:
        """How far a day may take what scatters."""
        one = self.scatter[name]
        if not one.relative:
            return self.actuator[name] - _CREDIBLE * one.std, self.actuator[name] + _CREDIBLE * one.std
        # few records show little of it
        today = next((std for names, std in spreads.OF_TODAY.items() if name in names), 0.0)
        reach = max(_CREDIBLE * one.std, _FAR * today if self.evidence.relative else 0.0)
        return (1.0 - reach) * self.actuator[name], (1.0 + reach) * self.actuator[name]

    def _scale(self, name: str, first: float) -> float:
        if name.endswith("phase_rad"):
            return _PHASE_SCALE
        if name in self.scatter and not self.scatter[name].relative:
            return self.scatter[name].std * SMALL_SHARE / _STEP
        return max(abs(first), 1e-9 if name.startswith("effects.") else 0.3 * abs(self.actuator[name]))

    def base(self, estimates: Mapping[str, float]) -> MachineFit:
        """CSJ and BLK alone, from their healthy values and from `estimates`: the better of both."""
        healthy = {name: self.actuator[name] for name in self.faults}
        found = {name: max(estimates.get(name, healthy[name]), 0.2 * healthy[name]) for name in healthy}
        fits = each(lambda start: self.fit("", start, self.free, LAST_STEPS), (healthy,) if found == healthy else (healthy, found))
        return min((one for one in fits if one is not None), key=lambda one: one.cost)

    def plain(self, base: MachineFit) -> bool:
        """Whether the residual is as small as those of healthy repeats; without them, in every signal as small as its sensor's noise, over the whole record and in every part of it."""
        left = self.evidence.target - self.signals(base.values)
        if self.evidence.relative:
            return base.cost < _PLAIN * self._largest and self._lasting_below(left, self._lasting_of_repeats())
        left = left - left.mean(axis=1, keepdims=True)
        size = np.sqrt(np.mean(self.evidence.target**2, axis=1))
        rms = np.sqrt(np.mean(left**2, axis=1))
        even = bool(np.all(rms <= np.maximum(_PLAIN * self._level[:, 0], _NOISELESS * size)))
        return even and self._lasting_below(left, np.full(len(left), _LASTING))

    def _lasting(self, left: Reals) -> Reals:
        """What stays in the signals [channels, rows] for longer than noise does, rms over each part of the record, in the noise of one row, [channels, parts]."""
        channels, rows = left.shape
        block = min(_BLOCK_ROWS, rows // _PARTS)
        count = rows // (_PARTS * block)
        means = left[:, : _PARTS * count * block].reshape(channels, _PARTS, count, block).mean(axis=3)
        noise = np.sqrt(np.mean(self.evidence.noise, axis=1, keepdims=True))
        return np.asarray(np.sqrt(np.mean(means**2, axis=2)) / noise)

    def _lasting_of_repeats(self) -> Reals:
        """The most that any part of any healthy repeat shows against the others, [channels], with room for a record that is no repeat."""
        here = self.signals({})
        most = np.max([self._lasting(repeat - here) for repeat in self.evidence.repeats], axis=(0, 2))
        return np.asarray(np.maximum(_OVER_REPEATS * most, _LASTING))

    def _lasting_below(self, left: Reals, limit: Reals) -> bool:
        return bool(np.all(self._lasting(left) <= limit[:, None]))

    def at_reach(self, base: MachineFit) -> bool:
        """Whether grease or winding would have to go farther than a day takes them."""
        ends = {name: self._day(name) for name in self.scatter}
        return any(
            not lower + _NEAR * (upper - lower) < base.values[name] < upper - _NEAR * (upper - lower)
            for name, (lower, upper) in ends.items()
        )

    def left_of(self, base: MachineFit) -> float:
        """What a fit leaves beyond noise, over what CSJ and BLK explain in it."""
        healthy = self.residual({**base.values, **{name: self.actuator[name] for name in self.faults}})
        explained = float(healthy @ healthy) - base.cost
        return max(base.cost - self.floor, 0.0) / explained if explained > 0.0 else float("inf")

    def starts(self, base: MachineFit, only: str | None = None, held: str = "") -> list[Start]:
        """Where the fit of each effect, or of `only` one, begins, one start for each sign: the shape and size whose signature at the base explains most.

        CSJ and BLK are free there, but for the one `held`.
        """
        machine = self.actuator.changed(base.values)
        free = tuple(Spread((name,), _FREE, True) for name in self.faults if machine[name] > 0.0 and name != held)
        here = view(
            replace(self.evidence, actuator=machine, spread=(*free, *self.scatter.values())),
            {},
        )
        tasks = [
            (candidate, first)
            for candidate in candidates(Screen(here), only=only)
            if candidate.effect not in FAULTS
            for first in candidate.first
        ]

        def scored(vector: Reals) -> tuple[float, float]:
            length = float(vector @ vector)
            share = float(np.clip(float(vector @ here.residual) / length, 0.0, 100.0)) if length > 0.0 else 0.0
            kept = min(share, 1.0)
            return 2.0 * kept * float(vector @ here.residual) - kept**2 * length, share

        # side by side a signature takes a third of what it takes alone
        found = here.of_signatures([candidate.changes(first) for candidate, first in tasks], scored)
        best: dict[tuple[str, bool], tuple[float, dict[str, float]]] = {}
        for (candidate, first), one in zip(tasks, found, strict=True):
            gain, share = (0.0, 0.0) if isinstance(one, InputError) else one
            key = (candidate.effect, first > candidate.zero)
            if key not in best or gain > best[key][0]:
                wanted = candidate.zero + (first - candidate.zero) * float(np.clip(share, 0.5, 20.0))
                best[key] = (gain, candidate.changes(float(np.clip(wanted, candidate.lower, candidate.upper))))
        return [Start(effect, start, gain) for (effect, _), (gain, start) in best.items()]


def live(*records: Record) -> tuple[str, ...]:
    """Signals that all records have and that change: a sensor that is not connected says nothing."""
    return tuple(name for name in common_channels(records) if all(np.ptp(one.recorded(name)) > 0.0 for one in records))


def silent(record: Record) -> tuple[str, ...]:
    """Signals of the record that do not change, and are left out of what it says."""
    moving = live(record)
    return tuple(name for name in common_channels([record]) if name not in moving)


def blocked(actuator: Actuator, record: Record) -> str:
    """Why no answer from a record means anything, by its validity; empty where it may answer. Sensors that are not connected are left out."""
    return blocks(remarks_of(actuator, record))


def blocks(remarks: Sequence[RecordRemark]) -> str:
    """The first of the remarks that blocks; empty where none does."""
    return next((f"{one.text}: {one.next}" for one in remarks if one.severity == "blocks"), "")


def disturbs(remarks: Sequence[RecordRemark]) -> str:
    """The first of the remarks on what a sensor or recorder did in a part of the record and no machine does; empty where none is. What is unknown in such a record may be that."""
    return next((f"{one.text}: {one.next}" for one in remarks if one.sensor), "")


def remarks_of(actuator: Actuator, record: Record) -> tuple[RecordRemark, ...]:
    """Of a record's validity. Sensors that are not connected are left out."""
    left_out: dict[str, Any] = {name: None for name in silent(record) if name != "position_mm"}
    return judge(actuator, replace(record, **left_out)).remarks


@dataclass(frozen=True)
class Compared:
    """A record beside what is known of its machine. `unit`: the evidence as it was gathered; `repeats`: healthy records of its command behind it, two or more, or none;
    `signals`: that are compared."""

    unit: Evidence
    repeats: tuple[Record, ...]
    signals: tuple[str, ...]

    @cached_property
    def known(self) -> KnownMachine:
        """The record of a machine of which CSJ and BLK are sought."""
        return KnownMachine(self.unit if self.repeats else as_known(self.unit))

    @cached_property
    def known_repeats(self) -> list[KnownMachine]:
        """The same of each healthy repeat against the others."""
        return [self.known.of_repeat(place) for place in range(len(self.repeats))]

    @property
    def actuator(self) -> Actuator:
        """The machine that is known: as the file says, or as the healthy repeats show it."""
        return self.unit.actuator

    def corrected(self, record: Record) -> Record:
        """The record without what stays between the healthy machine and its model; itself without repeats."""
        return self._with(record, self.unit.target) if self.repeats else record

    def corrected_repeats(self) -> list[Record]:
        """Each healthy repeat against the others, in the same way."""
        return [self._with(one, target) for one, target in zip(self.repeats, self.unit.repeats, strict=True)]

    def of_runs(self, read: Sequence[float]) -> list[float]:
        """What was read of each of `corrected_repeats` or `known_repeats`, as the runs themselves lie about their mean: each is held there against the others, as far apart as today's record
        against them all, and lies farther from their mean than from that of all."""
        apart = np.sqrt((len(read) + 1.0) / (len(read) - 1.0))
        mean = float(np.mean(read))
        return [mean + (one - mean) / float(apart) for one in read]

    def _with(self, record: Record, signals: Reals) -> Record:
        return replace(record, **dict(zip(self.signals, signals, strict=True)))


def repeats_of(record: Record, healthy: Sequence[Record]) -> tuple[Record, ...]:
    """Of the healthy records those of the record's command, where they are enough to tell repeatability and the rod moves; else none."""
    same = tuple(other for other in healthy if same_command(record, other))
    return same if len(same) > 1 and "position_mm" in live(record, *same) else ()


def compared(actuator: Actuator, record: Record, healthy: Sequence[Record]) -> Compared:
    """The record beside its actuator's file, or beside two or more `healthy` records of its command. Raises InputError as `gather` does."""
    repeats = repeats_of(record, healthy)
    signals = live(record, *repeats)
    return Compared(gather(actuator, record, repeats, signals), repeats, signals)


def known_machine(actuator: Actuator, record: Record) -> Evidence:
    """Evidence of a record of a machine that is as `actuator` says, of which only grease, winding and what the file states scatter from run to run; CSJ and BLK are left to be fitted."""
    return as_known(gather(actuator, record, channels=live(record)))


def as_known(unit: Evidence) -> Evidence:
    """The evidence with the free values of a machine that is known."""
    return replace(unit, spread=spreads.from_day_to_day(unit.actuator))
