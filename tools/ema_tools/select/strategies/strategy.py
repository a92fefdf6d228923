"""What a strategy decides for the search: where to look from, which fits to make better and how, what an effect must take off, and what is no answer."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.parallel import each
from ema_tools.fit.evidence import Evidence, View, settled
from ema_tools.fit.refit import Fit, best_of_each, polished, seen_from
from ema_tools.select.candidates import Signature
from ema_tools.select.outcome import Path

# Textbook chi-square limits are several times too low: the plant is not smooth, the noise is estimated, and the best of many shapes is
# taken [chance]
LEAST_LIMIT = 30.0
ALIKE = 9.0  # fits whose costs differ by less than this cannot be told apart: three standard deviations [chance]
_LEAST_SHARE = 0.02  # an effect must also take off this share of the excess that was found .. [judgement]
_MOST_OF_REST = 0.5  # ... or this share of what is left, where more is left than noise can leave .. [judgement]
_NOISE = 6.0  # ... which is so many standard deviations of the cost [chance]
_NEARLY_ALL = 0.9  # of what is left: a further effect that takes off so much needs nothing else, however large the change was [judgement]
_POLISH_REACH = 0.3  # fits this share of the best cost behind the best may still overtake it [effort]


@dataclass(frozen=True)
class SearchLimits:
    """Numbers that differ from strategy to strategy; costs in variances of the noise."""

    finalists: int  # effects whose refit is worth its time, at most
    finalist_share: float  # of the best score that a finalist has at least
    least: float  # cost that an effect must take off
    model_error: float  # share of what changed, in amplitude, to which a further effect trusts the model
    effects: int = 3  # a set grows no further [effort]
    finalist_reach: float = 30.0  # cost that a finalist may be behind the best: what chance can do [chance]


class Strategy(ABC):
    """One way to seek what is missing in `evidence`. `start`: where nothing is added and what scatters is at its best; `floor`: the cost of a record with nothing new; `only`: the effects and
    faults that are tried, all where it is None."""

    limits: SearchLimits
    # Whether the posterior over the fitted sets decides, and not what each of them leaves.
    by_probability = False

    def __init__(self, evidence: Evidence, only: Collection[str] | None = None) -> None:
        self.evidence = evidence
        self.only = only
        self.start = settled(evidence, {})
        self.limit = self.limits.least
        costs = self.floor_costs()
        self.floor = float(costs.mean())
        # what the cost of a record may lie over the floor by chance
        self.noise = _NOISE * (float(np.std(costs)) + np.sqrt(2.0 * self.start.residual.size)) + evidence.counting

    @abstractmethod
    def floor_costs(self) -> Reals:
        """Costs of records with nothing new, [k]."""

    @property
    def before(self) -> float:
        """The cost before any effect is added."""
        return self.start.cost

    @property
    def beyond(self) -> float:
        """The cost over the floor that is the record's own, what scatters where it was."""
        return max(self.before - self.floor, 0.0)

    @property
    def excess(self) -> float:
        """The cost over the floor that effects may explain."""
        return max(self.before - self.floor, 1e-9)

    def places(self) -> tuple[View, ...]:
        """Where the first look is taken from; scores are counted from the last of them."""
        return (self.start,)

    def kept(self, found: Sequence[Signature]) -> list[Signature]:
        """Those of the signatures that may be named."""
        return list(found)

    def is_slight(self, _fit: Fit, _effect: str) -> bool:
        """Whether an effect of a fit is no larger than what every machine has."""
        return False

    def confounded(self, _held: Fit | None) -> list[Fit]:
        """Fits of effects that do exactly what a parameter does, sized apart, beside what is `held`."""
        return []

    def least_of_confounded(self, _fit: Fit, least: float) -> float:
        """What an effect of `confounded` must take off, where others must take off `least`."""
        return least

    def least_by_chance(self, _effect: str) -> float:
        """What an effect must take off at least where it does the same as something that scatters by a width which is itself known from few runs."""
        return 0.0

    def needed(self, found: Sequence[Signature], place: int, cost: float) -> float:
        """What an effect must take off in the round `place`, at the present cost."""
        rest = cost - self.floor if cost - self.floor > self.noise else np.inf
        share = min(_LEAST_SHARE * self.excess, _MOST_OF_REST * rest)
        # a missing interplay has not the form of one effect, which then takes off nearly all that is left
        further = min(self.limits.model_error**2 * self.beyond, _NEARLY_ALL * rest) if place else 0.0
        return max(self.limit_at(found, place, cost), share, further)

    def least_kept(self, must: float, _left: float) -> float:
        """What an earlier effect must take off to be kept beside a further one that had to take off `must`, where both leave so much."""
        return must

    def least_beside(self, _cost: float, _left: float) -> float:
        """What a further effect must take off at least from the present cost where it leaves so much."""
        return 0.0

    @abstractmethod
    def limit_at(self, found: Sequence[Signature], place: int, cost: float) -> float:
        """The limit in the round `place`, in the misfit that is left there."""

    @abstractmethod
    def refined(self, fits: tuple[Fit, ...], confounded: Sequence[Fit], cost: float) -> tuple[Fit, ...]:
        """The fits of a round made better, those that are near enough to the best to be worth it."""

    def in_order(self, fits: tuple[Fit, ...]) -> tuple[Fit, ...]:
        """The fits of a round, the likeliest first; they come in the order of what they leave."""
        return fits

    def ended(self, path: Path, _grow: Callable[[Path, int], Path]) -> Path:
        """The path after its end, or another one that `_grow` makes from a begun path with so many further effects."""
        return path

    def fewer(self, path: Path, fitted: Callable[[Mapping[str, float]], Fit]) -> Path:
        """The path to one effect of its last set, where that one `fitted` alone explains more than the whole set: what came before it stood in for it."""
        best = path.steps[-1] if path.steps else None
        if best is None or len(best.effects) < 2:
            return path
        found = min(each(lambda effect: fitted(best.of_effect(effect)), best.effects), key=lambda fit: fit.cost)
        return begun_with(found, path) if found.cost < best.cost else path

    def is_no_answer(self, _cost: float) -> bool:
        """Whether so much is left that no set of effects is an answer."""
        return False

    def is_strained(self, _best: Fit) -> bool:
        """Whether beside a fit what scatters goes farther than it does."""
        return False

    def vague(self, _best: Fit) -> list[str]:
        """Effects of an answer whose size could be none."""
        return []


def begun_with(fit: Fit, path: Path) -> Path:
    """A path that ends with its first fit, held against those of another one's first round."""
    first = replace(path.rounds[0], fits=(fit, *path.rounds[0].fits))
    return Path((first,), (fit,), seen_from(fit))


def polished_near(fits: tuple[Fit, ...], rounds: int, limits: SearchLimits) -> tuple[Fit, ...]:
    """The better fits of a round with what scatters linear where they are."""
    reach = max(limits.finalist_reach, _POLISH_REACH * fits[0].judged) if fits else 0.0
    return refined_near(fits, lambda fit: polished(fit, rounds), reach)


def refined_near(fits: tuple[Fit, ...], better: Callable[[Fit], Fit], reach: float) -> tuple[Fit, ...]:
    """Those of the fits made better that are at most `reach` behind the best."""
    if not fits:
        return fits
    near = [fit for fit in fits if fit.judged < fits[0].judged + reach]
    rest = [fit for fit in fits if fit.judged >= fits[0].judged + reach]
    return best_of_each([*each(better, near), *rest])
