"""The answer of a search: the causes that the posterior over all fitted sets accepts."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

import numpy as np

from ema_tools.base.errors import InputError
from ema_tools.fit.evidence import Evidence, settled, simulate_channels
from ema_tools.fit.misfit import in_noise
from ema_tools.fit.refit import Fit, jointly, refit
from ema_tools.infer.posterior import REPORTED, Posterior, fitted_set, fitted_sets, given_of, posterior
from ema_tools.library.faults import effect_of
from ema_tools.library.registry import record_of
from ema_tools.select.outcome import Diagnosis, Named, Path
from ema_tools.select.strategies.strategy import ALIKE, Strategy

UNNAMED = 0.5  # probability of an unnamed cause from which on the verdict is unknown [judgement]


def weighed(pool: Sequence[Fit], path: Path, strategy: Strategy) -> Diagnosis:
    """The diagnosis from a `pool` of fitted sets of causes, those of the search's path among them."""
    evidence = strategy.evidence
    found = posterior(given_of(evidence, _peak_A(evidence)), fitted_set(strategy.places()[-1]), fitted_sets(pool))
    steps = _steps(found.accepted, pool, strategy)
    verdict = "missing" if steps else "unknown" if found.unnamed > UNNAMED else "adequate"
    if steps:
        with suppress(InputError):
            steps = (*steps[:-1], strategy.finished(steps[-1]))
    elif verdict == "unknown" and pool:
        steps = (min(pool, key=lambda fit: fit.judged),)
    best = steps[-1] if steps else None
    cost = best.cost if best is not None else strategy.before
    unexplained = max(cost - strategy.floor, 0.0) / strategy.excess
    doubt = ALIKE * in_noise(cost - strategy.floor)
    named = _named(path, pool, strategy, found, best, steps, verdict == "missing")
    return Diagnosis(
        verdict, best, named, path.rounds, steps, strategy.before, cost, strategy.floor, unexplained, strategy.limit, doubt, found.unnamed
    )


def _peak_A(evidence: Evidence) -> float:
    current_A = simulate_channels(evidence.actuator, evidence.record, ("current_A",), evidence.start_mm)
    return float(np.max(np.abs(current_A)))


def _steps(accepted: Sequence[str], pool: Sequence[Fit], strategy: Strategy) -> tuple[Fit, ...]:
    """Fits of the accepted causes: of the first, of the first two, and so on, the cause that explains most alone first."""
    alone = {fit.effects[0]: fit.cost for fit in pool if len(fit.effects) == 1}
    order = sorted(accepted, key=lambda cause: alone.get(cause, np.inf))
    return tuple(_fit_of(order[: count + 1], pool, strategy) for count in range(len(order)))


def _fit_of(causes: Sequence[str], pool: Sequence[Fit], strategy: Strategy) -> Fit:
    """The fit of exactly these causes, from the pool or from the best of its fits that holds them all."""
    same = next((fit for fit in pool if set(fit.effects) == set(causes)), None)
    if same is not None:
        return same
    wider = [fit for fit in pool if set(causes) <= set(fit.effects)]
    every = [min(wider, key=lambda fit: fit.cost)] if wider else [_best_with(cause, pool) for cause in causes]
    start = {name: value for fit in every for name, value in fit.values.items() if effect_of(name) in causes}
    return jointly(refit(settled(strategy.evidence, start, every[0].view.deviations), start))


def _best_with(cause: str, pool: Sequence[Fit]) -> Fit:
    return min((fit for fit in pool if cause in fit.effects), key=lambda fit: fit.cost)


def _named(
    path: Path, pool: Sequence[Fit], strategy: Strategy, found: Posterior, best: Fit | None, steps: Sequence[Fit], accepted: bool
) -> tuple[Named, ...]:
    """The causes of the answer in their order, then the others, the most probable first."""
    listed: list[Named] = []
    limits = {effect: limit for made in reversed(path.rounds) for effect, limit in made.limits.items()}
    held = best.effects if best is not None else ()
    likely = [cause for cause, share in found.probability.items() if share >= REPORTED and cause not in held]
    cost = strategy.before
    for effect, fit in zip(_order(steps), steps if len(steps) == len(held) else [best] * len(held), strict=True):
        assert best is not None and fit is not None
        alike = (effect, *dict.fromkeys((*_alike(effect, likely, held, pool), *record_of(effect).inseparable)))
        values = best.of_effect(effect)
        std = {name: value for name, value in best.std.items() if name in values}
        listed.append(
            Named(
                effect,
                alike,
                values,
                std,
                cost - fit.cost,
                limits.get(effect, strategy.limit),
                accepted,
                found.probability.get(effect, 0.0),
            )
        )
        cost = fit.cost
    first = path.rounds[0]
    tried = {fit.effects[0]: fit for fit in reversed(first.fits)}
    others = []
    for effect in {*first.scores, *tried} - set(held):
        fit = tried.get(effect)
        others.append(
            Named(
                effect,
                (effect, *record_of(effect).inseparable),
                fit.values if fit is not None else {},
                fit.std if fit is not None else {},
                strategy.before - fit.judged if fit is not None else first.scores[effect],
                limits.get(effect, strategy.limit),
                False,
                found.probability.get(effect, 0.0),
            )
        )
    return (*listed, *sorted(others, key=lambda one: (-(one.probability or 0.0), -one.score / one.limit, one.name)))


def _order(steps: Sequence[Fit]) -> list[str]:
    return list(dict.fromkeys(effect for fit in steps for effect in fit.effects))


def _alike(effect: str, likely: Sequence[str], held: Sequence[str], pool: Sequence[Fit]) -> list[str]:
    """Of the likely causes those that were fitted in the place of an effect of the answer."""
    return [cause for cause in likely if any(set(fit.effects) == {*held, cause} - {effect} for fit in pool)]
