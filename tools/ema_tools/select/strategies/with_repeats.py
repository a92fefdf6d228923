"""Against healthy repeats: what has changed on this machine."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from ema_tools.data.actuator import row_of
from ema_tools.fit.confounded import confounded_with
from ema_tools.fit.evidence import FAR, FAR_ROUNDS, View, settled
from ema_tools.fit.nuisance import Spread
from ema_tools.fit.refit import Fit, fits_from, joined, joint, polished, refit, seen_from, shares_left, without_effect, worn
from ema_tools.library.faults import FAULTS, effect_of
from ema_tools.library.registry import record_of
from ema_tools.select.candidates import Signature, signatures
from ema_tools.select.matched_filter import Screen
from ema_tools.select.outcome import Path
from ema_tools.select.strategies.strategy import LEAST_LIMIT, SearchLimits, Strategy, begun_with, polished_near

_POLISH_ROUNDS = 1  # of fits with what scatters linear at the last one [effort]
_FLOORS = 2.0  # an error of so many times the floor is worth another beginning [effort]
_BESIDE_WEAR_MAX = 2  # effects that may follow where both faults are fitted first [effort]
_RIVALS = 2  # of each round that are tried in the place of what was taken [effort]
_LAST_ROUNDS = 3  # of the one fit that is the answer [effort]
_HIDDEN = 0.25  # of what a change of a value makes: where what scatters leaves less, the two lie in one narrow valley [measured]
_JOINT_ROUNDS = 2  # of the answer together with what scatters [effort]
_OF_NO_DAY = 4.0  # standard deviations that no day makes [chance]
_RUNS_AWAY = 5.0  # standard deviations of what scatters that no run makes [chance]
# Where a fault begins beside an effect, in healthy values: friction that grows moves the places of rest, and one beginning does not find them all [measured]
_BESIDE_STARTS = (1.1, 1.3)


class WithRepeats(Strategy):
    """The repeats say what a record with nothing new is like, and what the same signatures make of it."""

    limits = SearchLimits(
        finalists=5,  # every further one costs its refits [effort]
        finalist_share=0.4,  # a signature at its best size has most of what a refit gives [effort]
        least=LEAST_LIMIT,
    )

    def floor_cost(self) -> float:
        """Of the repeats, each against the others."""
        return self.evidence.expected_cost()

    def refined(self, fits: tuple[Fit, ...], _confounded: Sequence[Fit], _cost: float) -> tuple[Fit, ...]:
        """With what scatters linear where they are."""
        return polished_near(fits, _POLISH_ROUNDS, self.limits)

    def others(self, path: Path, grow: Callable[[Path, int], Path]) -> list[Fit]:
        """What goes in the place of all that varies farther than on any day; what begins with wear, has another swing, has a rival of one of its effects in the place of that one, has a fault beside
        one of its effects, or one of its effects alone."""
        found = [*self._in_place_of_days(path, grow), *self._begun_otherwise(path, grow)]
        best = min((*path.steps[-1:], *found), key=lambda fit: fit.judged, default=None)
        if best is None or len(best.effects) < 2:
            return found
        starts = [*self._swapped(path), *self._beside_faults(best), *(best.of_effect(effect) for effect in best.effects)]
        starts += [without_effect(best.values, effect) for effect in best.effects if len(best.effects) > 2]
        return [*found, *fits_from(partial(_polished_from, self.start), starts)]

    def _in_place_of_days(self, path: Path, grow: Callable[[Path, int], Path]) -> list[Fit]:
        """Fits of the faults and effects that do what varies from run to run, where that goes farther than on any day: seen from there their own signatures are bent, or nothing is left of them."""
        if not self.start.at_edge:
            return []
        far = settled(self.evidence, {}, self.start.deviations, rounds=FAR_ROUNDS, reach=FAR).best_deviations(reach=np.inf)
        vary = (*self.evidence.spread, *self.evidence.varies)
        beyond = sorted((place for place in range(len(vary)) if abs(far[place]) > _OF_NO_DAY), key=lambda place: -abs(far[place]))
        causes = [one for place in beyond if (one := self._doing_as(vary[place], float(far[place])))][: self.limits.effects]
        sets = (some for count in range(1, len(causes) + 1) for some in itertools.combinations(causes, count))
        starts = [{name: value for one in some for name, value in one.items()} for some in sets]
        found = fits_from(partial(_polished_from, self.start), starts)
        best = min(found, key=lambda fit: fit.judged, default=None)
        return [*found, *(grow(begun_with(best, path), len(best.effects) + 1).steps if best is not None else ())]

    def _doing_as(self, one: Spread, deviations: float) -> dict[str, float]:
        """The value of a fault or an effect that does what a parameter does at so many standard deviations; empty where there is none."""
        actuator = self.evidence.actuator
        if one.title in FAULTS.values():
            return one.changes(actuator, deviations)
        for name, parameter in confounded_with(one.title).items():
            size, row = parameter.size_per_change * one.std * deviations, row_of(name)
            if row.lower <= size <= row.upper and effect_of(name) not in actuator.active_effects:
                return {name: size}
        return {}

    def _begun_otherwise(self, path: Path, grow: Callable[[Path, int], Path]) -> list[Fit]:
        """Fits where the way of the strongest effect ends far from the floor: the way that begins with both faults, since wear moves CSJ and BLK together, and beside an effect of their size the first
        of the three to be fitted alone takes a share of the other two, which no later one gives back; and then with another swing."""
        found: list[Fit] = []
        if not path.steps:
            return found
        if self._is_far(path.steps[-1]):
            first = worn(self.start)
            if first is not None:
                found += grow(begun_with(first, path), len(first.effects) + _BESIDE_WEAR_MAX).steps
        best = min((path.steps[-1], *found), key=lambda fit: fit.judged)
        if self._is_far(best):
            found += self._other_swings(best, path, grow)
        return found

    def _is_far(self, fit: Fit) -> bool:
        return fit.cost > _FLOORS**2 * self.floor

    def _swapped(self, path: Path) -> list[dict[str, float]]:
        """Starts in which a rival of the round in which an effect was taken stands in its place: beside what came later the order may be another."""
        if not path.steps:
            return []
        best, held = path.steps[-1], frozenset[str]()
        starts = []
        for step, tried in zip(path.steps, path.rounds, strict=False):
            taken = next((effect for effect in step.effects if effect not in held), "")
            rivals = [fit for fit in tried.fits if taken not in fit.effects and taken in best.effects]
            for fit in rivals[:_RIVALS]:
                other = {name: value for name, value in fit.values.items() if effect_of(name) not in {*held, *best.effects}}
                starts += [joined(without_effect(best.values, taken), other)] if other else []
            held = frozenset(step.effects)
        return starts

    def _other_swings(self, best: Fit, path: Path, grow: Callable[[Path, int], Path]) -> list[Fit]:
        """Fits in which a swing has another number of periods or another phase: beside a machine that rests often, the one that looks strongest need not be the one that explains most."""
        fits = []
        for effect in best.effects:
            if effect in FAULTS or record_of(effect).periodic is None:
                continue
            rest = without_effect(best.values, effect)
            seen = seen_from(refit(self.start, rest)) if rest else self.start
            held = [one for one in best.effects if one != effect]
            by_number: dict[float, Signature] = {}
            for one in signatures(Screen(seen), held, (effect,)):
                by_number.setdefault(one.start().get(f"effects.{effect}.periods", 1.0), one)
            fits += fits_from(partial(_polished_from, seen), [joined(rest, one.start()) for one in by_number.values()])
        found = min(fits, key=lambda fit: fit.cost, default=best)
        return list(grow(begun_with(found, path), len(found.effects) + _BESIDE_WEAR_MAX).steps) if found.cost < best.cost else []

    def _beside_faults(self, best: Fit) -> list[dict[str, float]]:
        """Starts of a fault beside one effect of several: what explains the record as well with less is the likelier."""
        if set(best.effects) & set(FAULTS):
            return []
        actuator = self.evidence.actuator
        faults = [{name: share * actuator[name]} for name in FAULTS.values() if actuator[name] > 0.0 for share in _BESIDE_STARTS]
        return [{**best.of_effect(effect), **fault} for fault in faults for effect in best.effects]

    def finished(self, fit: Fit) -> Fit:
        """Polished; and together with what scatters, where that hides one of its effects: in their narrow valley steps with the scatter linear hardly move."""
        last = polished(fit, _LAST_ROUNDS)
        here = seen_from(last)
        if min(shares_left(here, last), default=1.0) >= _HIDDEN:
            return last
        found = joint(replace(last, view=here, cost=here.cost), _JOINT_ROUNDS)
        # a unit of cost is no difference; scatter that runs away stands in for an effect that is missing
        if found.cost > last.cost + 1.0 or np.max(np.abs(found.view.deviations), initial=0.0) >= _RUNS_AWAY:
            return last
        return found


def _polished_from(view: View, start: Mapping[str, float]) -> Fit:
    return polished(refit(view, start), _POLISH_ROUNDS)
