"""What a strategy decides for the search: where to look from, which fits to make better and how, what an effect must take off to be kept on the way, and what else is fitted."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

from ema_tools.base.errors import InputError
from ema_tools.base.parallel import each
from ema_tools.fit.evidence import Evidence, View, settled
from ema_tools.fit.refit import Fit, best_of_each, polished, seen_from
from ema_tools.select.candidates import Signature
from ema_tools.select.outcome import Path

# Textbook chi-square limits are several times too low: the plant is not smooth, the noise is estimated, and the best of many shapes is
# taken [chance]
LEAST_LIMIT = 30.0
ALIKE = 9.0  # fits whose costs differ by less than this cannot be told apart: three standard deviations [chance]
_WORTH_ADDING = 0.2  # share of what is left above the floor that an effect must take off to be kept on the way [effort]
_POLISH_REACH = 0.3  # fits this share of the best cost behind the best may still overtake it [effort]


@dataclass(frozen=True)
class SearchLimits:
    """Numbers that differ from strategy to strategy; costs in variances of the noise."""

    finalists: int  # effects whose refit is worth its time, at most
    finalist_share: float  # of the best score that a finalist has at least
    least: float  # cost that an effect must take off to be kept on the way
    effects: int = 3  # a set grows no further [effort]
    finalist_reach: float = 30.0  # cost that a finalist may be behind the best: what chance can do [chance]


class Strategy(ABC):
    """One way to seek what is missing in `evidence`. `start`: where nothing is added and what scatters is at its best; `floor`: the cost of a record with nothing new; `only`: the effects and
    faults that are tried, all where it is None."""

    limits: SearchLimits

    def __init__(self, evidence: Evidence, only: Collection[str] | None = None) -> None:
        self.evidence = evidence
        self.only = only
        self.start = settled(evidence, {})
        self.limit = self.limits.least
        self.floor = self.floor_cost()

    @abstractmethod
    def floor_cost(self) -> float:
        """Cost of a record with nothing new."""

    @property
    def before(self) -> float:
        """The cost before any effect is added."""
        return self.start.cost

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

    def needed(self, cost: float) -> float:
        """What an effect must take off from the present cost to be kept on the way: less than makes it probable, as two may do so together."""
        return max(self.limit, _WORTH_ADDING * (cost - self.floor))

    @abstractmethod
    def refined(self, fits: tuple[Fit, ...], confounded: Sequence[Fit], cost: float) -> tuple[Fit, ...]:
        """The fits of a round made better, those that are near enough to the best to be worth it."""

    def in_order(self, fits: tuple[Fit, ...]) -> tuple[Fit, ...]:
        """The fits of a round, the likeliest first; they come in the order of what they leave."""
        return fits

    def others(self, _path: Path, _grow: Callable[[Path, int], Path]) -> list[Fit]:
        """Further fits beside those of a path, some of which `_grow` makes from a begun path with so many further effects: what a search that adds one effect after the other passes by."""
        return []

    def finished(self, fit: Fit) -> Fit:
        """The fit that is the answer, made better."""
        return fit


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

    def improved(fit: Fit) -> Fit:
        # nearer to where the model refuses it stays as it is
        with suppress(InputError):
            return better(fit)
        return fit

    return best_of_each([*each(improved, near), *rest])
