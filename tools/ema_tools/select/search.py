"""Which sets of causes are fitted to the evidence: score every effect, refit the finalists, take the best, again, and what such a way passes by. What differs from case to case is a strategy's."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

from ema_tools.base.progress import Report, untold
from ema_tools.fit.evidence import Evidence, View, settled
from ema_tools.fit.refit import Fit, best_of_each, fits_from, joined, pruned, refit, seen_from, slopes, without_effect
from ema_tools.library.definitions import load_definitions
from ema_tools.library.registry import record_of
from ema_tools.select.candidates import Signature, promising, signatures
from ema_tools.select.matched_filter import Screen
from ema_tools.select.outcome import Diagnosis, Path, Round
from ema_tools.select.probable import weighed
from ema_tools.select.strategies import strategy_for
from ema_tools.select.strategies.healthy_machine import HealthyMachine
from ema_tools.select.strategies.strategy import Strategy

# A size must differ from none by this many standard errors; what lowers the error without one mends the arithmetic of another
# effect [chance]
_SHOWN = 2.0
_WORTH_REFITS = 0.7  # a round whose best score is below this share of what is needed is not worth its refits [effort]


def _finalists(found: Sequence[Signature], strategy: Strategy) -> list[Signature]:
    """Per effect the strongest signature of each sign, of the few strongest effects."""
    if not found:
        return []
    top, limits = found[0].score, strategy.limits
    least = min(limits.finalist_share * top, top - limits.finalist_reach)
    chosen: dict[tuple[str, bool], Signature] = {}
    effects: list[str] = []
    for signature in found:
        name = signature.candidate.effect
        if signature.score <= least:
            break
        if name not in effects:
            effects.append(name)
        if effects.index(name) < limits.finalists:
            chosen.setdefault((name, signature.size > signature.candidate.zero), signature)
    return list(chosen.values())


def _strongest(found: Sequence[Signature]) -> dict[str, Signature]:
    best: dict[str, Signature] = {}
    for signature in found:
        best.setdefault(signature.candidate.effect, signature)
    return best


def _pruned(fit: Fit, limit: float) -> Fit:
    """Without each earlier effect whose absence costs less than the limit."""
    return pruned(fit, fit.effects[:-1], lambda _effect, _fit: limit)


def _special_cases(fit: Fit) -> list[Fit]:
    """The fit with one of its effects in its special case, from the values that both have."""
    starts = []
    for effect in fit.effects:
        special = record_of(effect).special_case
        known = {f"effects.{row.name}" for row in load_definitions().effect(special).parameters} if special else set()
        shared = {name.replace(f"effects.{effect}.", f"effects.{special}."): value for name, value in fit.of_effect(effect).items()}
        start = {name: value for name, value in shared.items() if name in known}
        if start and special not in fit.effects:
            starts.append({**without_effect(fit.values, effect), **start})
    # the view of the fit holds the effect itself
    return fits_from(lambda start: refit(settled(fit.view.evidence, start, fit.view.deviations, 1), start), starts)


def _newest(fit: Fit, held: Sequence[str]) -> str:
    return next((effect for effect in fit.effects if effect not in held), fit.effects[-1])


def _first_look(strategy: Strategy) -> list[Signature]:
    """Every effect's signatures from every place that the strategy looks from."""
    places = strategy.places()
    seen = [
        replace(one, score=one.score - (view.cost - places[-1].cost))
        for view in places
        for one in signatures(Screen(view), only=strategy.only)
    ]
    return sorted(seen, key=lambda signature: -signature.score)


def _grown(strategy: Strategy, effects_max: int, tell: Report, begun: Path | None = None) -> Path:
    """Adds the effect that takes off most, as long as it takes off what the strategy needs; `begun`: what has been added already."""
    here, cost = strategy.start, strategy.before
    rounds: list[Round] = []
    steps: list[Fit] = []
    every: list[Signature] = []
    if begun is not None:
        here, cost, rounds, steps = begun.view, begun.steps[-1].cost, list(begun.rounds), list(begun.steps)
    while len(steps[-1].effects if steps else ()) < effects_max:
        place = len(rounds)
        share = place / (effects_max + 1.0)
        tell(share, f"round {place + 1}: every effect of the library")
        held = steps[-1].effects if steps else ()
        least = strategy.needed(cost)
        if place == 0:
            every = found = _first_look(strategy)
        else:
            # what is fitted already is fitted again with each new effect: it takes its share of what they explain
            seen = here.beside(slopes(here, steps[-1]))
            screen = Screen(seen)
            found = signatures(screen, held, promising(screen, every, least) if every and strategy.only is None else strategy.only)
            every = every or found
        found = strategy.kept(found)
        scores = {name: signature.score for name, signature in _strongest(found).items()}
        tell(share + 0.5 / (effects_max + 1.0), f"round {place + 1}: refit of the strongest")
        confounded = strategy.confounded(steps[-1] if steps else None)
        if strategy.only is not None:
            confounded = [fit for fit in confounded if fit.effects[-1] in strategy.only]
        apart = {fit.effects[-1] for fit in confounded}
        worth = not rounds or max(scores.values(), default=0.0) > _WORTH_REFITS * least
        finalists = _finalists([one for one in found if one.candidate.effect not in apart], strategy) if worth else []
        values = dict(steps[-1].values) if steps else {}

        def refitted(one: Signature, values: Mapping[str, float] = values, seen: View | None = here if rounds else None) -> Fit:
            return refit(seen or one.view, joined(values, one.start()))

        fits = strategy.refined(best_of_each(fits_from(refitted, finalists)), confounded, cost)
        slight = {effect for fit in fits if strategy.is_slight(fit, effect := _newest(fit, held))}
        fits = strategy.in_order(tuple(fit for fit in fits if _newest(fit, held) not in slight))
        scores = {name: score for name, score in scores.items() if name not in slight}
        limits = {fit.effects[-1]: strategy.least_of_confounded(fit, least) for fit in confounded}
        rounds.append(Round(scores, fits, limits))
        shown = [(fit, limits.get(effect, least)) for fit in fits if fit.shown(effect := _newest(fit, held)) >= _SHOWN]
        enough = [(fit, must) for fit, must in shown if cost - fit.judged >= must]
        if not enough:
            break
        fit, must = enough[0]
        best = _pruned(fit, must)
        if any(set(best.effects) == set(step.effects) for step in steps):
            # what the new one takes the place of would come again in its place
            break
        steps.append(best)
        here = seen_from(best)
        cost = best.cost
    return Path(tuple(rounds), tuple(steps), here)


def standing_effects(evidence: Evidence, report: Report | None = None) -> Fit | None:
    """What a healthy machine shows beyond the model with its parameters fitted; None when it is nothing."""
    strategy = HealthyMachine(evidence)
    path = _grown(strategy, strategy.limits.effects, report or untold)
    return path.steps[-1] if path.steps else None


def diagnose(
    evidence: Evidence, report: Report | None = None, only: Collection[str] | None = None, effects_max: int | None = None
) -> Diagnosis:
    """The whole search on one record's evidence, among all effects and faults or `only` these, for sets of `effects_max` at most; `report` is told the share done and what is at work."""
    strategy = strategy_for(evidence, only)
    path = _grown(strategy, effects_max or strategy.limits.effects, report or untold)
    others = strategy.others(path, lambda begun, effects_max: _grown(strategy, effects_max, untold, begun))
    pool = [*(fit for made in path.rounds for fit in made.fits), *path.steps, *others]
    best = min(pool, key=lambda fit: fit.judged, default=None)
    if best is not None and only is None:
        pool += _special_cases(best)
    return weighed(best_of_each(pool), path, strategy)
