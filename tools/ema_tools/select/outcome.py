"""What the search over sets of effects comes to."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

from ema_tools.fit.evidence import View
from ema_tools.fit.refit import Fit


@dataclass(frozen=True)
class Round:
    """One round: the best score of each effect, strongest first, the refits that followed, best first, and the own limits of effects that are confounded with a parameter."""

    scores: Mapping[str, float]
    fits: tuple[Fit, ...]
    limits: Mapping[str, float]


@dataclass(frozen=True)
class Path:
    """How a set of effects grew: rounds, accepted fits one after the other, and the view from the last."""

    rounds: tuple[Round, ...]
    steps: tuple[Fit, ...]
    view: View


@dataclass(frozen=True)
class Named:
    """One effect of the answer's list: its class (itself first), values and standard errors as far as it was fitted, by how much it lowers the cost,
    what it must take off to be named, whether it is accepted, and its probability where the posterior decided."""

    name: str
    alike: tuple[str, ...]
    values: Mapping[str, float]
    std: Mapping[str, float]
    score: float
    limit: float
    accepted: bool
    probability: float | None = None


@dataclass(frozen=True)
class Diagnosis:
    """What was found; `fit` None when nothing exceeds the limit. `unexplained`: share of the excess over the floor that is left.

    `steps`: the fits that were accepted one after the other, costs falling; `doubt`: cost that the form of what was found may leave; `unnamed`: probability of a cause that the library does not
    hold, where the posterior decided.
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
    doubt: float = 0.0
    unnamed: float | None = None

    def refuted(self, effects: Collection[str]) -> Diagnosis:
        """The same after `effects` of the answer were refuted, by a record held out or by a size that could be none: they are not accepted, and where nothing else is, what is there is unknown."""
        named = tuple(replace(one, accepted=one.accepted and one.name not in effects) for one in self.named)
        return replace(self, named=named, verdict=self.verdict if any(one.accepted for one in named) else "unknown")

    @property
    def alike(self) -> tuple[str, ...]:
        """What looks like the first effect."""
        return self.named[0].alike[1:] if self.named else ()
