"""Without repeats: what the model lacks on a unit that is known by its data sheet alone."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy import special

from ema_tools.base.arrays import Reals
from ema_tools.fit.confounded import confounded_fits, confounded_parameter
from ema_tools.fit.evidence import FAR, FAR_ROUNDS, Evidence, View, settled
from ema_tools.fit.nuisance import WORN, are_slight
from ema_tools.fit.refit import Fit, best_of_each, jointly, refit
from ema_tools.library.registry import record_of
from ema_tools.select.candidates import Signature
from ema_tools.select.outcome import Path
from ema_tools.select.strategies.strategy import ALIKE, LEAST_LIMIT, SearchLimits, Strategy, refined_near

_JOINT_ROUNDS = 3  # rounds of the fit of a finalist together with the machine .. [effort]
_WORTH_FITTING = 0.3  # ... and the share of the limit that makes it worth them [effort]
_GAIN_SHARE = 0.5  # finalists that are behind the best by less than this share of its gain get them too [effort]
_BY_CHANCE = 3e-4  # of a value, to either side, that is taken for an effect: of a record's nine such values one in 200 records [chance]
_USUAL_WEIGHT = 4.0  # the usual distance of units counts as much as this many values that had shown it [judgement]
_EXCESS_SHARE = 0.05  # most that the misfit raises the limit by, as a share of the excess [judgement]


class DataSheetAlone(Strategy):
    """All that a data sheet leaves open is free within its usual spread, and an effect must exceed that.

    There are two places to look from: where the machine is still credible, and where it stands in for what is missing as well as it can. An effect that a parameter of the machine does
    as well at first shows from there alone, one that bends from here alone.
    """

    limits = SearchLimits(
        finalists=8,  # what the unit's parameters hide of an effect shows only when both are fitted together, so more effects are [effort]
        finalist_share=0.1,  # for the same reason [effort]
        least=2.0 * LEAST_LIMIT,  # no repeats set it: hardly one of 300 healthy machines of the benchmark's kind exceeds it [measured]
        model_error=0.05,  # what no parameter of a unit holds, such as a slight ripple of its friction, leaves so much [measured]
    )

    def __init__(self, evidence: Evidence, only: Collection[str] | None = None) -> None:
        super().__init__(evidence, only)
        self._free = settled(evidence, {}, self.start.deviations, rounds=FAR_ROUNDS, reach=FAR)

    def floor_costs(self) -> Reals:
        """What sensor noise alone has."""
        return np.array([self.evidence.floor])

    @property
    def before(self) -> float:
        """Where the unit's own parameters explain most."""
        return self._free.cost

    @property
    def beyond(self) -> float:
        """Most of what the model leaves is the unit's own, which is fitted."""
        return max(self.start.cost - self.floor, 0.0)

    def places(self) -> tuple[View, ...]:
        """The credible machine and the one that explains most."""
        return (self.start, self._free)

    def kept(self, found: Sequence[Signature]) -> list[Signature]:
        """Without what every machine has."""
        return [one for one in found if not self._is_slight(one.candidate.effect, {one.candidate.size: one.size})]

    def is_slight(self, fit: Fit, effect: str) -> bool:
        """By any of its values."""
        return self._is_slight(effect, fit.of_effect(effect))

    def _is_slight(self, effect: str, values: Mapping[str, float]) -> bool:
        """What a first look found larger than to be granted competes by any size: another one would be named in its place."""
        return not self.evidence.released(effect) and are_slight(self.evidence.actuator, values)

    def confounded(self, held: Fit | None) -> list[Fit]:
        """Seen from where the machine itself explains most, beside what is held; they count from there."""
        if held is None:
            return confounded_fits(self._free)
        free = settled(self.evidence, held.values, held.deviations(), rounds=FAR_ROUNDS, reach=FAR)
        return [replace(fit, cost=held.cost + fit.cost - free.cost) for fit in confounded_fits(free, held)]

    def least_of_confounded(self, fit: Fit, least: float, cost: float) -> float:
        """How far such a value goes by chance on a unit as wide as this one is in everything else, by Student's factor. That it is there is a matter of what the data sheet leaves open alone,
        which no roughness of the model and no choice of shapes can feign; beside another effect it may mend the form of that one, and must take off what any further one must."""
        square, freedom = self._width(fit)
        chance = float(special.stdtrit(freedom, _BY_CHANCE) ** 2) * square * max(1.0, cost / max(self.evidence.floor, 1.0))
        return max(chance, least) if len(fit.effects) > 1 else chance

    def _width(self, fit: Fit) -> tuple[float, float]:
        """How far from its data sheet this unit is in everything else, over what units usually are, squared, and the degrees of freedom to which that is known; the usual counts besides.
        Where all else is far off, one more is no effect. What wears tells nothing, nor does the parameter that the effect acts by, nor the farthest of the others, which may stand in for that
        one; and what the record does not determine stays where it is usual, and counts as little."""
        confounded = record_of(fit.effects[-1]).confounded
        own = confounded.parameter if confounded is not None else ""
        told = [
            (float(fit.view.deviations[place]) ** 2, max(1.0 - fit.view.doubt(place) ** 2, 0.0))
            for place, one in enumerate(self.evidence.spread)
            if one.title not in (own, *WORN)
        ]
        others = sorted(told)[:-1]
        freedom = _USUAL_WEIGHT + sum(shown for _, shown in others)
        return (_USUAL_WEIGHT + sum(square for square, _ in others)) / freedom, freedom

    def limit_at(self, _found: Sequence[Signature], _place: int, cost: float) -> float:
        """In units of the misfit that is left."""
        return min(self.limit * max(1.0, cost / self.floor), _EXCESS_SHARE * self.excess + self.limit)

    def refined(self, fits: tuple[Fit, ...], confounded: Sequence[Fit], cost: float) -> tuple[Fit, ...]:
        """Together with the machine, where they take off enough to be worth it."""
        gain = cost - fits[0].judged if fits else 0.0
        if gain > _WORTH_FITTING * LEAST_LIMIT:
            fits = refined_near(fits, lambda fit: jointly(fit, _JOINT_ROUNDS), max(self.limits.finalist_reach, _GAIN_SHARE * gain))
        if confounded:
            names = {fit.effects for fit in confounded}
            fits = best_of_each([*confounded, *(fit for fit in fits if fit.effects not in names)])
        return fits

    def in_order(self, fits: tuple[Fit, ...]) -> tuple[Fit, ...]:
        """Of those that cannot be told from the best the one with fewest values in front: a further value always leaves a little less."""
        alike = [fit for fit in fits if fit.judged < fits[0].judged + ALIKE]
        first = min(alike, key=lambda fit: len(fit.values), default=None)
        return fits if first is None else (first, *(fit for fit in fits if fit is not first))

    def ended(self, path: Path, _grow: Callable[[Path, int], Path]) -> Path:
        """The last set, or one effect of it alone, is fitted to its end together with the machine; an effect that was sized in closed form has nothing to gain."""
        if not path.steps or (len(path.steps) == 1 and all(map(confounded_parameter, path.steps[0].values))):
            return path
        path = replace(path, steps=(*path.steps[:-1], jointly(path.steps[-1])))
        return self.fewer(path, lambda start: jointly(refit(self.start, start)))
