"""What a record says beyond what is already known of the machine.

Some of the model's parameters move within a known spread: from run to run, or as units differ from their data sheet. They stay in every answer as directions with that spread,
not as free parameters, so that a change of the same parameter beyond it can still be named. `select.baseline` makes evidence from records.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TypeVar

import numpy as np
from scipy.optimize import lsq_linear

from ema_tools.base.arrays import Complexes, Reals
from ema_tools.base.errors import InputError, taken
from ema_tools.base.orthonormal import orthonormal
from ema_tools.base.parallel import each, idle
from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record
from ema_tools.fit import nuisance as spreads
from ema_tools.fit.nuisance import Spread
from ema_tools.fit.whitening import Whitener, counted
from ema_tools.library.faults import effect_of
from ema_tools.plant.native import library

Seen = TypeVar("Seen")

_SIDE_BY_SIDE = 16  # runs of one call at most: so many go through a model step together, further ones are for another core [effort]
_DERIVATIVE_STEP = 0.01  # of a value: large against rounding and reversals that jump a step, small against nonlinearity [precision]
_DERIVATIVE_STEP_STD = 0.1  # of a spread, where the value is zero [precision]
ROUGHNESS = 12.0  # differences smaller than this, in standard deviations of noise, may be the model's own roughness [precision]
_CREDIBLE = 3.0  # how far what scatters may go, in spreads: more is not credible [chance]
# How far the machine may stand in for what is missing, in spreads: beyond, one parameter runs away against another and comes back
# slowly [judgement]
FAR = 12.0
FAR_ROUNDS = 12  # of linear steps on the way there, which is long and bends [effort]
_ROUNDS = 6  # of linear steps where what scatters stays credible [effort]
_SETTLED = 1e-4  # of the cost: a step that lowers it by less was the last [precision]
_CHORDS = 4  # steps by the directions of one place, which cost a tenth of new ones [effort]
_WORTH_A_CHORD = 1e-3  # share of the cost: a step that takes off less is the last by these directions [effort]
_SHARES = (1.0, 0.4, 0.1)  # a step that overshoots, where what scatters bends, is taken in part [judgement]


def simulate_channels(actuator: Actuator, record: Record, channels: Sequence[str], start_mm: float) -> Reals:
    """The model under the record's command from rest at `start_mm`, [channels, rows]. Raises InputError when the model refuses."""
    values, options = actuator.arrays()
    run = library(32).simulate(values, options, record.command_mm, start_mm)
    return np.array([getattr(run, name) for name in channels])


def simulate_side_by_side(
    actuator: Actuator,
    changes: Sequence[Mapping[str, float]],
    record: Record,
    channels: Sequence[str],
    start_mm: float,
    seen: Callable[[int, Reals], Seen],
) -> list[Seen | InputError]:
    """What `seen` makes of the place of each of several changes of values and of the signals `simulate_channels` with it, the same bits; the error in the place of one
    that the model refuses. On all cores: `seen` is called from several threads.
    """
    found: dict[int, Seen | InputError] = {}
    alike: dict[tuple[str, ...], list[tuple[int, Actuator]]] = {}
    for place, change in enumerate(changes):
        try:
            changed = actuator.changed(change)
        except InputError as error:
            found[place] = error
        else:
            alike.setdefault(changed.effects_in_motion, []).append((place, changed))

    def share(part: Sequence[tuple[int, Actuator]]) -> None:
        arrays = [changed.arrays() for _, changed in part]
        runs = library(32).simulate_many(np.array([values for values, _ in arrays]), arrays[0][1], record.command_mm, channels, start_mm)
        for (place, _), run in zip(part, runs, strict=True):
            found[place] = run if isinstance(run, InputError) else seen(place, run)

    size = min(_SIDE_BY_SIDE, max(1, -(-len(changes) // idle())))
    parts = [group[first : first + size] for group in alike.values() for first in range(0, len(group), size)]
    # the long ones first, so that no core waits for another at the end
    each(share, sorted(parts, key=len, reverse=True))
    return [found[place] for place in range(len(changes))]


def slope_step(one: Spread) -> float:
    """How far to take a spread for its slope, in its standard deviations."""
    if one.step:
        return one.step
    return _DERIVATIVE_STEP / (one.std * max(map(abs, one.shares), default=1.0)) if one.relative else _DERIVATIVE_STEP_STD


def directions_of(
    actuator: Actuator, record: Record, channels: tuple[str, ...], start_mm: float, spread: Sequence[Spread]
) -> tuple[Reals, Reals]:
    """The model's signals under the record's command [channels, rows], and what one standard deviation of each spread makes of them, [spread, channels, rows]."""
    here = simulate_channels(actuator, record, channels, start_mm)

    def moved(one: Spread) -> Reals:
        step = slope_step(one)
        found = (simulate_channels(actuator.changed(one.changes(actuator, step)), record, channels, start_mm) - here) / step
        if one.cause == spreads.ASKED and "voltage_V" in channels:
            found[channels.index("voltage_V")] -= one.std * here[channels.index("voltage_V")]
        return found

    return here, np.array(each(moved, spread)).reshape(len(spread), *here.shape)


def measured_channels(record: Record, channels: Sequence[str]) -> Reals:
    """The record's signals, [channels, rows]."""
    return np.array([record.recorded(name) for name in channels])


@dataclass(frozen=True)
class Step:
    """Where to take the model: effects at `changes`, spread values at `deviations` [spread]; what comes of it counts per `size`."""

    changes: Mapping[str, float]
    deviations: Reals
    size: float = 1.0


@dataclass(frozen=True)
class Evidence:
    """A record against what is known. `target` [channels, rows]: what the model should show; `actuator`: the model that is known so far; `spread`: what of it moves.

    `repeats`: the same for each healthy repeat against the others, what a record with nothing new looks like; empty without repeats. `floor`: without repeats, the
    cost that sensor noise alone has. `counting`: with repeats, the cost that counts of the sensors may add on another way than theirs;
    `freedom`: with repeats, the degrees of freedom to which these and the usual tell how far `spread` scatters.
    `noise` [channels, lines]: power of one run's noise. `additive` [k, channels, rows]: signals that may be in the record with a standard deviation
    of 1 each, such as the zero of a sensor; `slight`: changes of the model `unit` that the last of them are, by effects that every machine has a little of; `varies`: with repeats, what the
    first of them stand for; `of_known`: the same evidence where only friction, grease and winding vary, for who takes the machine for known;
    `supplied`: by how much, relative, the record's supply gives more than the one of which its voltage was asked, which is counted in already.
    """

    actuator: Actuator
    record: Record
    channels: tuple[str, ...]
    target: Reals
    spread: tuple[Spread, ...]
    whiten: Whitener
    noise: Reals = field(repr=False)
    additive: Reals
    start_mm: float
    repeats: tuple[Reals, ...] = ()
    floor: float = 0.0
    counting: float = 0.0
    freedom: float = math.inf
    slight: tuple[Mapping[str, float], ...] = ()
    unit: Actuator | None = None
    varies: tuple[Spread, ...] = ()
    of_known: Evidence | None = None
    supplied: float = 0.0

    @property
    def granted(self) -> tuple[str, ...]:
        """Effects of `slight`."""
        return tuple(dict.fromkeys(effect_of(next(iter(changes))) for changes in self.slight))

    @property
    def relative(self) -> bool:
        """Whether healthy repeats stand behind it."""
        return bool(self.repeats)

    def released(self, effect: str) -> bool:
        """Whether a little of an effect would be granted, and a first look found more of it."""
        return spreads.is_free(effect) and effect not in self.granted

    def expected_cost(self) -> float:
        """The cost of a record with nothing new: the mean of the healthy repeats', else what sensor noise alone has."""
        return float(np.mean([residual @ residual for residual in self.of_repeats])) if self.repeats else self.floor

    @cached_property
    def of_repeats(self) -> list[Reals]:
        """What each healthy repeat says against the others, vectors [n] seen from the healthy machine."""
        if not self.repeats:
            return []
        known = view(self, {})
        return [known.residual_of(target) for target in self.repeats]

    def of_machine(self, actuator: Actuator, added: Reals) -> Evidence:
        """The same of a machine that has changed since its baseline records, to which that adds `added` [channels, rows]."""
        known = self.of_known.of_machine(actuator, added) if self.of_known is not None else None
        return replace(self, actuator=actuator, repeats=tuple(repeat + added for repeat in self.repeats), of_known=known)

    def on_supply(self, share: float) -> Evidence:
        """The same where the record's voltage was asked of a supply that gives more by a share in all: that is what was given."""
        record = self.record.on_supply((1.0 + share) / (1.0 + self.supplied) - 1.0)
        target = self.target.copy()
        target[self.channels.index("voltage_V")] += record.recorded("voltage_V") - self.record.recorded("voltage_V")
        known = self.of_known.on_supply(share) if self.of_known is not None else None
        return replace(self, record=record, target=target, of_known=known, supplied=share)

    @cached_property
    def fixed(self) -> _Fixed:
        """`additive`, whitened, with what its deviations cost."""
        vectors, count = [self.whiten(signals) for signals in self.additive], len(self.spread) + len(self.additive)
        rows = (vectors[0].size if vectors else self.whiten(self.target).size) + count
        columns = _tall_columns(vectors, len(self.spread), rows, count)
        return _Fixed(columns, *orthonormal(columns))

    def without(self, channel: str) -> Evidence:
        """The same of the other signals."""
        kept = [place for place, name in enumerate(self.channels) if name != channel]
        return replace(
            self,
            channels=tuple(self.channels[place] for place in kept),
            target=self.target[kept],
            whiten=Whitener(self.whiten.weights[kept]),
            noise=self.noise[kept],
            additive=self.additive[:, kept],
            repeats=tuple(repeat[kept] for repeat in self.repeats),
            of_known=self.of_known.without(channel) if self.of_known is not None else None,
        )

    @property
    def numbers(self) -> int:
        """Independent numbers in the record's signals."""
        channels, rows = self.target.shape
        return int(channels * counted(rows))

    def simulate(self, changes: Mapping[str, float], deviations: Reals) -> Reals:
        """Signals [channels, rows] of the model with effects at `changes` and its spread values at `deviations` [spread] of their spread."""
        values = {**spreads.moved(self.actuator, self.spread, deviations), **changes}
        return simulate_channels(self.actuator.changed(values), self.record, self.channels, self.start_mm)

    def whitened(self, asked: Sequence[Step], base: Reals, seen: Callable[[Reals], Seen]) -> list[Seen | InputError]:
        """`seen` of what each of several steps makes beyond `base` [channels, rows], over its size and whitened, [n] each; the error in the place of one that the model refuses."""
        changes = [{**spreads.moved(self.actuator, self.spread, one.deviations), **one.changes} for one in asked]
        return simulate_side_by_side(
            self.actuator,
            changes,
            self.record,
            self.channels,
            self.start_mm,
            lambda place, run: seen(self.whiten((run - base) / asked[place].size)),
        )


@dataclass(frozen=True)
class Sensitivity:
    """What a change makes of the model as seen from a view: `vector` [n] with nothing taken off, and its parts `shared` [k] along what is. What is left is not formed: products suffice,
    and taking hundreds of vectors apart costs more than simulating them."""

    vector: Reals
    shared: Reals
    view: View

    @property
    def square(self) -> float:
        """Squared length of what is left."""
        return float(self.vector @ self.vector) - float(self.shared @ self.shared)

    def product(self, other: Reals) -> float:
        """What is left times any vector [n]."""
        return float(self.vector @ other) - float(self.shared @ self.view.shared(other))

    def with_other(self, other: Sensitivity) -> float:
        """What is left of both, times each other."""
        return float(self.vector @ other.vector) - float(self.shared @ other.shared)

    def with_residual(self) -> float:
        """What is left times the view's residual, which shares nothing with what is taken off."""
        return float(self.vector @ self.view.residual)

    def seen_from(self, view: View, of_residual: Reals, overlap: Reals) -> tuple[float, float]:
        """Product with another view's residual, and squared length, of what both views leave; `of_residual` [k]: that residual along what this view takes off, `overlap`: of the other view
        with this one."""
        product = float(self.vector @ view.residual) - float(self.shared @ of_residual)
        both = view.shared(self.vector) - overlap @ self.shared
        return product, self.square - float(both @ both)


@dataclass(frozen=True)
class _Fixed:
    """`Evidence.additive` as columns [n, a], and as an orthonormal `basis` [n, a] times `square` [a, a]: the same from wherever the evidence is seen."""

    columns: Reals
    basis: Reals
    square: Reals


@dataclass(frozen=True)
class _Directions:
    """What scatters, per spread: as columns [n, k] those of `own` [n, spread] and then the `fixed` ones, and as an orthonormal basis, of the fixed ones and then of what `own` has beside them,
    [n, spread], times `square` [k, k]."""

    own: Reals
    fixed: _Fixed
    beside: Reals
    square: Reals

    @staticmethod
    def of(own: Reals, fixed: _Fixed) -> _Directions:
        along = fixed.basis.T @ own
        beside, square = orthonormal(np.asfortranarray(own - fixed.basis @ along))
        none = np.zeros((len(square), len(fixed.square)))
        return _Directions(own, fixed, beside, np.block([[along, fixed.square], [square, none]]))

    @property
    def columns(self) -> Reals:
        """All together, [n, k]."""
        return np.column_stack([self.own, self.fixed.columns])

    @property
    def blocks(self) -> tuple[Reals, ...]:
        """The basis in parts that are orthogonal to each other."""
        return (self.fixed.basis, self.beside)


@dataclass(frozen=True)
class _Place:
    """One set of values and deviations, before its directions are known: `base` [channels, rows] of the model, `plain` [n]: what is left there with nothing taken off."""

    at: Reals
    base: Reals
    plain: Reals

    @property
    def cost(self) -> float:
        """Squared residual with what scatters where it is, and what that costs."""
        return float(self.plain @ self.plain)


@dataclass(frozen=True)
class View:
    """The evidence as seen from one set of effects, linear in what scatters: vectors are whitened and have the scatter's directions taken off.

    `values`: of the effects; `residual` [n].
    """

    evidence: Evidence
    values: Mapping[str, float]
    residual: Reals
    _place: _Place = field(repr=False)
    _scatter: _Directions = field(repr=False)
    _blocks: tuple[Reals, ...] = field(repr=False)

    @property
    def deviations(self) -> Reals:
        """Of what scatters, in spreads, [spread + additive]."""
        return self._place.at

    @property
    def at_edge(self) -> bool:
        """Whether anything that scatters has gone as far as is credible: what would take it farther is then seen bent."""
        return bool(np.any(np.abs(self.deviations) >= _CREDIBLE))

    @property
    def base(self) -> Reals:
        """The model there, [channels, rows]."""
        return self._place.base

    @property
    def cost(self) -> float:
        """Squared residual with the scatter at its best."""
        return float(self.residual @ self.residual)

    def residual_of(self, target: Reals) -> Reals:
        """What is left of another target [channels, rows], [n]."""
        return self._without(_left(self.evidence, self.base, self.deviations, target))

    def projected(self, signals: Reals) -> Reals:
        """Signals [channels, rows] as a vector [n]."""
        return self._without(self._tall(signals))

    def _tall(self, signals: Reals) -> Reals:
        return np.concatenate([self.evidence.whiten(signals), np.zeros(self.deviations.size)])

    def _without(self, tall: Reals) -> Reals:
        return _without(self._blocks, tall)

    def moved(self, changes: Mapping[str, float]) -> Reals:
        """What `changes` beside the view's own values make of the model, [n], nothing taken off. Raises InputError when the model refuses them."""
        own = self.deviations[: len(self.evidence.spread)]
        return self._tall(self.evidence.simulate({**self.values, **changes}, own) - self.base)

    def sensitivities(self, asked: Sequence[Mapping[str, float]]) -> list[Sensitivity | InputError]:
        """As `signature` of each of several changes, for products alone, side by side; the error in the place of changes that the model refuses."""
        return self._each_moved(asked, lambda vector: Sensitivity(vector, self.shared(vector), self))

    def signatures(self, asked: Sequence[Mapping[str, float]]) -> list[Reals | InputError]:
        """`signature` of each of several changes, side by side; the error in the place of changes that the model refuses."""
        return self._each_moved(asked, self._without)

    def of_signatures(self, asked: Sequence[Mapping[str, float]], seen: Callable[[Reals], Seen]) -> list[Seen | InputError]:
        """`seen` of `signatures`, which are not held all at once; it is called from several threads."""
        return self._each_moved(asked, lambda moved: seen(self._without(moved)))

    def _each_moved(self, asked: Sequence[Mapping[str, float]], seen: Callable[[Reals], Seen]) -> list[Seen | InputError]:
        """`seen` of what each of several changes makes of the model, [n], nothing taken off."""
        own, none = self.deviations[: len(self.evidence.spread)], np.zeros(self.deviations.size)
        steps = [Step({**self.values, **changes}, own) for changes in asked]
        return self.evidence.whitened(steps, self.base, lambda moved: seen(np.concatenate([moved, none])))

    def shared(self, vector: Reals) -> Reals:
        """Parts of a vector [n] along the directions that are taken off, [k]."""
        return _along_each(self._blocks, vector)

    def overlap(self, other: View) -> Reals:
        """Products of the directions that are taken off here and there, [k, k of the other]."""
        return np.block([[np.eye(one.shape[1]) if one is its else one.T @ its for its in other._blocks] for one in self._blocks])

    def beside(self, vectors: Sequence[Reals]) -> View:
        """The same with further `vectors` [n] taken off: what may move freely besides, such as the values of effects that are fitted again with every new one."""
        kept = [vector for vector in vectors if float(vector @ vector) > 0.0]
        if not kept:
            return self
        more, _ = np.linalg.qr(np.array(kept).T)
        wider = replace(self, _blocks=(*self._blocks, np.asfortranarray(more)))
        return replace(wider, residual=wider._without(self.residual))

    def signature(self, changes: Mapping[str, float]) -> Reals:
        """What `changes` beside the view's own values make of the model, [n]. Raises InputError when the model refuses them."""
        return self._without(self.moved(changes))

    def unwhitened(self) -> Complexes:
        """The residual's lines [channels, lines] weighted once more: their product with a signal's lines is the product of whitened vectors."""
        count = self.deviations.size
        return self.evidence.whiten.lines(np.ascontiguousarray(self.residual[: self.residual.size - count])) * self.evidence.whiten.weights

    @property
    def nuisance_curvature(self) -> Reals:
        """Half the second derivative of the cost about what scatters, its prior included, [spread + additive, spread + additive]."""
        return np.asarray(self._scatter.square.T @ self._scatter.square)

    def doubt(self, place: int) -> float:
        """Standard deviation, in spreads, to which the record and all priors together determine one of the deviations."""
        return float(np.linalg.norm(np.linalg.inv(self._scatter.square)[place]))

    @property
    def plain(self) -> Reals:
        """The residual with what scatters where it is, [n]: nothing taken off."""
        return self._place.plain

    @property
    def plain_cost(self) -> float:
        """Squared residual with what scatters where it is, and what that costs."""
        return self._place.cost

    def free_slopes(self, around: Mapping[str, Sequence[tuple[float, float]]]) -> Reals:
        """What the view's values named in `around`, per unit, between the first two of those given there that differ by more than the model's own roughness,
        and then what scatters, per spread, make of the signals and of what the scatter costs, columns [n, names + spread + additive].

        Taken over both sides: what two unknowns that do the same differ by is smaller than how either bends. Where the model refuses one of the sides, what scatters keeps the
        view's own direction, and a value has none.
        """
        own = self.deviations[: len(self.evidence.spread)]
        none = np.zeros(self.deviations.size)

        def of_value(name: str) -> Reals:
            found = np.zeros(self.residual.size - none.size)
            for low, high in around[name]:
                try:
                    moved = self.evidence.whiten(
                        self.evidence.simulate({**self.values, name: high}, own) - self.evidence.simulate({**self.values, name: low}, own)
                    )
                except InputError:
                    break
                found = moved / (high - low)
                if float(moved @ moved) > ROUGHNESS**2:
                    break
            return np.concatenate([found, none])

        def of_spread(place: int) -> Reals:
            one = self.evidence.spread[place]
            step = 2.0 * _DERIVATIVE_STEP / one.std if one.relative else _DERIVATIVE_STEP_STD
            apart = np.zeros(own.size)
            apart[place] = step
            try:
                moved = self.evidence.simulate(self.values, own + apart) - self.evidence.simulate(self.values, own - apart)
            except InputError:
                return self._scatter.own[: self.residual.size - none.size, place]
            return self.evidence.whiten(moved) / (2.0 * step)

        found = self._scatter.columns
        for place, column in enumerate(each(of_spread, list(range(own.size)))):
            found[: column.size, place] = column
        return np.column_stack([*each(of_value, list(around)), found])

    def at(self, values: Mapping[str, float], deviations: Reals, scatter: Reals | None = None) -> View:
        """The evidence seen from other values and deviations, what of `spread` scatters moving it as the columns `scatter` [n, spread] say, else as it does here: one run of the model.

        Raises InputError when the model refuses.
        """
        there = _place(self.evidence, values, deviations)
        return _along(self.evidence, values, there, self._scatter if scatter is None else _Directions.of(scatter, self.evidence.fixed))

    def linear_here(self) -> View:
        """The same with what scatters linear right here."""
        return _seen(self.evidence, self.values, self._place)

    def best_deviations(self, vector: Reals | None = None, reach: float = _CREDIBLE) -> Reals:
        """Deviations at their best, [spread + additive], with an effect's unprojected `vector` taken off first; no farther than `reach`, which is credible.

        Where an effect is missing, what scatters would run away to stand in for it, and the effect would then be sought from there.
        """
        tall = self.plain if vector is None else self.plain - vector
        if not self.deviations.size:
            return self.deviations
        # bounded, not clipped: what one direction may not do, the others then do not answer
        step = lsq_linear(
            self._scatter.square,
            _along_each(self._scatter.blocks, tall),
            (-reach - self.deviations, reach - self.deviations),
            method="bvls",
        ).x
        return np.asarray(np.clip(self.deviations + step, -reach, reach))


def _place(evidence: Evidence, values: Mapping[str, float], at: Reals) -> _Place:
    count = len(evidence.spread)
    base = evidence.simulate(values, at[:count])
    return _Place(at, base, _left(evidence, base, at, evidence.target))


def _left(evidence: Evidence, base: Reals, at: Reals, target: Reals) -> Reals:
    """What is left of a target [channels, rows] with nothing taken off, [n]."""
    shift = np.tensordot(at[len(evidence.spread) :], evidence.additive, 1)
    return np.concatenate([evidence.whiten(target - base - shift), at])


def _seen(evidence: Evidence, values: Mapping[str, float], place: _Place) -> View:
    """The evidence linear at a place."""
    own = place.at[: len(evidence.spread)]

    def toward(k: int) -> Step:
        one = evidence.spread[k]
        step = slope_step(one)
        near = own.copy()
        near[k] += step
        return Step(values, near, step)

    moved = taken(evidence.whitened([toward(k) for k in range(own.size)], place.base, np.asarray))
    return _along(evidence, values, place, _Directions.of(_tall_columns(moved, 0, place.plain.size, place.at.size), evidence.fixed))


def _tall_columns(vectors: Sequence[Reals], first: int, rows: int, count: int) -> Reals:
    """Vectors with what their own deviations cost, of which there are `count` and theirs begin at `first`, as columns [rows, vectors]."""
    found = np.zeros((len(vectors), rows))
    for k, vector in enumerate(vectors):
        found[k, : rows - count] = vector
        found[k, rows - count + first + k] = -1.0
    return found.T


def _along(evidence: Evidence, values: Mapping[str, float], place: _Place, scatter: _Directions) -> View:
    """The evidence at a place where what scatters moves it as it does somewhere near."""
    return View(evidence, values, _without(scatter.blocks, place.plain), place, scatter, scatter.blocks)


def _along_each(blocks: Sequence[Reals], vector: Reals) -> Reals:
    """Parts of a vector [n] along an orthonormal basis of several blocks [n, k each], [k in all]."""
    return np.concatenate([block.T @ vector for block in blocks])


def _without(blocks: Sequence[Reals], vector: Reals) -> Reals:
    """A vector [n] without its parts along an orthonormal basis of several blocks [n, k each]."""
    left = vector
    for block in blocks:
        left = left - block @ (block.T @ left)
    return left


def view(evidence: Evidence, values: Mapping[str, float], deviations: Reals | None = None) -> View:
    """The evidence seen from `values` of effects; `deviations` of what scatters are zero unless told."""
    at = np.zeros(len(evidence.spread) + len(evidence.additive)) if deviations is None else deviations
    return _seen(evidence, values, _place(evidence, values, at))


def raw_cost(evidence: Evidence) -> float:
    """Cost of the record against the model as known, nothing of it moved."""
    own = np.zeros(len(evidence.spread))
    return float(np.sum(evidence.whiten(evidence.target - evidence.simulate({}, own)) ** 2))


def cost_at(evidence: Evidence, values: Mapping[str, float], deviations: Reals) -> float:
    """Cost of the record against effects at `values` and what scatters at `deviations` [spread + additive], that of the scatter included: one run of the model.

    Raises InputError when the model refuses.
    """
    return _place(evidence, values, deviations).cost


def settled(
    evidence: Evidence, values: Mapping[str, float], deviations: Reals | None = None, rounds: int = _ROUNDS, reach: float = _CREDIBLE
) -> View:
    """The view after what scatters has moved to where it is best, as far as `rounds` of linear steps bring it, no farther than `reach`."""
    here = view(evidence, values, deviations)
    if not evidence.spread:
        return here
    for _ in range(rounds):
        there = _moved(here, reach)
        if there is None:
            break
        done = here.plain_cost - there.cost < _SETTLED * there.cost
        try:
            here = _seen(evidence, values, there)
        except InputError:
            # at the edge of what the model takes: what scatters cannot be moved any further there
            break
        if done:
            break
    return here


def _moved(here: View, reach: float) -> _Place | None:
    """Where the steps by one view's directions end, each of them as much of a step to the best deviations as lowers the cost; None when none does."""
    found: _Place | None = None
    for _ in range(_CHORDS):
        step = here.best_deviations(reach=reach) - here.deviations
        if not step.any():
            # all that may move lies at its reach: every share of the step would be the same run again
            break
        there = next((place for place in _tried(here, step) if place.cost < here.plain_cost), None)
        if there is None:
            break
        found = there
        if here.plain_cost - there.cost < _WORTH_A_CHORD * there.cost:
            break
        here = _along(here.evidence, here.values, there, here._scatter)
    return found


def _tried(here: View, step: Reals) -> Iterator[_Place]:
    """Smaller and smaller shares of a step, without those too far for the model."""
    for share in _SHARES:
        with suppress(InputError):
            yield _place(here.evidence, here.values, here.deviations + share * step)
