"""From evidence to a verdict: score every effect, refit the finalists, take the best, repeat, prune. What differs from case to case is a strategy's."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial

from ema_tools.base.parallel import each
from ema_tools.base.progress import Report, untold
from ema_tools.fit.evidence import Evidence, View, settled
from ema_tools.fit.refit import POLISHED, Fit, best_of_each, joined, polished, pruned, refit, seen_from, slopes, without_effect
from ema_tools.library.definitions import load_definitions
from ema_tools.library.faults import FAULTS
from ema_tools.library.registry import record_of
from ema_tools.select.candidates import Signature, promising, signatures
from ema_tools.select.matched_filter import Screen
from ema_tools.select.outcome import Diagnosis, Named, Path, Round
from ema_tools.select.probable import weighed
from ema_tools.select.strategies import strategy_for
from ema_tools.select.strategies.healthy_machine import HealthyMachine
from ema_tools.select.strategies.strategy import ALIKE, Strategy, begun_with

# A size must differ from none by this many standard errors; what lowers the error without one mends the arithmetic of another
# effect [chance]
_SHOWN = 2.0
UNEXPLAINED = 0.1  # with more than this share of the excess left the answer is that something is missing, not what [judgement]
# ... but for one effect alone that no other comes near, of which its own form may leave more, and for friction or play, which are
# what is watched: [measured]
_OF_ITS_FORM, _OF_A_FAULT = 0.125, 0.35
_OF_SPECIAL = 0.1  # of what a special case leaves above the floor, that the general one must take off [judgement]
# a rival that leaves less than so many times as much above the floor comes near, and less than this share of the excess [judgement]
_NEAR, _NOTHING = 4.0, 0.9
# The model is trusted to this share of what changed, in amplitude: what a missing interplay of a change and a standing error may
# leave [judgement]
_MODEL_ERROR = 0.02
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


def _as_special_case(fit: Fit, effect: str) -> Fit | None:
    """The fit with the effect in its special case, from the values that both have; None where it is no other's, or they have none."""
    special = record_of(effect).special_case
    if not special:
        return None
    own = fit.of_effect(effect)
    known = {f"effects.{row.name}" for row in load_definitions().effect(special).parameters}
    shared = {name.replace(f"effects.{effect}.", f"effects.{special}."): value for name, value in own.items()}
    shared = {name: value for name, value in shared.items() if name in known}
    if not shared:
        return None
    start = {**without_effect(fit.values, effect), **shared}
    # the view of the fit holds the effect itself
    return refit(settled(fit.view.evidence, start, fit.view.deviations, 1), start)


def _with_special_cases(fits: tuple[Fit, ...], held: Sequence[str], first: str) -> tuple[Fit, ...]:
    """With the fit of the special case of effect `first` where it has none yet, and of every other one that stays so far behind what it is a case of that its own fit has gone astray."""
    newest = {_newest(fit, held): fit for fit in reversed(fits)}
    asked = []
    for effect, fit in newest.items():
        special = newest.get(record_of(effect).special_case)
        if effect == first if special is None else special.judged - fit.judged > ALIKE:
            asked.append((fit, effect))
    cases = each(lambda one: _as_special_case(*one), asked)
    return best_of_each([*fits, *(case for case in cases if case is not None)])


def _without_needless(fits: tuple[Fit, ...], held: Sequence[str], needed: Callable[[float], float], floor: float) -> tuple[Fit, ...]:
    """Without the fit of an effect that is another one in a special case and does not take off beyond that one what a further effect must, `needed` at a cost, and a good share of what that
    one leaves above the floor: where the hidden form is neither's, the one with more values always leaves a little less."""
    if not fits:
        return fits
    first = _newest(fits[0], held)
    fits = _with_special_cases(fits, held, first)
    by_newest = {_newest(fit, held): fit for fit in reversed(fits)}

    def needless(effect: str) -> bool:
        special = by_newest.get(record_of(effect).special_case)
        if special is None:
            return False
        return special.judged - by_newest[effect].judged < max(needed(special.cost), _OF_SPECIAL * (special.cost - floor))

    return tuple(fit for fit in fits if not needless(_newest(fit, held)))


def _in_special_cases(path: Path, strategy: Strategy) -> Path:
    """The path with an effect of its last set in its special case, where that leaves hardly more: beside what came after it nothing may be left of what it has more."""
    best = path.steps[-1] if path.steps else None
    for effect in best.effects if best is not None else ():
        special = _as_special_case(path.steps[-1], effect)
        if special is None or len(special.effects) < len(path.steps[-1].effects):
            continue
        special = strategy.refined((special,), (), strategy.before)[0]
        if special.judged - path.steps[-1].judged < strategy.needed((), len(path.rounds), special.cost):
            path = begun_with(special, path)
    return path


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
        if place == 0:
            every = found = _first_look(strategy)
            least = strategy.needed(found, place, cost)
        else:
            least = strategy.needed((), place, cost)
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

        fits = strategy.refined(best_of_each(each(refitted, finalists)), confounded, cost)
        slight = {effect for fit in fits if strategy.is_slight(fit, effect := _newest(fit, held))}
        fits = tuple(fit for fit in fits if _newest(fit, held) not in slight)
        if strategy.only is None:
            fits = _without_needless(fits, held, partial(strategy.needed, (), place + 1), strategy.floor)
        fits = strategy.in_order(fits)
        scores = {name: score for name, score in scores.items() if name not in slight}
        limits = {fit.effects[-1]: strategy.least_of_confounded(fit, least) for fit in confounded}
        for fit in fits:
            chance = strategy.least_by_chance(effect := _newest(fit, held))
            if chance > limits.get(effect, least):
                limits[effect] = chance
        rounds.append(Round(scores, fits, limits))
        shown = [(fit, limits.get(effect, least)) for fit in fits if fit.shown(effect := _newest(fit, held)) >= _SHOWN]
        if rounds[1:]:
            shown = [(fit, max(must, strategy.least_beside(cost, fit.cost))) for fit, must in shown]
        enough = [(fit, must) for fit, must in shown if cost - fit.judged >= must]
        if not enough:
            break
        fit, must = enough[0]
        best = _pruned(fit, strategy.least_kept(must, fit.cost))
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


def _ended(strategy: Strategy, tell: Report, effects_max: int | None = None) -> Path:
    path = _grown(strategy, effects_max or strategy.limits.effects, tell)
    return strategy.ended(path, lambda begun, effects_max: _grown(strategy, effects_max, tell, begun))


def _as_known(path: Path, strategy: Strategy, evidence: Evidence, only: Collection[str] | None) -> Path:
    """The path, or where what varies goes farther than it does the effects that are found where the machine is taken for known, if they explain more beside all that varies: a large change is
    first taken up by what varies, and the effects are then sought in what that leaves."""
    if evidence.of_known is None or not path.steps or not strategy.is_strained(path.steps[-1]):
        return path
    other = _ended(strategy_for(evidence.of_known, only), untold)
    if not other.steps:
        return path
    fit = polished(refit(strategy.start, other.steps[-1].values), POLISHED)
    return begun_with(fit, path) if fit.judged < path.steps[-1].judged - 1.0 else path


def diagnose(
    evidence: Evidence, report: Report | None = None, only: Collection[str] | None = None, effects_max: int | None = None
) -> Diagnosis:
    """The whole search on one record's evidence, among all effects and faults or `only` these, for sets of `effects_max` at most; `report` is told the share done and what is at work."""
    strategy = strategy_for(evidence, only)
    tell = report or untold
    path = _ended(strategy, tell, effects_max)
    if strategy.by_probability:
        return weighed(path, strategy)
    path = _as_known(path, strategy, evidence, only)
    path = _in_special_cases(path, strategy) if only is None else path
    alone = _alone(path, strategy) if path.steps and _is_far(path.steps[-1].cost, strategy) else None
    # what its own form leaves of it is no second effect
    path = replace(path, steps=(alone,)) if alone is not None else path
    steps, before, floor = path.steps, strategy.before, strategy.floor
    best = steps[-1] if steps else None
    cost = best.cost if best is not None else before
    doubt = _MODEL_ERROR**2 * strategy.beyond
    unexplained = _unexplained(cost, strategy)
    strange = cost - floor > max(strategy.noise, 2.0 * doubt)
    far = _is_far(cost, strategy) and alone is None
    verdict = "unknown" if strange and far else "missing" if best is not None else "adequate"
    # what a rival leaves more is its own form's error only where the answer's form errs, too
    named = _named(path.rounds, best, steps, verdict, min(doubt, max(cost - floor, 0.0)), before, strategy.limit)
    found = Diagnosis(
        verdict, best, named, path.rounds, steps, before, cost, floor, unexplained, strategy.limit, _MODEL_ERROR**2 * strategy.excess
    )
    vague = strategy.vague(best) if best is not None and verdict == "missing" else []
    return found.refuted(vague) if vague else found


def _unexplained(cost: float, strategy: Strategy) -> float:
    """Share of the excess that a cost leaves."""
    return max(cost - strategy.floor, 0.0) / strategy.excess


def _is_far(cost: float, strategy: Strategy) -> bool:
    """Whether so much is left that what explains the rest is no answer yet."""
    return _unexplained(cost, strategy) > UNEXPLAINED or strategy.is_no_answer(cost)


def _alone(path: Path, strategy: Strategy) -> Fit | None:
    """The first look's fit of one effect, or of a fault, that explains what no other comes near: it is that one in a form of its own, however much of a large change its form leaves."""
    tried = [path.steps[0], *path.rounds[0].fits]
    first = min((fit for fit in tried if len(fit.effects) == 1), key=lambda fit: fit.judged, default=None)
    if first is None:
        return None
    left, excess = first.cost - strategy.floor, strategy.excess
    rivals = [fit.judged - strategy.floor for fit in tried if not any(_one_physics(first.effects[0], other) for other in fit.effects)]
    if any(rival <= min(_NEAR * left, _NOTHING * excess) for rival in rivals):
        return None
    # of all that changed, what varies by itself has taken a part
    changed = max(excess, strategy.beyond)
    return first if left < (_OF_A_FAULT if first.effects[0] in FAULTS else _OF_ITS_FORM) * changed else None


def _one_physics(effect: str, other: str) -> bool:
    """Whether two effects are one, cannot be told apart, or one is the other in a special case, which explains what that one explains."""
    one, its = record_of(effect), record_of(other)
    return other in (effect, *one.inseparable, one.special_case) or its.special_case == effect


def _named(
    rounds: Sequence[Round], best: Fit | None, steps: Sequence[Fit], verdict: str, doubt: float, before: float, limit: float
) -> tuple[Named, ...]:
    """Accepted effects in the order in which they came, then the others by what they would take off alone against what they must."""
    found: list[Named] = []
    accepted = best.effects if best is not None else ()
    tolerance = max(ALIKE, doubt)
    for effect in accepted:
        place = next(k for k, step in enumerate(steps) if effect in step.effects)
        fits = rounds[place].fits
        own = next((fit for fit in fits if effect in fit.effects), fits[0])
        held = set(steps[place - 1].effects) if place else set()
        alike = [
            other
            for fit in fits
            if fit.judged - own.judged < tolerance
            for other in fit.effects
            if other not in held and other not in own.effects
        ]
        alike += record_of(effect).inseparable
        std = {name: value for name, value in best.std.items() if name in best.of_effect(effect)} if best else {}
        earlier = steps[place - 1].cost if place else before
        values = best.of_effect(effect) if best else {}
        found.append(
            Named(
                effect,
                (effect, *dict.fromkeys(alike)),
                values,
                std,
                earlier - steps[place].cost,
                rounds[0].limits.get(effect, limit),
                verdict == "missing",
            )
        )
    first = rounds[0]
    tried = {fit.effects[0]: fit for fit in reversed(first.fits)}
    others = []
    for effect in {*first.scores, *tried} - set(accepted):
        fit = tried.get(effect)
        alike = list(record_of(effect).inseparable)
        if fit is not None and not accepted:
            alike += [other.effects[0] for other in first.fits if other.effects[0] != effect and abs(other.judged - fit.judged) < tolerance]
        score = before - fit.judged if fit is not None else first.scores[effect]
        others.append(
            Named(
                effect,
                (effect, *dict.fromkeys(alike)),
                fit.values if fit else {},
                fit.std if fit else {},
                score,
                first.limits.get(effect, limit),
                False,
            )
        )
    return (*found, *sorted(others, key=lambda one: (-one.score / one.limit, one.name)))
