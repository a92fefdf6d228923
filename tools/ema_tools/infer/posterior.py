"""Which causes a record shows, and how surely: the posterior over sets of causes that were fitted to it.

Equations, in the order of the code. A set S of causes is fitted to its least cost C = D + z'z: D of the data, whitened by the noise, and z'z of the nuisance parameters z in prior standard
deviations. The evidence of S by Laplace's method (D. J. C. MacKay, "Bayesian interpolation", Neural Computation 4(3), 1992) is

    ln L(S, M) = ln odds(S) + ln p(M | S) - (k/2) ln s^2 - (D - noise) / (2 s^2) - Z/2 + ln p(v) + (q/2) ln 2 pi - 1/2 ln det(H / s^2 + P),    s^2 = 1 + M / k,

with v the q fitted values, H the curvature of the cost about them, P the precision of their priors, and z where D / s^2 + z'z is least, in closed form, as D is a parabola. No model has exactly
the form of the machine: M is the energy of the discrepancy along k directions, in units of the noise's variance (after M. C. Kennedy, A. O'Hagan, "Bayesian calibration of computer models", J. Royal
Statistical Society B 63, 2001). Its amplitude is half-normal: of a machine that is known by its data sheet a share of the noise, of a cause a share of what that cause explains. More than that is an
unnamed cause, with a prior of its own and an energy up to all that the empty set leaves. The parameters of a unit have one scale in common for their distance from the data sheet, with a scaled
inverse chi-square prior of `_UNITS` values; integrated out over those that the record determines, it gives Z in place of z'z.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from ema_tools.base.arrays import Bools, Reals
from ema_tools.data.actuator import Actuator
from ema_tools.fit.evidence import View
from ema_tools.fit.misfit import DIRECTIONS, in_noise
from ema_tools.fit.nuisance import WORN
from ema_tools.fit.refit import Fit
from ema_tools.infer.priors import log_choices, log_odds, value_prior
from ema_tools.library.definitions import is_size
from ema_tools.library.faults import FAULTS, effect_of
from ema_tools.library.registry import record_of

ACCEPTED = 0.7  # probability from which on a cause, or one of several look-alikes, is accepted [judgement]
_LEADS = 0.5  # probability of the first of several look-alikes that is accepted in their name [judgement]
REPORTED = 0.1  # probability from which on a look-alike is reported [judgement]
_MACHINE = 0.1  # discrepancy of a unit's model: energy over that of the noise, one standard deviation of the amplitude squared [judgement]
_FORM = 0.1  # discrepancy of a cause: amplitude over that of what it explains, one standard deviation .. [judgement]
_CONTACT_FORM = 0.35  # .. and of a contact that yields, whose forms are many [judgement]
_UNNAMED = 0.003  # prior probability of a cause that the library does not hold [judgement]
_UNITS = 4.0  # values whose usual distance from a data sheet counts as known [judgement]
# Amplitudes of the discrepancy over its standard deviation at which it is integrated: the model is rough and its noise estimated, so that it is never none; and factor from one energy of an
# unnamed cause to the next [precision]
_AMPLITUDES = np.array([0.1, 0.2, 0.4, 0.7, 1.0, 1.5, 2.0])
_NEXT_ENERGY = 4.0


@dataclass(frozen=True)
class Nuisance:
    """The cost as a parabola in the nuisance parameters: `least`, at `best` [n] in the coordinates of the columns `axes` [n, n], where it has the curvatures `rates` [n], priors of 1 included.
    `of_unit` [n]: whether a parameter is a distance from the data sheet; `determined`: how many of these the record determines."""

    least: float
    best: Reals
    axes: Reals
    rates: Reals
    of_unit: Bools
    determined: float

    def costs(self, square: float) -> tuple[float, float]:
        """Cost D of the data, and Z of the parameters, where D / square and the parameters' own cost together are least."""
        moved = self.rates / (self.rates + square - 1.0) * self.best
        values = self.axes @ moved
        data = self.least + float(self.rates @ (moved - self.best) ** 2) - float(values @ values)
        unit = float(np.sum(values[self.of_unit] ** 2))
        common = (_UNITS + self.determined) * math.log1p(unit / _UNITS)
        return data, float(values @ values) - unit + common


@dataclass(frozen=True)
class FittedSet:
    """A set of causes at its least cost: `values`, of which the first `len(curvature)` are free, and `curvature` [q, q] of half the cost about these."""

    causes: frozenset[str]
    values: Mapping[str, float]
    curvature: Reals
    nuisance: Nuisance

    @property
    def cost(self) -> float:
        """Of data and nuisance parameters."""
        return self.nuisance.least


@dataclass(frozen=True)
class Posterior:
    """`probability` of each cause that was fitted, look-alikes counted as one; of `unnamed`: a cause that no fitted set holds; `accepted` causes, the most probable first."""

    probability: Mapping[str, float]
    unnamed: float
    accepted: tuple[str, ...]


@dataclass(frozen=True)
class _Term:
    log_evidence: float
    causes: frozenset[str]
    is_named: bool


def fitted_set(view: View) -> FittedSet:
    """The empty set."""
    return FittedSet(frozenset(), {}, np.zeros((0, 0)), _nuisance(view, view.best_deviations(reach=np.inf), view.cost))


def fitted_sets(fits: Iterable[Fit]) -> list[FittedSet]:
    """Of fits, those without a size at its bound."""
    found = []
    for fit in fits:
        if not any(is_size(name) and effect_of(name) not in FAULTS for name in fit.at_bound):
            deviations = fit.view.best_deviations(fit.view.moved(fit.values), reach=np.inf)
            found.append(
                FittedSet(
                    frozenset(fit.effects),
                    fit.values,
                    np.asarray(np.linalg.pinv(fit.covariance), dtype=float),
                    _nuisance(fit.view, deviations, fit.cost),
                )
            )
    return found


def _nuisance(view: View, deviations: Reals, cost: float) -> Nuisance:
    rates, axes = np.linalg.eigh(view.nuisance_curvature)
    spread = view.evidence.spread
    of_unit = np.array([place < len(spread) and spread[place].title not in WORN for place in range(deviations.size)])
    doubt = axes[of_unit] ** 2 @ (1.0 / rates)
    return Nuisance(cost, axes.T @ deviations, axes, rates, of_unit, float(np.sum(1.0 - doubt)))


def posterior(
    actuator: Actuator, empty: FittedSet, sets: Sequence[FittedSet], noise: float, numbers: int, reach_mm: float, peak_A: float
) -> Posterior:
    """Weighs the `empty` set and the fitted ones. `noise`: the cost of sensor noise alone; `numbers`: independent numbers in the record's signals; `reach_mm`, `peak_A`: of command and current."""
    # what the best set leaves below the expected noise is the noise of this record
    noise = min(noise, *(one.nuisance.costs(1.0)[0] for one in (empty, *sets)))
    best: dict[frozenset[str], FittedSet] = {}
    for one in sorted((empty, *sets), key=lambda fitted: fitted.cost):
        best.setdefault(one.causes, one)
    terms: list[_Term] = []
    for fitted in best.values():
        terms += _terms(actuator, fitted, empty, noise, numbers, reach_mm, peak_A)
    logs = np.array([term.log_evidence for term in terms])
    weights = np.exp(logs - logsumexp(logs))

    def share(names: Collection[str]) -> float:
        return float(sum(weight for weight, term in zip(weights, terms, strict=True) if term.is_named and term.causes & set(names)))

    causes = {cause for fitted in best.values() for cause in fitted.causes}
    probability = {cause: share(_class_of(cause)) for cause in causes}
    unnamed = float(sum(weight for weight, term in zip(weights, terms, strict=True) if not term.is_named))
    return Posterior(dict(sorted(probability.items(), key=lambda item: -item[1])), unnamed, _accepted(probability, share))


def _class_of(cause: str) -> set[str]:
    """The cause and those from which no record tells it apart."""
    return {cause, *record_of(cause).inseparable}


def _accepted(probability: Mapping[str, float], share: Callable[[Collection[str]], float]) -> tuple[str, ...]:
    """Causes whose class is probable enough, of each class the cause that is the most probable by itself; then the first of several that are probable enough together. `share`: probability that any
    of some causes is there."""
    found: list[str] = []
    for cause in sorted(probability, key=lambda name: (-probability[name], -share((name,)))):
        if probability[cause] >= ACCEPTED and not _class_of(cause) & set(found):
            found.append(cause)
    known = {name for cause in found for name in _class_of(cause)}
    rivals = {cause for cause, one in probability.items() if one >= REPORTED and cause not in known}
    first = max(rivals, key=lambda cause: probability[cause], default=None)
    if first is not None and probability[first] >= _LEADS and share(rivals) >= ACCEPTED:
        found.append(first)
    return tuple(found)


def _terms(
    actuator: Actuator, fitted: FittedSet, empty: FittedSet, noise: float, numbers: int, reach_mm: float, peak_A: float
) -> list[_Term]:
    """The evidence of a set by energy of its discrepancy."""
    priors = [value_prior(actuator, name, fitted.values[name], reach_mm, peak_A) for name in list(fitted.values)[: len(fitted.curvature)]]
    slopes = np.array([one.slope for one in priors])
    curvature = fitted.curvature * np.outer(slopes, slopes) if priors else fitted.curvature
    precision = np.diag([one.precision for one in priors])
    known = log_odds(fitted.causes) + sum(one.log_density for one in priors) + 0.5 * len(priors) * math.log(2.0 * math.pi)
    known -= log_choices(fitted.values)

    def log_evidence(energy: float) -> float:
        square = in_noise(energy)
        volume = float(np.linalg.slogdet(curvature / square + precision)[1]) if priors else 0.0
        data_cost, nuisance_cost = fitted.nuisance.costs(square)
        return known - 0.5 * (DIRECTIONS * math.log(square) + max(data_cost - noise, 0.0) / square + nuisance_cost + volume)

    form = max(
        (_CONTACT_FORM if cause in FAULTS or record_of(cause).bending is not None else _FORM for cause in fitted.causes), default=0.0
    )
    energy = _MACHINE * numbers + form**2 * max(empty.cost - fitted.cost, 0.0)
    shares = np.exp(-0.5 * _AMPLITUDES**2) * np.gradient(_AMPLITUDES)
    shares *= (1.0 - _UNNAMED) / shares.sum()
    found = [
        _Term(math.log(share) + log_evidence(energy * amplitude**2), fitted.causes, True)
        for amplitude, share in zip(_AMPLITUDES, shares, strict=True)
    ]
    most = max(empty.cost - noise, energy)
    energies = [energy * _NEXT_ENERGY**k for k in range(1, 2 + math.ceil(math.log(most / energy, _NEXT_ENERGY)))]
    return found + [_Term(math.log(_UNNAMED / len(energies)) + log_evidence(one), fitted.causes, False) for one in energies]
