"""Without repeats: what the model lacks on a unit that is known by its data sheet alone."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace

from ema_tools.fit.confounded import confounded_fits, confounded_parameter
from ema_tools.fit.evidence import FAR, FAR_ROUNDS, Evidence, View, settled
from ema_tools.fit.nuisance import are_slight
from ema_tools.fit.refit import Fit, best_of_each, fits_from, jointly, refit
from ema_tools.infer.priors import log_odds
from ema_tools.select.candidates import Signature
from ema_tools.select.outcome import Path
from ema_tools.select.strategies.strategy import ALIKE, LEAST_LIMIT, SearchLimits, Strategy, refined_near

_JOINT_ROUNDS = 3  # rounds of the fit of a finalist together with the machine .. [effort]
_WORTH_FITTING = 0.3  # ... and the share of the limit that makes it worth them [effort]
_GAIN_SHARE = 0.5  # finalists that are behind the best by less than this share of its gain get them too [effort]


class DataSheetAlone(Strategy):
    """All that a data sheet leaves open is free within its usual spread, and an effect must exceed that.

    There are two places to look from: where the machine is still credible, and where it stands in for what is missing as well as it can. An effect that a parameter of the machine does
    as well at first shows from there alone, one that bends from here alone.
    """

    limits = SearchLimits(
        finalists=8,  # what the unit's parameters hide of an effect shows only when both are fitted together, so more effects are [effort]
        finalist_share=0.1,  # for the same reason [effort]
        least=LEAST_LIMIT,
    )

    def __init__(self, evidence: Evidence, only: Collection[str] | None = None) -> None:
        super().__init__(evidence, only)
        self._free = settled(evidence, {}, self.start.deviations, rounds=FAR_ROUNDS, reach=FAR)

    def floor_cost(self) -> float:
        """What sensor noise alone has."""
        return self.evidence.floor

    @property
    def before(self) -> float:
        """Where the unit's own parameters explain most."""
        return self._free.cost

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

    def least_of_confounded(self, fit: Fit, _least: float) -> float:
        """As much as makes up for its prior."""
        return -2.0 * log_odds((fit.effects[-1],), False)

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

    def others(self, path: Path, _grow: Callable[[Path, int], Path]) -> list[Fit]:
        """The last set, and each effect of it alone, fitted to their end together with the machine."""
        if not path.steps or _is_confounded(path.steps[-1]):
            return []
        last = jointly(path.steps[-1])
        alone = last.effects if len(last.effects) > 1 else ()
        return [last, *fits_from(lambda effect: jointly(refit(self.start, last.of_effect(effect))), alone)]


def _is_confounded(fit: Fit) -> bool:
    """Whether it was sized in closed form, and has nothing to gain."""
    return len(fit.effects) == 1 and all(map(confounded_parameter, fit.values))
