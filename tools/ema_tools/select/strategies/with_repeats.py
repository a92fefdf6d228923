"""Against healthy repeats: what has changed on this machine."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from scipy import special

from ema_tools.base.arrays import Reals
from ema_tools.base.parallel import each
from ema_tools.fit.confounded import confounded_fits
from ema_tools.fit.evidence import FAR, FAR_ROUNDS, Evidence, View, raw_cost, settled
from ema_tools.fit.misfit import in_noise
from ema_tools.fit.refit import Fit, best_of_each, joined, joint, polished, pruned, refit, seen_from, shares_left, without_effect, worn
from ema_tools.library.faults import FAULTS, effect_of
from ema_tools.library.registry import record_of
from ema_tools.select.candidates import Signature, signatures
from ema_tools.select.matched_filter import Screen
from ema_tools.select.outcome import Path
from ema_tools.select.strategies.strategy import LEAST_LIMIT, SearchLimits, Strategy, begun_with, polished_near

_NOISE_WEIGHT = 10.0  # records as which it counts that an effect does not vary from run to run: its signature is then noise [judgement]
_ALSO_SHOWN = 0.5  # of the strongest signature of an effect: others that explain as much of the record tell how it varies, too [judgement]
_BY_CHANCE = (
    1e-4  # of what scatters, to either side, that is taken for a change: of a record's few such values one in a thousand records [chance]
)
_POLISH_ROUNDS = 1  # of fits with what scatters linear at the last one [effort]
_FLOORS = 2.0  # an error of so many times the floor is no answer, however large the change was [judgement]
_BESIDE_WEAR_MAX = 2  # effects that may follow where both faults are fitted first [effort]
_GOOD_PART = 0.3  # of what is left: an effect that explains so much of it needs no more [judgement]
_RIVALS = 2  # of each round that are tried in the place of what was taken [effort]
_LAST_ROUNDS = 3  # of the one fit that is the answer [effort]
_HIDDEN = 0.25  # of what a change of a value makes: where what scatters leaves less, the two lie in one narrow valley [measured]
_JOINT_ROUNDS = 2  # of the answer together with what scatters [effort]
_RUNS_AWAY = 5.0  # standard deviations of what scatters that no run makes [chance]
# Where a fault begins beside an effect, in healthy values: friction that grows moves the places of rest, and one beginning does not find them all [measured]
_BESIDE_STARTS = (1.1, 1.3)


class WithRepeats(Strategy):
    """The repeats say what a record with nothing new is like, and what the same signatures make of it."""

    limits = SearchLimits(
        finalists=5,  # every further one costs its refits [effort]
        finalist_share=0.4,  # a signature at its best size has most of what a refit gives [effort]
        least=LEAST_LIMIT,
        model_error=0.02,  # what a missing interplay of a change and a standing error may leave [judgement]
    )

    def __init__(self, evidence: Evidence, only: Collection[str] | None = None) -> None:
        self._repeats = evidence.of_repeats
        self._from_run_to_run: dict[str, float] = {}
        super().__init__(evidence, only)
        self._beyond = max(raw_cost(evidence) - self.floor, 0.0)

    def floor_costs(self) -> Reals:
        """Of each repeat against the others."""
        return np.array([float(repeat @ repeat) for repeat in self._repeats])

    @property
    def beyond(self) -> float:
        """Nothing of the machine moved."""
        return self._beyond

    def limit_at(self, found: Sequence[Signature], place: int, _cost: float) -> float:
        """The least of any effect; the first look tells besides by how much each effect varies on the repeats themselves."""
        if place == 0:
            self._from_run_to_run = self._varying(found)
        return self.limit

    def _varying(self, found: Sequence[Signature]) -> dict[str, float]:
        """What each effect's signatures take off by chance, by Student's factor: their variance on the repeats, over that of noise, beside a usual one of noise alone."""
        freedom = _NOISE_WEIGHT + len(self._repeats) - 1.0
        factor = float(special.stdtrit(freedom, _BY_CHANCE) ** 2)
        strongest: dict[str, float] = {}
        varying: dict[str, float] = {}
        for one in found:
            effect, square = one.candidate.effect, one.shown.square
            strongest.setdefault(effect, one.score)
            if square > 0.0 and one.score >= _ALSO_SHOWN * strongest[effect]:
                shown = float(np.mean([one.shown.product(repeat) ** 2 / square for repeat in self._repeats]))
                varying[effect] = max(varying.get(effect, 0.0), (_NOISE_WEIGHT + (freedom - _NOISE_WEIGHT) * shown) / freedom)
        return {effect: factor * variance for effect, variance in varying.items()}

    def confounded(self, held: Fit | None) -> list[Fit]:
        """Where what scatters would go beyond what is credible: in place of a value that does, the effect that does the same."""
        if held is not None or not self.start.at_edge:
            return []
        far = settled(self.evidence, {}, self.start.deviations, rounds=FAR_ROUNDS, reach=FAR)
        fits = [fit for fit in confounded_fits(far) if fit.cost < self.before]
        return [fit for fit in fits if np.max(np.abs(fit.view.deviations), initial=0.0) < _RUNS_AWAY]

    def least_by_chance(self, effect: str) -> float:
        """How far a value goes that scatters by a width of which these repeats, and the usual, tell: by Student's factor, and not at all where its width is stated."""
        own = FAULTS[effect] if effect in FAULTS else getattr(record_of(effect).confounded, "parameter", "")
        varying = self._from_run_to_run.get(effect, 0.0)
        if not any(own in one.names for one in (*self.evidence.spread, *self.evidence.varies)) or own in self.evidence.actuator.scatter:
            return varying
        return max(float(special.stdtrit(self.evidence.freedom, _BY_CHANCE) ** 2), varying)

    def least_kept(self, must: float, left: float) -> float:
        """What the error of the others' forms gives by chance, where what varies takes most of it: what stays above the floor is spread over so many directions in which a form errs, and each of
        them counts as noise does."""
        return self._by_form(left) if self.evidence.varies else must

    def _by_form(self, left: float) -> float:
        return self.limits.least * in_noise(left - self.floor)

    def least_beside(self, cost: float, left: float) -> float:
        """The same; an effect that takes off a good part of what is left needs no more."""
        return min(self._by_form(left), _GOOD_PART * max(cost - self.floor, 0.0)) if self.evidence.varies else 0.0

    def refined(self, fits: tuple[Fit, ...], confounded: Sequence[Fit], _cost: float) -> tuple[Fit, ...]:
        """With what scatters linear where they are."""
        fits = polished_near(fits, _POLISH_ROUNDS, self.limits)
        return best_of_each([*confounded, *fits]) if confounded else fits

    def is_no_answer(self, cost: float) -> bool:
        """So far above the floor."""
        return cost > _FLOORS**2 * self.floor

    def ended(self, path: Path, grow: Callable[[Path, int], Path]) -> Path:
        """The likelier of the path, those that begin with wear and one of its effects alone; its last fit settled together with what scatters where an effect does the same."""
        path = self._swapped(self._likelier(path, grow))
        path = self.fewer(path, lambda start: polished(refit(self.start, start), _LAST_ROUNDS))
        return _with_scatter(self._without_idle(path))

    def _swapped(self, path: Path) -> Path:
        """The path, or a better one in which a rival of the round in which an effect was taken stands in its place: beside what came later the order may be another."""
        if not path.steps or len(path.steps[-1].effects) < 2:
            return path
        best, held = path.steps[-1], frozenset[str]()
        starts = []
        for step, tried in zip(path.steps, path.rounds, strict=False):
            taken = next((effect for effect in step.effects if effect not in held), "")
            rivals = [fit for fit in tried.fits if taken not in fit.effects and taken in best.effects]
            for fit in rivals[:_RIVALS]:
                other = {name: value for name, value in fit.values.items() if effect_of(name) not in {*held, *best.effects}}
                starts += [joined(without_effect(best.values, taken), other)] if other else []
            held = frozenset(step.effects)
        fits = each(lambda start: polished(refit(self.start, start), _POLISH_ROUNDS), starts)
        found = min(fits, key=lambda fit: fit.judged, default=best)
        return begun_with(found, path) if found.judged < best.judged - 1.0 else path

    def _without_idle(self, path: Path) -> Path:
        """The path with its last fit without each effect that takes off less than every effect must, beside the others as they are in the end."""
        best = path.steps[-1] if path.steps else None
        if best is None or len(best.effects) < 2:
            return path
        left = pruned(best, best.effects, lambda effect, fit: max(self.least_by_chance(effect), self._by_form(fit.cost)), _POLISH_ROUNDS)
        return path if left is best else begun_with(left, path)

    def _likelier(self, path: Path, grow: Callable[[Path, int], Path]) -> Path:
        """The path, or a better one that begins with wear.

        Where the way of the strongest effect ends far from the floor, the way that begins with both faults is tried too, and the better of the two is taken. Wear moves CSJ and BLK together,
        and beside an effect of their size the first of the three to be fitted alone takes a share of the other two, which no later one gives back.
        And several effects without a fault are held against a fault beside one or two of them: what explains the record as well with less is the likelier.
        """
        if not path.steps:
            return path
        if self.is_no_answer(path.steps[-1].cost):
            first = worn(self.start)
            if first is None:
                return path
            other = grow(begun_with(first, path), len(first.effects) + _BESIDE_WEAR_MAX)
            return self._other_swings(other if other.steps[-1].judged < path.steps[-1].judged else path, grow)
        return self._simpler(path)

    def _other_swings(self, path: Path, grow: Callable[[Path, int], Path]) -> Path:
        """The path, or where it is no answer the better one in which a swing has another number of periods or another phase: beside a machine that rests often, the one that looks strongest need
        not be the one that explains most."""
        best = path.steps[-1]
        swings = [effect for effect in best.effects if effect not in FAULTS and record_of(effect).periodic is not None]
        if not swings or not self.is_no_answer(best.cost):
            return path
        fits = []
        for effect in swings:
            rest = without_effect(best.values, effect)
            seen = seen_from(refit(self.start, rest)) if rest else self.start
            held = [one for one in best.effects if one != effect]
            by_number: dict[float, Signature] = {}
            for one in signatures(Screen(seen), held, (effect,)):
                by_number.setdefault(one.start().get(f"effects.{effect}.periods", 1.0), one)
            starts = [joined(rest, one.start()) for one in by_number.values()]
            fits += each(partial(_polished_from, seen), starts)
        found = min(fits, key=lambda fit: fit.cost, default=best)
        return grow(begun_with(found, path), len(found.effects) + _BESIDE_WEAR_MAX) if found.cost < best.cost else path

    def _simpler(self, path: Path) -> Path:
        """The path to a fault beside fewer effects of the last fit, where that leaves hardly more than the whole set; the given one where none does."""
        best = path.steps[-1]
        if len(best.effects) < 2 or set(best.effects) & set(FAULTS):
            return path
        actuator = self.evidence.actuator
        starts = [
            {**best.of_effect(effect), name: share * actuator[name]}
            for name in FAULTS.values()
            if actuator[name] > 0.0
            for share in _BESIDE_STARTS
            for effect in best.effects
        ]
        fits = best_of_each(each(partial(_polished_from, self.start), starts))
        # an effect that the larger set has more must have taken off what every effect must
        allowed = best.cost + self.limits.least * (len(best.effects) - 2)
        shown = [fit for fit in fits if fit.cost < max(allowed, best.cost + 1.0) and all(map(fit.determined, fit.effects))]
        if not shown:
            return path
        return begun_with(min(shown[0], polished(shown[0], _LAST_ROUNDS), key=lambda fit: fit.cost), path)

    def is_strained(self, best: Fit) -> bool:
        """Farther than any run does: it stands in for something else."""
        return bool(np.any(np.abs(best.view.best_deviations(best.view.moved(best.values), np.inf)) > _RUNS_AWAY))

    def vague(self, best: Fit) -> list[str]:
        """Beside a large misfit a size that could be none says that something else is there."""
        return [effect for effect in best.effects if not best.determined(effect)]


def _polished_from(view: View, start: Mapping[str, float]) -> Fit:
    return polished(refit(view, start), _POLISH_ROUNDS)


def _with_scatter(path: Path) -> Path:
    """The path with its last fit settled together with what scatters, where that hides one of its effects: in their narrow valley steps with the scatter linear hardly move."""
    if not path.steps:
        return path
    last = path.steps[-1]
    if min(shares_left(path.view, last), default=1.0) >= _HIDDEN:
        return path
    found = joint(replace(last, view=path.view, cost=path.view.cost), _JOINT_ROUNDS)
    # a unit of cost is no difference; scatter that runs away stands in for an effect that is missing
    if found.cost > last.cost + 1.0 or np.max(np.abs(found.view.deviations), initial=0.0) >= _RUNS_AWAY:
        return path
    return replace(path, steps=(*path.steps[:-1], found), view=found.view)
