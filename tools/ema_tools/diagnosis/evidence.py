"""What a record says beyond what is already known of the machine.

With healthy repeats of the same command, the model is first fitted to their mean; the record is then compared with that mean, so that a standing error of the model,
which is in both, drops out. Noise is estimated per channel and frequency from how the repeats differ, after the share that a scatter of the machine's own parameters
explains (friction, grease, winding) has been taken off. Without repeats the record is compared with the model itself, and the parameters are free within what a data
sheet leaves open.

Either way some of the model's parameters move within a known spread. They stay in every answer as directions with that spread, not as free parameters, so that a
change of the same parameter beyond it can still be named.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ema_tools.actuator import Actuator
from ema_tools.diagnosis import spread as spreads
from ema_tools.diagnosis.spread import Spread
from ema_tools.diagnosis.whitening import Reals, Whitener, least_noise, smoothed, spectrum, white_level
from ema_tools.errors import InputError
from ema_tools.native import CHANNELS, library
from ema_tools.parallel import each
from ema_tools.records import Record, start_of

_USUAL_WEIGHT = 4.0  # the usual scatter counts as much as this many repeats that had shown it
_DERIVATIVE_STEP = 0.01  # of a value: large against rounding and reversals that jump a step, small against nonlinearity
_DERIVATIVE_STEP_STD = 0.1  # of a spread, where the value is zero
_ROUNDS = 6
_SETTLED = 1e-4


def simulate_channels(actuator: Actuator, record: Record, channels: Sequence[str], start_mm: float) -> Reals:
    """The model under the record's command from rest at `start_mm`, [channels, rows]. Raises InputError when the model refuses."""
    values, options = actuator.arrays()
    run = library(32).simulate(values, options, record.command_mm, start_mm)
    return np.array([getattr(run, name) for name in channels])


def measured_channels(record: Record, channels: Sequence[str]) -> Reals:
    """The record's signals, [channels, rows]."""
    return np.array([record.recorded(name) for name in channels])


@dataclass(frozen=True)
class Evidence:
    """A record against what is known. `target` [channels, rows]: what the model should show; `actuator`: the model that is known so far; `spread`: what of it moves.

    `repeats`: the same for each healthy repeat against the others, what a record with nothing new looks like; empty without repeats. `floor`: the cost that such
    a record has. `offsets` [channels]: spread of the signals' own zero, 0 for none.
    """

    actuator: Actuator
    record: Record
    channels: tuple[str, ...]
    target: Reals
    spread: tuple[Spread, ...]
    whiten: Whitener
    offsets: Reals
    start_mm: float
    repeats: tuple[Reals, ...] = ()

    @property
    def relative(self) -> bool:
        """Whether healthy repeats stand behind it."""
        return bool(self.repeats)

    @property
    def numbers(self) -> int:
        """Independent numbers in the record's signals."""
        return self.target.size

    def simulate(self, changes: Mapping[str, float], deviations: Reals) -> Reals:
        """Signals [channels, rows] of the model with effects at `changes` and its spread values at `deviations` [spread] of their spread."""
        moved = dict(changes)
        for one, value in zip(self.spread, deviations, strict=True):
            moved = {**one.changes(self.actuator, float(value)), **moved}
        return simulate_channels(self.actuator.changed(moved), self.record, self.channels, self.start_mm)


@dataclass(frozen=True)
class View:
    """The evidence as seen from one set of effects, linear in what scatters: vectors are whitened and have the scatter's directions taken off.

    `values`: of the effects; `deviations` [spread + offsets]: of what scatters, in spreads; `base` [channels, rows]: the model there; `residual` [n].
    """

    evidence: Evidence
    values: Mapping[str, float]
    deviations: Reals
    base: Reals
    residual: Reals
    _basis: Reals = field(repr=False)
    _plain: Reals = field(repr=False)
    _directions: Reals = field(repr=False)

    @property
    def cost(self) -> float:
        """Squared residual with the scatter at its best."""
        return float(self.residual @ self.residual)

    def projected(self, signals: Reals) -> Reals:
        """Signals [channels, rows] as a vector [n]."""
        return self._without(np.concatenate([self.evidence.whiten(signals), np.zeros(self.deviations.size)]))

    def _without(self, tall: Reals) -> Reals:
        return np.asarray(tall - self._basis @ (self._basis.T @ tall))

    def signature(self, changes: Mapping[str, float]) -> Reals:
        """What `changes` beside the view's own values make of the model, [n]. Raises InputError when the model refuses them."""
        own = self.deviations[: len(self.evidence.spread)]
        return self.projected(self.evidence.simulate({**self.values, **changes}, own) - self.base)

    def unwhitened(self) -> Reals:
        """The residual's lines [channels, lines] weighted once more: their product with a signal's lines is the product of whitened vectors."""
        count = self.deviations.size
        return self.evidence.whiten.lines(np.ascontiguousarray(self.residual[: self.residual.size - count])) * self.evidence.whiten.weights

    def best_deviations(self, vector: Reals | None = None) -> Reals:
        """Deviations at their best, [spread + offsets], with an effect's unprojected `vector` taken off first."""
        tall = self._plain if vector is None else self._plain - vector
        step, *_ = np.linalg.lstsq(self._directions, tall, rcond=None)
        return np.asarray(self.deviations + step)


def view(evidence: Evidence, values: Mapping[str, float], deviations: Reals | None = None, target: Reals | None = None) -> View:
    """The evidence seen from `values` of effects; `deviations` of what scatters are zero unless told. `target` in place of the evidence's own."""
    count, offsets = len(evidence.spread), np.flatnonzero(evidence.offsets)
    at = np.zeros(count + offsets.size) if deviations is None else deviations
    own = at[:count]
    shift = np.zeros((len(evidence.channels), 1))
    shift[offsets, 0] = evidence.offsets[offsets] * at[count:]

    def moved(place: int) -> Reals:
        one = evidence.spread[place]
        step = _DERIVATIVE_STEP / one.std if one.relative else _DERIVATIVE_STEP_STD
        near = own.copy()
        near[place] += step
        return (evidence.simulate(values, near) - base) / step

    base = evidence.simulate(values, own)
    columns = [evidence.whiten(signal) for signal in each(moved, list(range(count)))]
    for channel in offsets:
        constant = np.zeros_like(base)
        constant[channel] = evidence.offsets[channel]
        columns.append(evidence.whiten(constant))
    residual = evidence.whiten((evidence.target if target is None else target) - base - shift)
    directions = np.vstack([np.column_stack(columns) if columns else np.empty((residual.size, 0)), -np.eye(at.size)])
    basis, _ = np.linalg.qr(directions)
    plain = np.concatenate([residual, at])
    return View(evidence, values, at, base, plain - basis @ (basis.T @ plain), basis, plain, directions)


def raw_cost(evidence: Evidence) -> float:
    """Cost of the record against the model as known, nothing of it moved."""
    own = np.zeros(len(evidence.spread))
    return float(np.sum(evidence.whiten(evidence.target - evidence.simulate({}, own)) ** 2))


def settled(evidence: Evidence, values: Mapping[str, float], deviations: Reals | None = None, rounds: int = _ROUNDS) -> View:
    """The view after what scatters has moved to where it is best, as far as `rounds` of linear steps bring it."""
    here = view(evidence, values, deviations)
    if not evidence.spread:
        return here
    for _ in range(rounds):
        there = view(evidence, values, here.best_deviations())
        if not np.sum(there._plain**2) < np.sum(here._plain**2):
            break
        done = np.sum(here._plain**2) - np.sum(there._plain**2) < _SETTLED * np.sum(there._plain**2)
        here = there
        if done:
            break
    return here


def common_channels(records: Sequence[Record]) -> tuple[str, ...]:
    """Signals that every record has."""
    return tuple(name for name in CHANNELS if all(record.channel(name) is not None for record in records))


def same_command(record: Record, other: Record) -> bool:
    """Whether two records run the same command."""
    return other.rows == record.rows and bool(np.allclose(other.command_mm, record.command_mm, atol=1e-6))


def _check_repeats(record: Record, healthy: Sequence[Record]) -> None:
    for other in healthy:
        if not same_command(record, other):
            raise InputError(f"{other.file}: command_mm: not the command of {record.file}: give healthy records of the same command")
    if len(healthy) < 2:
        raise InputError(f"{record.file}: {len(healthy)} healthy record tells nothing of repeatability: give two or more of the same command, or none")


def _offsets(channels: Sequence[str], signals: Reals) -> Reals:
    sizes = np.sqrt(np.mean(signals**2, axis=1))
    return np.array([spreads.OFFSET_SHARE * size if name in spreads.OFFSET_CHANNELS else 0.0 for name, size in zip(channels, sizes, strict=True)])


def healthy_model(actuator: Actuator, record: Record, mean: Reals, power: Reals, channels: tuple[str, ...]) -> Actuator:
    """The actuator fitted to the mean [channels, rows] of healthy repeats, whose noise power by line is `power`."""
    start = start_of(actuator, record)
    found = Evidence(actuator, record, channels, mean, spreads.of_healthy_machine(actuator, channels), Whitener.of(power, record.rows), _offsets(channels, mean), start)
    fitted = settled(found, {})
    changes: dict[str, float] = {}
    for one, value in zip(found.spread, fitted.deviations, strict=False):
        changes |= one.changes(actuator, float(value))
    return actuator.changed(changes)


def _against_repeats(actuator: Actuator, record: Record, healthy: Sequence[Record], channels: tuple[str, ...]) -> Evidence:
    runs = np.array([measured_channels(other, channels) for other in healthy])
    mean, count = runs.mean(axis=0), len(healthy)
    deviations = runs - mean
    least = least_noise(mean)
    level = np.maximum(np.sqrt(np.mean(deviations**2, axis=(0, 2))), least)
    flat = np.broadcast_to((level**2)[:, None], spectrum(mean).shape).real / count
    known = healthy_model(actuator, record, mean, flat, channels)

    start = start_of(known, record)
    usual = spreads.from_run_to_run()
    here = simulate_channels(known, record, channels, start)

    def moved(one: Spread) -> Reals:
        step = _DERIVATIVE_STEP / one.std
        return (simulate_channels(known.changed(one.changes(known, step)), record, channels, start) - here) / step

    directions = np.array(each(moved, usual))
    shares = np.linalg.lstsq((directions / level[:, None]).reshape(len(usual), -1).T, (deviations / level[:, None]).reshape(count, -1).T, rcond=None)[0]
    widths = np.sqrt((_USUAL_WEIGHT + np.sum(shares**2, axis=1)) / (_USUAL_WEIGHT + count - 1))
    left = deviations - np.einsum("kr,kcn->rcn", shares, directions)
    power = np.mean(np.abs(spectrum(left)) ** 2, axis=0) * count / (count - 1)
    widen = 1.0 + 1.0 / count
    whiten = Whitener.of(widen * (smoothed(power) + least[:, None] ** 2), record.rows)
    spread = tuple(replace(one, std=one.std * float(width) * float(np.sqrt(widen))) for one, width in zip(usual, widths, strict=True))
    # a repeat against the mean of the others scatters a little more than the record against the mean of them all
    shrink = np.sqrt(widen / (1.0 + 1.0 / (count - 1)))
    repeats = tuple(here + (runs[k] - np.delete(runs, k, axis=0).mean(axis=0)) * shrink for k in range(count))
    target = here + measured_channels(record, channels) - mean
    return Evidence(known, record, channels, target, spread, whiten, np.zeros(len(channels)), start, repeats)


def gather(actuator: Actuator, record: Record, healthy: Sequence[Record] = (), channels: Sequence[str] | None = None) -> Evidence:
    """Evidence of a record, against two or more healthy repeats of its command where there are any, in the signals that all have or in `channels`.

    Raises InputError for repeats of another command or too few of them.
    """
    names = tuple(channels) if channels else common_channels([record, *healthy])
    if healthy:
        _check_repeats(record, healthy)
        return _against_repeats(actuator, record, healthy, names)
    measured = measured_channels(record, names)
    start = start_of(actuator, record)
    level = np.maximum(white_level(measured), least_noise(measured))
    power = np.broadcast_to((level**2)[:, None], (len(names), record.rows // 2 + 1)).copy()
    return Evidence(actuator, record, names, measured, spreads.from_data_sheet(actuator), Whitener.of(power, record.rows), _offsets(names, measured), start)
