"""From evidence to a verdict: score every effect, refit the finalists, take the best, repeat, prune."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from ema_tools.actuator import row_of
from ema_tools.diagnosis.candidates import FAULTS, Signature, signatures
from ema_tools.diagnosis.evidence import Evidence
from ema_tools.errors import InputError
from ema_tools.parallel import each

Reals = NDArray[np.float64]

# Effects whose refit is worth its time, at most, and how far behind the best score they may be.
_FINALISTS = 5
_FINALIST_SHARE = 0.4
# A set of effects grows no further than this.
_EFFECTS_MAX = 3
# Textbook chi-square limits are several times too low: the plant is not smooth, the noise is estimated, and the best of many shapes is taken.
_LEAST_LIMIT = 60.0
_REPEAT_MARGIN = 1.5
# An effect must also take off this share of the excess that it found.
_LEAST_SHARE = 0.03
# Fits whose costs differ by less than this cannot be told apart: three standard deviations.
_ALIKE = 9.0
_ALIKE_SHARE = 0.01
_UNEXPLAINED = 0.15
_REFIT_RUNS = 8


@dataclass(frozen=True)
class Fit:
    """Effects fitted together: their values, standard errors, the cost left, and the values that lie on a bound."""

    effects: tuple[str, ...]
    values: Mapping[str, float]
    std: Mapping[str, float]
    cost: float
    at_bound: tuple[str, ...]
    vector: Reals


@dataclass(frozen=True)
class Round:
    """One round: the best score of each effect, strongest first, and the refits that followed, best first."""

    scores: Mapping[str, float]
    fits: tuple[Fit, ...]


@dataclass(frozen=True)
class Diagnosis:
    """What was found; `fit` None when nothing exceeds the limit. `unexplained`: share of the excess over the floor that is left."""

    verdict: str
    fit: Fit | None
    alike: tuple[str, ...]
    rounds: tuple[Round, ...]
    cost_before: float
    cost_after: float
    cost_floor: float
    unexplained: float
    limit: float


def effect_of(name: str) -> str:
    """Effect, or fault parameter, that a value belongs to."""
    for fault, value in FAULTS.items():
        if name == value:
            return fault
    return name.split(".")[-2]


def refit(evidence: Evidence, start: Mapping[str, float]) -> Fit:
    """Fits the values named in `start` to the record, beginning there."""
    names = list(start)
    rows = [row_of(name) for name in names]
    first = np.array([start[name] for name in names])
    scale = np.where(np.array([name.endswith("phase_rad") for name in names]), 0.5, np.maximum(np.abs(first), 1e-9))
    lower = np.array([row.lower for row in rows]) / scale
    upper = np.array([row.upper for row in rows]) / scale

    def vector(point: Reals) -> Reals:
        changes = {name: float(np.clip(value, row.lower, row.upper)) for name, value, row in zip(names, point * scale, rows, strict=True)}
        try:
            return evidence.signature(changes)
        except InputError:
            return np.zeros_like(evidence.residual)

    def jacobian(point: Reals) -> Reals:
        here = vector(point)
        columns = []
        for k in range(point.size):
            step = 0.03 if point[k] + 0.03 <= upper[k] else -0.03
            moved = point.copy()
            moved[k] += step
            columns.append((here - vector(moved)) / step)
        return np.column_stack(columns)

    margin = 1e-9 * (upper - lower)
    begun = np.clip(first / scale, lower + margin, upper - margin)
    found = least_squares(lambda point: evidence.residual - vector(point), begun, jac=jacobian, bounds=(lower, upper), max_nfev=_REFIT_RUNS, xtol=1e-4, ftol=1e-5)
    covariance = np.linalg.pinv(found.jac.T @ found.jac)
    values = {name: float(value) for name, value in zip(names, found.x * scale, strict=True)}
    std = {name: float(np.sqrt(max(covariance[k, k], 0.0)) * scale[k]) for k, name in enumerate(names)}
    at_bound = tuple(name for name, row in zip(names, rows, strict=True) if values[name] >= row.upper - 1e-6 * (row.upper - row.lower))
    return Fit(tuple(dict.fromkeys(map(effect_of, names))), values, std, 2.0 * float(found.cost), at_bound, vector(found.x))


def _finalists(found: Sequence[Signature], least: float) -> list[Signature]:
    """Per effect the strongest signature of each sign, of the few strongest effects above `least`."""
    chosen: dict[tuple[str, bool], Signature] = {}
    effects: list[str] = []
    for signature in found:
        name = signature.candidate.effect
        if signature.score <= least:
            break
        if name not in effects:
            effects.append(name)
        if effects.index(name) < _FINALISTS:
            chosen.setdefault((name, signature.size > signature.candidate.zero), signature)
    return list(chosen.values())


def _best_each(fits: Sequence[Fit]) -> tuple[Fit, ...]:
    """The best fit of each set of effects, best first."""
    best: dict[tuple[str, ...], Fit] = {}
    for fit in sorted(fits, key=lambda fit: fit.cost):
        best.setdefault(fit.effects, fit)
    return tuple(best.values())


def _strongest(found: Sequence[Signature]) -> dict[str, Signature]:
    best: dict[str, Signature] = {}
    for signature in found:
        best.setdefault(signature.candidate.effect, signature)
    return best


def _limit_of(evidence: Evidence, found: Sequence[Signature]) -> float:
    """What the same signatures make of healthy repeats, with a margin."""
    most = 0.0
    for signature in found:
        length = float(signature.vector @ signature.vector)
        if length > 0.0:
            most = max([most, *(float(signature.vector @ repeat) ** 2 / length for repeat in evidence.repeats)])
    return max(_LEAST_LIMIT, _REPEAT_MARGIN * most)


def _pruned(evidence: Evidence, fit: Fit, limit: float) -> Fit:
    """Drops each earlier effect whose absence costs less than the limit."""
    current = fit
    for effect in fit.effects[:-1]:
        without = {name: value for name, value in current.values.items() if effect_of(name) != effect}
        if without:
            smaller = refit(evidence, without)
            if smaller.cost - current.cost < limit:
                current = smaller
    return current


def diagnose(evidence: Evidence) -> Diagnosis:
    """The whole search on one record's evidence."""
    repeats = np.array([float(repeat @ repeat) for repeat in evidence.repeats])
    floor = float(repeats.mean())
    before = float(evidence.residual @ evidence.residual)
    excess = max(before - floor, 1e-9)
    rounds: list[Round] = []
    best: Fit | None = None
    cost, limit = before, _LEAST_LIMIT
    while len(best.effects if best else ()) < _EFFECTS_MAX:
        held = dict(best.values) if best else {}
        held_vector = best.vector if best else np.zeros_like(evidence.residual)
        left = evidence.residual - held_vector
        found = signatures(evidence, left, held, held_vector, best.effects if best else ())
        if not rounds:
            limit = _limit_of(evidence, found)
        needed = max(limit, _LEAST_SHARE * excess)
        strongest = _strongest(found)
        scores = {name: signature.score for name, signature in strongest.items()}
        top = max(scores.values(), default=0.0)
        finalists = _finalists(found, max(_FINALIST_SHARE * top, 0.7 * needed)) if top > needed else []
        fits = _best_each(each(lambda signature, held=held: refit(evidence, {**held, **signature.start()}), finalists))
        rounds.append(Round(scores, fits))
        if not fits or cost - fits[0].cost < needed:
            break
        best = _pruned(evidence, fits[0], needed)
        cost = best.cost
    unexplained = max(cost - floor, 0.0) / excess
    strange = cost - floor > 6.0 * (float(np.std(repeats)) + np.sqrt(2.0 * evidence.residual.size))
    if strange and unexplained > _UNEXPLAINED:
        verdict = "unknown"
    else:
        verdict = "missing" if best is not None else "adequate"
    first = rounds[0].fits
    alike = () if best is None else tuple(
        effect for fit in first[1:] for effect in fit.effects if fit.cost - first[0].cost < max(_ALIKE, _ALIKE_SHARE * excess) and effect not in best.effects
    )
    return Diagnosis(verdict, best, alike, tuple(rounds), before, cost, floor, unexplained, limit)
