"""From evidence to a verdict: score every effect, refit the finalists, take the best, repeat, prune."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.parallel import each
from ema_tools.base.progress import Report
from ema_tools.fit.confounded import twin_of, twins
from ema_tools.fit.evidence import FAR, FAR_ROUNDS, Evidence, View, raw_cost, repeat_residuals, settled
from ema_tools.fit.nuisance import is_slight
from ema_tools.fit.refit import Fit, best_of_each, joined, jointly, polished, refit, seen_from, slopes, without_effect
from ema_tools.library.faults import FAULTS
from ema_tools.library.registry import record_of
from ema_tools.select.candidates import Signature, promising, signatures

# Effects whose refit is worth its time, at most, and how far behind the best score they may be.
_FINALISTS = 5
_FINALIST_SHARE = 0.4
_FINALIST_REACH = 30.0
# Without repeats the machine's own parameters are wide, and what they hide of an effect shows only when both are fitted together: more of them are.
_FINALISTS_ALONE = 8
_FINALIST_SHARE_ALONE = 0.1
# A set of effects grows no further than this.
_EFFECTS_MAX = 3
# Textbook chi-square limits are several times too low: the plant is not smooth, the noise is estimated, and the best of many shapes is taken.
LEAST_LIMIT = 30.0
_REPEAT_MARGIN = 1.5
# Without repeats there is nothing to take a limit from: twice that much, which of nearly 300 healthy machines of the benchmark's kind hardly one exceeds.
_LIMIT_ALONE = 2.0 * LEAST_LIMIT
# A healthy machine's standing effects are worth having in the model only when they are large against what repeats leave, and against each other.
_STANDING_LIMIT = 100.0
_STANDING_SHARE = 0.05
# An effect must also take off this share of the excess that was found, or most of what is left where more is left than noise can leave.
_LEAST_SHARE = 0.02
_MOST_OF_REST = 0.5
# Fits whose costs differ by less than this cannot be told apart: three standard deviations.
_ALIKE = 9.0
# A size must differ from none by this many standard errors; what lowers the error without one mends the arithmetic of another effect.
_SHOWN = 2.0
_UNEXPLAINED = 0.1
# Against repeats an error of twice the floor is no answer, however large the change was.
_FLOORS = 2.0
# Where both faults are fitted first: where they begin, in healthy values, and how many effects may follow.
_WORN_START = 1.3
_BESIDE_WEAR_MAX = 2
# The model is trusted to this share of what changed, in amplitude: what a missing interplay of a change and a standing error may leave.
_MODEL_ERROR = 0.02
# Without repeats what no parameter of a unit holds, such as a slight ripple of its friction, leaves more; a further effect must be larger than that.
_MODEL_ERROR_ALONE = 0.05
_POLISH_ROUNDS = {True: 1, False: 3}
# Without repeats: rounds of the fit of a finalist together with the machine, and the share of the limit that makes it worth them.
_JOINT_ROUNDS = 3
_WORTH_FITTING = 0.3
_GAIN_SHARE = 0.5
_TWIN_LIMIT = 9.0  # three standard deviations of a parameter


@dataclass(frozen=True)
class Round:
    """One round: the best score of each effect, strongest first, the refits that followed, best first, and the own limits of effects that are a parameter's twin."""

    scores: Mapping[str, float]
    fits: tuple[Fit, ...]
    limits: Mapping[str, float]


@dataclass(frozen=True)
class Named:
    """One effect of the answer's list: its class (itself first), values and standard errors as far as it was fitted, by how much it lowers the cost,
    what it must take off to be named, and whether it is accepted."""

    name: str
    alike: tuple[str, ...]
    values: Mapping[str, float]
    std: Mapping[str, float]
    score: float
    limit: float
    accepted: bool


@dataclass(frozen=True)
class Diagnosis:
    """What was found; `fit` None when nothing exceeds the limit. `unexplained`: share of the excess over the floor that is left.

    `steps`: the fits that were accepted one after the other, costs falling.
    """

    verdict: str
    fit: Fit | None
    named: tuple[Named, ...]
    rounds: tuple[Round, ...]
    steps: tuple[Fit, ...]
    cost_before: float
    cost_after: float
    cost_floor: float
    unexplained: float
    limit: float

    def refuted(self, effects: Collection[str]) -> Diagnosis:
        """The same after `effects` of the answer were refuted, by a record held out or by a size that could be none: they are not accepted, and where nothing else is, what is there is unknown."""
        named = tuple(replace(one, accepted=one.accepted and one.name not in effects) for one in self.named)
        return replace(self, named=named, verdict=self.verdict if any(one.accepted for one in named) else "unknown")

    @property
    def alike(self) -> tuple[str, ...]:
        """What looks like the first effect."""
        return self.named[0].alike[1:] if self.named else ()


def _finalists(found: Sequence[Signature], alone: bool) -> list[Signature]:
    """Per effect the strongest signature of each sign, of the few strongest effects."""
    if not found:
        return []
    top = found[0].score
    count, share = (_FINALISTS_ALONE, _FINALIST_SHARE_ALONE) if alone else (_FINALISTS, _FINALIST_SHARE)
    least = min(share * top, top - _FINALIST_REACH)
    chosen: dict[tuple[str, bool], Signature] = {}
    effects: list[str] = []
    for signature in found:
        name = signature.candidate.effect
        if signature.score <= least:
            break
        if name not in effects:
            effects.append(name)
        if effects.index(name) < count:
            chosen.setdefault((name, signature.size > signature.candidate.zero), signature)
    return list(chosen.values())


def _strongest(found: Sequence[Signature]) -> dict[str, Signature]:
    best: dict[str, Signature] = {}
    for signature in found:
        best.setdefault(signature.candidate.effect, signature)
    return best


def _limit_of(repeats: Sequence[Reals], found: Sequence[Signature]) -> float:
    """What the same signatures make of healthy repeats, with a margin."""
    most = 0.0
    for signature in found:
        length = float(signature.vector @ signature.vector)
        if length > 0.0:
            most = max([most, *(float(signature.vector @ repeat) ** 2 / length for repeat in repeats)])
    return max(LEAST_LIMIT, _REPEAT_MARGIN * most)


def _pruned(fit: Fit, limit: float) -> Fit:
    """Drops each earlier effect whose absence costs less than the limit."""
    current = fit
    for effect in fit.effects[:-1]:
        without = without_effect(current.values, effect)
        if without:
            smaller = refit(settled(current.view.evidence, without, current.view.deviations, 1), without)
            if smaller.cost - current.cost < limit:
                current = smaller
    return current


@dataclass(frozen=True)
class _Path:
    """How a set of effects grew: rounds, accepted fits one after the other, and the view from the last."""

    rounds: tuple[Round, ...]
    steps: tuple[Fit, ...]
    view: View


def _with_twins(fits: Sequence[Fit], exact: Sequence[Fit]) -> tuple[Fit, ...]:
    names = {fit.effects for fit in exact}
    return best_of_each([*exact, *(fit for fit in fits if fit.effects not in names)])


def _is_slight(fit: Fit, effect: str) -> bool:
    return any(is_slight(fit.view.evidence.actuator, name, value) for name, value in fit.of_effect(effect).items())


def _newest(fit: Fit, held: Sequence[str]) -> str:
    return next((effect for effect in fit.effects if effect not in held), fit.effects[-1])


def _first_look(start: View, free: View) -> list[Signature]:
    """Every effect's signatures, scores counted from `free`.

    Without repeats there are two places to look from: where the machine is still credible, and where it stands in for what is missing as well as it can. An effect that a
    parameter of the machine does as well at first shows from there alone, one that bends from here alone.
    """
    seen = [
        replace(one, score=one.score - (view.cost - free.cost))
        for view in ((start,) if free is start else (start, free))
        for one in signatures(view)
    ]
    return sorted(seen, key=lambda signature: -signature.score)


def _grown(
    start: View,
    needed: Callable[[Sequence[Signature], int, float], float],
    effects_max: int,
    tell: Report,
    free: View | None = None,
    begun: _Path | None = None,
) -> _Path:
    """Adds the effect that takes off most, as long as it takes off what `needed` says of the signatures, the round and the present cost.

    `begun`: what has been added already. `free`: for a record of a unit that is known by its data sheet alone, where the unit's own parameters explain most.
    """
    here, cost = start, (free or start).cost
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
            every = found = _first_look(start, free or start)
            least = needed(found, place, cost)
        else:
            least = needed((), place, cost)
            # what is fitted already is fitted again with each new effect: it takes its share of what they explain
            seen = here.beside(slopes(here, steps[-1]))
            found = signatures(seen, held, promising(seen, every, least) if every else None)
            every = every or found
        found = found if free is None else [one for one in found if not is_slight(start.evidence.actuator, one.candidate.size, one.size)]
        scores = {name: signature.score for name, signature in _strongest(found).items()}
        tell(share + 0.5 / (effects_max + 1.0), f"round {place + 1}: refit of the strongest")
        exact = twins(free) if free is not None and not rounds else []
        known = {fit.effects[0] for fit in exact}
        finalists = (
            _finalists([one for one in found if one.candidate.effect not in known], free is not None)
            if not rounds or max(scores.values(), default=0.0) > 0.7 * least
            else []
        )
        values = dict(steps[-1].values) if steps else {}

        def refitted(one: Signature, values: Mapping[str, float] = values, seen: View | None = here if rounds else None) -> Fit:
            return refit(seen or one.view, joined(values, one.start()))

        fits = best_of_each(each(refitted, finalists))
        if free is None:
            reach = max(_FINALIST_REACH, 0.3 * fits[0].judged) if fits else 0.0
            fits = _polished(fits, lambda fit: polished(fit, _POLISH_ROUNDS[fit.view.evidence.relative]), reach)
        else:
            gain = cost - fits[0].judged if fits else 0.0
            if gain > _WORTH_FITTING * LEAST_LIMIT:
                fits = _polished(fits, lambda fit: jointly(fit, _JOINT_ROUNDS), max(_FINALIST_REACH, _GAIN_SHARE * gain))
            fits = fits if rounds else _with_twins(fits, exact)
            slight = {_newest(fit, held) for fit in fits if _is_slight(fit, _newest(fit, held))}
            fits = tuple(fit for fit in fits if _newest(fit, held) not in slight)
            scores = {name: score for name, score in scores.items() if name not in slight}
        # that a twin is there is a matter of what the data sheet leaves open alone, which no roughness of the model and no choice of shapes can feign
        least_of_twin = min(least, _TWIN_LIMIT * max(1.0, cost / max(start.evidence.floor, 1.0)))
        limits = dict.fromkeys(known, least_of_twin)
        rounds.append(Round(scores, fits, limits))
        shown = [(fit, limits.get(effect, least)) for fit in fits if fit.shown(effect := _newest(fit, held)) >= _SHOWN]
        enough = [(fit, must) for fit, must in shown if cost - fit.judged >= must]
        if not enough:
            break
        best = _pruned(*enough[0])
        steps.append(best)
        here = seen_from(best)
        cost = best.cost
    return _Path(tuple(rounds), tuple(steps), here)


def _worn_first(start: View, path: _Path, needed: Callable[[Sequence[Signature], int, float], float], tell: Report) -> _Path:
    """The path that begins with both faults, where that of the strongest effect ends far from the floor; the better of the two.

    Wear moves CSJ and BLK together, and beside an effect of their size the first of the three to be fitted alone takes a share of the other two, which no later one gives back.
    """
    actuator = start.evidence.actuator
    values = {name: _WORN_START * actuator[name] for name in FAULTS.values() if actuator[name] > 0.0}
    if not values:
        return path
    worn = polished(refit(start, values), _POLISH_ROUNDS[True])
    first = replace(path.rounds[0], fits=(worn, *path.rounds[0].fits))
    begun = _Path((first,), (worn,), seen_from(worn))
    other = _grown(start, needed, len(worn.effects) + _BESIDE_WEAR_MAX, tell, begun=begun)
    return other if other.steps[-1].judged < path.steps[-1].judged else path


def standing_effects(evidence: Evidence, report: Report | None = None) -> Fit | None:
    """What a healthy machine shows beyond the model with its parameters fitted; None when it is nothing."""
    here = settled(evidence, {})
    excess = max(here.cost - evidence.numbers, 0.0)
    needed = max(_STANDING_LIMIT, _STANDING_SHARE * excess)
    path = _grown(here, lambda _found, _place, _cost: needed, _EFFECTS_MAX, report or (lambda _share, _text: None))
    return path.steps[-1] if path.steps else None


def diagnose(evidence: Evidence, report: Report | None = None) -> Diagnosis:
    """The whole search on one record's evidence; `report` is told the share done and what is at work."""
    here = settled(evidence, {})
    repeats = repeat_residuals(evidence)
    costs = np.array([float(repeat @ repeat) for repeat in repeats]) if repeats else np.array([evidence.floor])
    floor = float(costs.mean())
    free = None if evidence.relative else settled(evidence, {}, here.deviations, rounds=FAR_ROUNDS, reach=FAR)
    before = (free or here).cost
    excess = max(before - floor, 1e-9)
    # without repeats most of what the model leaves is the unit's own, which is fitted
    beyond = max((raw_cost(evidence) if evidence.relative else here.cost) - floor, 0.0)
    doubt = _MODEL_ERROR**2 * beyond
    further = doubt if evidence.relative else _MODEL_ERROR_ALONE**2 * beyond
    limit = LEAST_LIMIT if evidence.relative else _LIMIT_ALONE
    noise = 6.0 * (float(np.std(costs)) + np.sqrt(2.0 * here.residual.size))

    def needed(found: Sequence[Signature], place: int, cost: float) -> float:
        nonlocal limit
        if place == 0 and evidence.relative:
            limit = _limit_of(repeats, found)
        return max(_needed(limit, excess, cost, floor, noise, evidence), further if place else 0.0)

    tell = report or (lambda _share, _text: None)
    path = _grown(here, needed, _EFFECTS_MAX, tell, free)
    most = _FLOORS**2 * floor if evidence.relative else np.inf
    if path.steps and path.steps[-1].cost > most:
        path = _worn_first(here, path, needed, tell)
    steps = path.steps
    if steps and free is not None and not (len(steps) == 1 and all(map(twin_of, steps[0].values))):
        steps = (*steps[:-1], jointly(steps[-1]))
    best = steps[-1] if steps else None
    cost = best.cost if best is not None else before
    unexplained = max(cost - floor, 0.0) / excess
    strange = cost - floor > max(noise, 2.0 * doubt)
    far = unexplained > _UNEXPLAINED or cost > most
    verdict = "unknown" if strange and far else "missing" if best is not None else "adequate"
    named = _named(path.rounds, best, steps, verdict, doubt, before, limit)
    found = Diagnosis(verdict, best, named, path.rounds, steps, before, cost, floor, unexplained, limit)
    # beside a large misfit a size that could be none says that something else is there
    vague = (
        [effect for effect in best.effects if not best.determined(effect)]
        if best is not None and evidence.relative and verdict == "missing"
        else []
    )
    return found.refuted(vague) if vague else found


def _needed(limit: float, excess: float, cost: float, floor: float, noise: float, evidence: Evidence) -> float:
    """What an effect must take off: the limit, a share of the excess or most of a rest that is no `noise`; without repeats, in units of the misfit that is left."""
    inflated = limit if evidence.relative else limit * max(1.0, cost / floor)
    rest = cost - floor
    share = min(_LEAST_SHARE * excess, _MOST_OF_REST * rest) if rest > noise else _LEAST_SHARE * excess
    return max(inflated if evidence.relative else min(inflated, 0.05 * excess + limit), share)


def _polished(fits: tuple[Fit, ...], better: Callable[[Fit], Fit], reach: float) -> tuple[Fit, ...]:
    """Those of the fits made better, with what scatters where they are, that are at most `reach` behind the best."""
    if not fits:
        return fits
    near = [fit for fit in fits if fit.judged < fits[0].judged + reach]
    rest = [fit for fit in fits if fit.judged >= fits[0].judged + reach]
    return best_of_each([*each(better, near), *rest])


def _named(
    rounds: Sequence[Round], best: Fit | None, steps: Sequence[Fit], verdict: str, doubt: float, before: float, limit: float
) -> tuple[Named, ...]:
    """Accepted effects in the order in which they came, then the others by what they would take off alone against what they must."""
    found: list[Named] = []
    accepted = best.effects if best is not None else ()
    tolerance = max(_ALIKE, doubt)
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
    return (*found, *sorted(others, key=lambda one: -one.score / one.limit))
