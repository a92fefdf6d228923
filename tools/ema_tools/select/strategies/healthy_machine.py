"""In the mean of a healthy machine's repeats: the standing effects that are worth having in its model."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ema_tools.data.actuator import row_of
from ema_tools.fit.evidence import Evidence
from ema_tools.fit.refit import Fit
from ema_tools.library.registry import record_of
from ema_tools.library.torques import WIDEST_SPOT
from ema_tools.select.strategies.strategy import SearchLimits, Strategy, polished_near

_STANDING_SHARE = 0.05  # of what the healthy mean leaves: an effect that takes off less is not worth having [judgement]
_POLISH_ROUNDS = 3  # of fits with what scatters linear at the last one [effort]


class HealthyMachine(Strategy):
    """Standing effects are worth having only when they are large against what repeats leave, and against each other."""

    limits = SearchLimits(
        finalists=5,  # as against repeats [effort]
        finalist_share=0.4,  # as against repeats [effort]
        least=100.0,  # a standing effect makes every later run dearer: three times what chance can do [judgement]
    )

    def __init__(self, evidence: Evidence) -> None:
        super().__init__(evidence)
        self._needed = max(self.limits.least, _STANDING_SHARE * max(self.start.cost - evidence.numbers, 0.0))

    def floor_cost(self) -> float:
        """As much as the record has numbers: white noise."""
        return float(self.evidence.numbers)

    def needed(self, _cost: float) -> float:
        """The same in every round."""
        return self._needed

    def is_slight(self, fit: Fit, effect: str) -> bool:
        """What would stand for the machine's own values, which the unit's runs are there to tell: an effect that does exactly what one of them does, and a spot as wide as the stroke, which
        is friction itself."""
        own = record_of(effect).confounded
        if own is not None and any(own.parameter in one.names for one in self.evidence.spread):
            return True
        local = record_of(effect).local
        if local is None or not local.spot:
            return False
        name = f"effects.{effect}.{local.spot}"
        # the width of an effect that the model held before is not fitted
        width = fit.values[name] if name in fit.values else self.evidence.actuator[row_of(name).name]
        return width > WIDEST_SPOT * float(np.ptp(self.evidence.record.command_mm))

    def refined(self, fits: tuple[Fit, ...], _confounded: Sequence[Fit], _cost: float) -> tuple[Fit, ...]:
        """With what scatters linear where they are."""
        return polished_near(fits, _POLISH_ROUNDS, self.limits)
