"""The best that anyone could do: an observer who knows every effect's signature on this very machine, and how its repeats differ, exactly.

It holds each effect in the shape in which it would be hidden, from runs of the truth plant without noise, and leaves only the size free. The noise of each signal by frequency
comes from many repeats; the scatter of friction, grease and winding are known directions. It picks the effect of highest likelihood. What it cannot name, no method can.
Without healthy repeats it knows by how much units differ from their data sheet and in which directions, as the machines were drawn, but not where in there this unit lies.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from benchmarks.hidden.catalogue import FAULTS, FORMS, LIBRARY, OUTSIDE, SEVERITIES, change, stands_for
from benchmarks.hidden.machines import CHANNELS, ROWS, Machine, exact, machine, measured, scatter_directions, seed_of, unit_errors
from ema_tools.base.arrays import Reals
from ema_tools.base.recording import Recording

_REPEATS = 24
# Sizes at which an alternative's signature is taken; in between and beyond it is scaled.
_SIZES = ("small", "medium", "large")
# Effects that do what an error of the unit does. Without repeats how a large one bends tells nothing, as a large error of the unit bends alike: they are held as linear.
_TWINS = (
    "coulomb_asymmetry",
    "magnet_weakening",
    "winding_heating",
    "supply_sag",
    "sensor_gain",
    "sensor_offset",
    "inertia_change",
    "gain_drift",
)
_LINEAR = "edge"
_SMOOTH_LINES = 12
_SMOOTH_SHARE = 0.1


def signals(run: Recording) -> Reals:
    """All channels of a run, [CHANNELS, rows]."""
    return np.array([getattr(run, channel) for channel in CHANNELS])


def _lines(found: Reals) -> NDArray[np.complex128]:
    return np.asarray(fft.rfft(found, axis=-1, norm="ortho"))


def _smoothed(power: Reals) -> Reals:
    total = np.concatenate([np.zeros((power.shape[0], 1)), np.cumsum(power, axis=1)], axis=1)
    index = np.arange(power.shape[1])
    half = np.maximum(_SMOOTH_LINES, (_SMOOTH_SHARE * index).astype(int))
    low, high = np.maximum(index - half, 0), np.minimum(index + half + 1, power.shape[1])
    return np.asarray((total[:, high] - total[:, low]) / (high - low))


class Bank:
    """Noise, scatter and signatures of one machine under one command; signatures are simulated when they are first asked for."""

    def __init__(self, unit: Machine, command: str) -> None:
        self.unit, self.command = unit, command
        self.healthy = exact(unit, {}, command)
        directions = scatter_directions(unit, command)
        runs = np.array(
            [signals(measured(unit, {}, command, seed_of("observer", unit.number, unit.own, command, count))) for count in range(_REPEATS)]
        )
        deviations = runs - runs.mean(axis=0)
        level = np.sqrt(np.mean(deviations**2, axis=(0, 2)))[:, None]
        basis = np.array([(direction / level).ravel() for direction in directions]).T
        shares = np.linalg.lstsq(basis, (deviations / level).reshape(_REPEATS, -1).T, rcond=None)[0]
        left = deviations - np.einsum("kr,kcn->rcn", shares, np.array(directions))
        power = _smoothed(np.mean(np.abs(_lines(left)) ** 2, axis=0)) * _REPEATS / (_REPEATS - 1.0)
        # both halves of the spectrum count, the line at zero and the last of an even count once
        self._weights = np.sqrt(np.where((np.arange(power.shape[1]) == 0) | (np.arange(power.shape[1]) == ROWS / 2), 1.0, 2.0) / power)
        self.directions = [self.whitened(direction) for direction in directions]
        self._unit: tuple[list[Reals], Reals] | None = None
        self._signatures: dict[tuple[str, str], Reals] = {}

    def whitened(self, found: Reals) -> Reals:
        """Signals [CHANNELS, rows] with unit variance of the noise, [CHANNELS, 2 * lines]."""
        return np.ascontiguousarray(_lines(found) * self._weights).view(np.float64)

    def unit_directions(self) -> tuple[list[Reals], Reals]:
        """What one standard deviation of each error of the unit makes of the signals, whitened, and where this unit lies, in standard deviations, [k]."""
        if self._unit is None:
            found = unit_errors(self.unit, self.command)
            self._unit = [self.whitened(direction) for direction, _ in found], np.array([place for _, place in found])
        return self._unit

    def signature(self, effect: str, severity: str) -> Reals:
        """What an effect makes of the signals, whitened, [CHANNELS, 2 * lines]."""
        key = (effect, severity)
        if key not in self._signatures:
            values = change(self.unit, effect, SEVERITIES[severity], self.command).values
            self._signatures[key] = self.whitened(exact(self.unit, values, self.command) - self.healthy).astype(np.float32)
        return self._signatures[key]

    def linear_signature(self, effect: str, severity: str) -> Reals:
        """The same of a twin of a unit's error, in proportion from the slightest."""
        if effect not in _TWINS:
            return self.signature(effect, severity)
        return self.signature(effect, _LINEAR) * np.float32(SEVERITIES[severity] / SEVERITIES[_LINEAR])


@lru_cache(maxsize=3)
def bank(number: int, own: bool, command: str, setting: str = "") -> Bank:
    """The bank of a machine, kept while its trials run."""
    return Bank(machine(number, own, setting), command)


@dataclass(frozen=True)
class _ObservedSpace:
    """Vectors in some channels, scaled by what `repeats` leave of a difference, with the scatter taken off, and without repeats the unit's own errors; `place` of this unit among them."""

    channels: tuple[int, ...]
    scale: float
    basis: Reals
    place: Reals
    alone: bool

    @staticmethod
    def of(known: Bank, channels: Sequence[str] | None, repeats: int) -> _ObservedSpace:
        chosen = tuple(CHANNELS.index(name) for name in channels or CHANNELS)
        own, place = ([], np.empty(0)) if repeats else known.unit_directions()
        columns = np.column_stack([direction[list(chosen)].ravel() for direction in (*known.directions, *own)])
        basis, _ = np.linalg.qr(np.vstack([columns, -np.eye(columns.shape[1])]))
        return _ObservedSpace(
            chosen,
            1.0 / np.sqrt(1.0 + 1.0 / repeats) if repeats else 1.0,
            basis,
            np.concatenate([np.zeros(len(known.directions)), place]),
            not repeats,
        )

    def __call__(self, whitened: Reals, place: Reals | None = None) -> Reals:
        """`place`: where the unit lies, for a record; a signature has none."""
        flat = np.concatenate(
            [self.scale * whitened[list(self.channels)].ravel(), np.zeros(self.basis.shape[1]) if place is None else place]
        )
        return np.asarray(flat - self.basis @ (self.basis.T @ flat))


class _Judge:
    """All effects of the library and the fault parameters against one vector."""

    names = (*LIBRARY, *FAULTS)

    def __init__(self, known: Bank, space: _ObservedSpace) -> None:
        self._known, self._space = known, space
        self._units: dict[str, Reals] = {}
        self._signed = np.array([name in FAULTS or LIBRARY[name].signed for name in self.names])

    def _of_severity(self, severity: str) -> Reals:
        """Signatures of all names, each of length one, [names, n]."""
        if severity not in self._units:
            of = self._known.linear_signature if self._space.alone else self._known.signature
            vectors = np.array([self._space(of(name, severity)) for name in self.names])
            lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
            self._units[severity] = (vectors / np.where(lengths > 0.0, lengths, 1.0)).astype(np.float32)
        return self._units[severity]

    def likelihoods(self, vector: Reals, own: str) -> dict[str, float]:
        """By how much each effect at its best size lowers the cost of a vector, sizes near `own` severity included."""
        products = np.array(
            [self._of_severity(severity) @ vector.astype(np.float32) for severity in sorted({*_SIZES, own})], dtype=np.float64
        )
        best = np.where(self._signed, np.abs(products), np.maximum(products, 0.0)).max(axis=0)
        return {name: float(value) ** 2 for name, value in zip(self.names, best, strict=True)}


def judged(
    number: int,
    own: bool,
    command: str,
    effects: Sequence[str],
    severity: str,
    run: Recording,
    healthy: Sequence[Recording],
    channels: Sequence[str] | None,
    setting: str = "",
) -> dict[str, Any]:
    """What the observer makes of a run: its pick, whether that is right, how far the hidden effect lies from nothing (`size`) and from others (`apart`), in standard deviations.

    Without healthy repeats the unit's own errors stand between the record and the data sheet: they are linear from where the unit is, which the observer does not know.
    For an effect outside the library, and for another form than the library's, `nearest` is the effect that comes nearest and `beyond` the share of the hidden one that it leaves. For a
    pair, `apart` says how far each lies from what the other one alone can make. Of a form the observer knows the very form beside the library's effects.
    """
    known = bank(number, own, command, setting)
    space = _ObservedSpace.of(known, channels, len(healthy))
    judge = _judge(number, own, command, tuple(channels or CHANNELS), len(healthy), setting)
    reference = np.mean([signals(other) for other in healthy], axis=0) if healthy else known.healthy
    seen_run = known.whitened(signals(run) - reference)
    if not healthy:
        seen_run = seen_run + sum(known.linear_signature(effect, severity) - known.signature(effect, severity) for effect in effects)
    residual = space(seen_run, space.place)
    seen = judge.likelihoods(residual, severity)
    of = known.signature if healthy else known.linear_signature
    true = [space(of(effect, severity)) for effect in effects]
    if effects[0] in FORMS:
        seen[effects[0]] = max(float(true[0] @ residual), 0.0) ** 2 / max(float(true[0] @ true[0]), 1e-24)
    pick = max(seen, key=lambda name: seen[name])
    lengths = [float(np.sqrt(vector @ vector)) for vector in true]
    found: dict[str, Any] = {"pick": pick, "size": lengths}
    if len(effects) == 2:
        shared = float(true[0] @ true[1])
        found["apart"] = {
            effects[k]: float(np.sqrt(max(lengths[k] ** 2 - (shared / max(lengths[1 - k], 1e-12)) ** 2, 0.0))) for k in range(2)
        }
        return found
    alone = judge.likelihoods(true[0], severity)
    apart = {name: float(np.sqrt(max(lengths[0] ** 2 - value, 0.0))) for name, value in alone.items() if not stands_for(name, effects[0])}
    found["apart"] = {name: round(value, 2) for name, value in sorted(apart.items(), key=lambda item: item[1])}
    if effects[0] in OUTSIDE or effects[0] in FORMS:
        best = max(alone, key=lambda name: alone[name])
        found |= {"nearest": best, "beyond": max(1.0 - alone[best] / max(lengths[0] ** 2, 1e-24), 0.0)}
    return found if effects[0] in OUTSIDE else {**found, "right": stands_for(pick, effects[0])}


@lru_cache(maxsize=4)
def _judge(number: int, own: bool, command: str, channels: tuple[str, ...], repeats: int, setting: str) -> _Judge:
    known = bank(number, own, command, setting)
    return _Judge(known, _ObservedSpace.of(known, channels, repeats))
