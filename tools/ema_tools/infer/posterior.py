"""Which causes a record shows, and how surely: the posterior over sets of causes that were fitted to it.

Equations, in the order of the code. A set S of causes is fitted to its least cost C = D + z'z: D of the data, whitened by the noise, and z'z of the nuisance parameters z in prior standard
deviations. The evidence of S by Laplace's method (D. J. C. MacKay, "Bayesian interpolation", Neural Computation 4(3), 1992) is

    ln L(S, M) = ln odds(S) + ln p(M | S) - (k/2) ln s^2 - (D - noise) / (2 s^2) - Z/2 + ln p(v) + (q/2) ln 2 pi - 1/2 ln det(H / s^2 + P),    s^2 = 1 + M / k,

with v the q fitted values, H the curvature of the cost about them, P the precision of their priors, and z where D / s^2 + z'z is least, in closed form, as D is a parabola. No model has
exactly the form of the machine: M is the energy of the discrepancy along k directions, in units of the noise's variance (after M. C. Kennedy, A. O'Hagan, "Bayesian calibration of computer
models", J. Royal Statistical Society B 63, 2001). Its amplitude is half-normal: of a machine that is known by its data sheet a share of the noise, of one beside its baseline records a share
of what has changed, of a cause a share of what that cause explains. Beside baseline records a set is also weighed as the discrepancy of the set without one of its causes, along that cause's
direction. More than that is an unnamed cause, with a prior of its own and an energy up to all that the empty set leaves. How far a nuisance parameter goes is itself known from few values:
its scale has a scaled inverse chi-square prior of `freedom` values; integrated out over what the record determines, it gives Z in place of z'z. The parameters of a unit have one scale in
common for their distance from the data sheet; what varies from run to run has scales of its own, of which the baseline records and the usual ones tell.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import logsumexp

from ema_tools.base.arrays import Reals
from ema_tools.data.actuator import Actuator, row_of
from ema_tools.fit.evidence import Evidence, View, raw_cost
from ema_tools.fit.misfit import DIRECTIONS, in_noise
from ema_tools.fit.nuisance import WORN
from ema_tools.fit.refit import Fit
from ema_tools.infer.priors import ValuePrior, log_choices, log_odds, normal, value_prior
from ema_tools.library.definitions import is_size
from ema_tools.library.faults import FAULTS, effect_of
from ema_tools.library.registry import record_of

ACCEPTED = 0.7  # probability from which on a cause, or one of several look-alikes, is accepted [judgement]
_LEADS = 0.5  # probability of the first of several look-alikes that is accepted in their name [judgement]
REPORTED = 0.1  # probability from which on a look-alike is reported [judgement]
_MACHINE = 0.1  # discrepancy of a unit's model: energy over that of the noise, one standard deviation of the amplitude squared [judgement]
_REPEATED = 0.25  # the same beside baseline records, which lack what the model lacks: energy along a direction over the noise's variance .. [judgement]
_TRUSTED = 0.01  # .. and share, in amplitude, of all by which the record differs from them [judgement]
_FORM = 0.1  # discrepancy of a cause: amplitude over that of what it explains, one standard deviation .. [judgement]
_CONTACT_FORM = 0.35  # .. and of a contact that yields, whose forms are many [judgement]
_UNNAMED = 0.003  # prior probability of a cause that the library does not hold [judgement]
_UNITS = 4.0  # values whose usual distance from a data sheet counts as known [judgement]
_BY_CHANCE = 2.0  # standard deviations by which a record's noise may exceed that of the baseline records [chance]
# Amplitudes of the discrepancy over its standard deviation at which it is integrated: a model by its data sheet is rough and its noise estimated, so that it is never none; and factor from one
# energy of an unnamed cause to the next [precision]
_AMPLITUDES = np.array([0.1, 0.2, 0.4, 0.7, 1.0, 1.5, 2.0])
_SMALL_AMPLITUDES = np.array([0.003, 0.01, 0.03])  # beside baseline records
# How much larger it may be along one direction than along the others, and how often [judgement]
_ALONG = ((1.0, 0.6), (3.0, 0.3), (10.0, 0.1))
_NEXT_ENERGY = 4.0


@dataclass(frozen=True)
class Scale:
    """A scale that the nuisance parameters at `places` have in common, known as from `freedom` values; `determined`: how many of the parameters the record determines."""

    places: list[int]
    freedom: float
    determined: float

    def cost(self, values: Reals) -> float:
        """Of parameters [n] in prior standard deviations, the scale integrated out, in place of their squares."""
        return (self.freedom + self.determined) * math.log1p(float(np.sum(values[self.places] ** 2)) / self.freedom)


@dataclass(frozen=True)
class Nuisance:
    """The cost as a parabola in the nuisance parameters: `least`, at `best` [n] in the coordinates of the columns `axes` [n, n], where it has the curvatures `rates` [n], priors of 1 included.
    `scales`: of those whose prior standard deviation is not known for certain."""

    least: float
    best: Reals
    axes: Reals
    rates: Reals
    scales: tuple[Scale, ...]

    def costs(self, square: float) -> tuple[float, float]:
        """Cost D of the data, and Z of the parameters, where D / square and the parameters' own cost together are least."""
        moved = self.rates / (self.rates + square - 1.0) * self.best
        values = self.axes @ moved
        square_sum = float(values @ values)
        data = self.least + float(self.rates @ (moved - self.best) ** 2) - square_sum
        return data, square_sum + sum(scale.cost(values) - float(np.sum(values[scale.places] ** 2)) for scale in self.scales)


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
class Given:
    """What the evidence of a set is computed from beside its fit: the machine as known; the cost of `noise` alone, and by how much that of a record may be more by `chance`; the energy of the
    discrepancy of the `machine`'s own model, one standard deviation of its amplitude squared; how far the command reaches and the largest current; whether it is `relative` to baseline records."""

    actuator: Actuator
    noise: float
    chance: float
    machine: float
    reach_mm: float
    peak_A: float
    relative: bool


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


def given_of(evidence: Evidence, peak_A: float) -> Given:
    """Of some evidence; `peak_A`: the largest current of the machine as known.

    What a model of the machine lacks is in its baseline records as well: what is left is a share of what has changed.
    """
    machine, chance = _MACHINE * evidence.numbers, 0.0
    if evidence.relative:
        costs = [float(residual @ residual) for residual in evidence.of_repeats]
        changed = max(raw_cost(evidence) - evidence.expected_cost(), 0.0)
        machine = _REPEATED * DIRECTIONS + _TRUSTED**2 * changed
        chance = _BY_CHANCE * max(float(np.std(costs, ddof=1)), math.sqrt(2.0 * evidence.numbers)) + evidence.counting
    reach_mm = float(np.max(np.abs(evidence.record.command_mm)))
    return Given(evidence.actuator, evidence.expected_cost(), chance, machine, reach_mm, peak_A, evidence.relative)


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
    determined = 1.0 - axes**2 @ (1.0 / rates)
    evidence = view.evidence
    titles = [one.title for one in (*evidence.spread, *evidence.varies)]
    if evidence.relative:
        groups = [[place] for place, title in enumerate(titles) if title not in evidence.actuator.scatter]
    else:
        groups = [[place for place, title in enumerate(titles) if title not in WORN]]
    freedom = evidence.freedom if evidence.relative else _UNITS
    scales = tuple(Scale(places, freedom, float(np.sum(determined[places]))) for places in groups)
    return Nuisance(cost, axes.T @ deviations, axes, rates, scales)


def posterior(given: Given, empty: FittedSet, sets: Sequence[FittedSet]) -> Posterior:
    """Weighs the `empty` set and the fitted ones."""
    # what the best set leaves is the noise of this record, unless it is more than chance makes it
    given = replace(given, noise=min(given.noise + given.chance, *(one.nuisance.costs(1.0)[0] for one in (empty, *sets))))
    best: dict[frozenset[str], FittedSet] = {}
    for one in sorted((empty, *sets), key=lambda fitted: fitted.cost):
        best.setdefault(one.causes, one)
    terms: list[_Term] = []
    for fitted in best.values():
        terms += _terms(given, fitted, empty)
        # beside a machine that is known by its data sheet alone the discrepancy is large along all directions
        for cause in fitted.causes if given.relative else ():
            without = best.get(fitted.causes - {cause})
            if without is not None:
                terms += _taken_for_form(given, fitted, without, empty)
    logs = np.array([term.log_evidence for term in terms])
    weights = np.exp(logs - logsumexp(logs))

    def share(names: Collection[str]) -> float:
        return min(
            float(sum(weight for weight, term in zip(weights, terms, strict=True) if term.is_named and term.causes & set(names))), 1.0
        )

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


def _energy(given: Given, fitted: FittedSet, empty: FittedSet) -> float:
    """Energy of the discrepancy of a set, one standard deviation of its amplitude squared."""
    return given.machine + _form_of(fitted.causes) ** 2 * max(empty.cost - fitted.cost, 0.0)


def _of_amplitudes(given: Given) -> tuple[Reals, Reals]:
    """Amplitudes of the named discrepancy over its usual one, and their prior probabilities."""
    amplitudes = np.concatenate([_SMALL_AMPLITUDES, _AMPLITUDES]) if given.relative else _AMPLITUDES
    shares = np.exp(-0.5 * amplitudes**2) * np.gradient(amplitudes)
    return amplitudes, shares * (1.0 - _UNNAMED) / shares.sum()


def _terms(given: Given, fitted: FittedSet, empty: FittedSet) -> list[_Term]:
    """The evidence of a set by energy of its discrepancy."""
    energy = _energy(given, fitted, empty)
    log_evidence = _log_evidence(given, fitted)
    found = [
        _Term(math.log(share) + log_evidence(energy * amplitude**2), fitted.causes, True)
        for amplitude, share in zip(*_of_amplitudes(given), strict=True)
    ]
    most = max(empty.cost - given.noise, energy)
    energies = [energy * _NEXT_ENERGY**k for k in range(1, 2 + math.ceil(math.log(most / energy, _NEXT_ENERGY)))]
    return found + [_Term(math.log(_UNNAMED / len(energies)) + log_evidence(one), fitted.causes, False) for one in energies]


def _taken_for_form(given: Given, fitted: FittedSet, without: FittedSet, empty: FittedSet) -> list[_Term]:
    """The evidence of the set `without` one cause of another one, where what that cause explains is the discrepancy of this set along the cause's direction, which is one of its many."""
    (cause,) = fitted.causes - without.causes
    energy = _energy(given, without, empty)
    size = next(name for name in fitted.values if effect_of(name) == cause)
    change = fitted.values[size] - given.actuator[row_of(size).name]
    explained = without.cost - fitted.cost
    if change == 0.0 or explained <= 0.0:
        return []
    found = []
    for amplitude, share in zip(*_of_amplitudes(given), strict=True):
        for along, its_share in _ALONG:
            if along * amplitude > _AMPLITUDES[-1]:
                continue
            std = abs(change) * along * amplitude * math.sqrt(energy / DIRECTIONS / explained)
            log_evidence = _log_evidence(given, fitted, without.causes, {size: normal(change, std)})
            found.append(_Term(math.log(share * its_share) + log_evidence(energy * amplitude**2), without.causes, True))
    return found


def _log_evidence(
    given: Given, fitted: FittedSet, causes: Collection[str] | None = None, other: Mapping[str, ValuePrior] | None = None
) -> Callable[[float], float]:
    """The logarithm of the evidence of a set, by the energy of its discrepancy; as one of `causes` alone and with `other` priors of some values, where they are given."""
    free = list(fitted.values)[: len(fitted.curvature)]
    special = other or {}
    priors = [
        special[name] if name in special else value_prior(given.actuator, name, fitted.values[name], given.reach_mm, given.peak_A)
        for name in free
    ]
    slopes = np.array([one.slope for one in priors])
    curvature = fitted.curvature * np.outer(slopes, slopes) if priors else fitted.curvature
    precision = np.diag([one.precision for one in priors])
    known = log_odds(fitted.causes if causes is None else causes, given.relative) - log_choices(fitted.values)
    known += sum(one.log_density for one in priors) + 0.5 * len(priors) * math.log(2.0 * math.pi)

    def log_evidence(energy: float) -> float:
        square = in_noise(energy)
        volume = float(np.linalg.slogdet(curvature / square + precision)[1]) if priors else 0.0
        data_cost, nuisance_cost = fitted.nuisance.costs(square)
        return known - 0.5 * (DIRECTIONS * math.log(square) + max(data_cost - given.noise, 0.0) / square + nuisance_cost + volume)

    return log_evidence


def _form_of(causes: Collection[str]) -> float:
    """The share of what a set explains by which its form errs, in amplitude."""
    return max((_CONTACT_FORM if cause == "blk" or record_of(cause).bending is not None else _FORM for cause in causes), default=0.0)
