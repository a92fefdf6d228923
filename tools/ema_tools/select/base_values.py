"""Base values as the balance of forces fits them, beside what the actuator's file states of them: which of the two contradict each other."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from ema_tools.balances.mechanical import MECHANICAL_PARAMETERS
from ema_tools.base.interval import interval_of
from ema_tools.data.actuator import STARTS, Actuator
from ema_tools.select.balance_bench import INERTIA, Bench, Fitted
from ema_tools.select.balance_setting import LEVEL

# A stated value that is farther off than these shares of itself is contradicted: data sheets know an inertia well, dry friction differs by grease and temperature [judgement]
_STATED_WITHIN: Mapping[str, float] = {INERTIA: 0.25, LEVEL: 1.0}
_MATTERS = 1.15  # the error must be so many times as large with the stated value, else the records do not speak against it [judgement]


@dataclass(frozen=True)
class BaseValue:
    """One base value in its unit. `stated`: by the file, where `by_import` a start that an import put there and nobody states; `kept`: why it was not fitted, its `std` then is NaN.

    `error_percent`: force error of the parts fitted, and what it would be with this value as stated and all else fitted anew.
    """

    name: str
    stated: float
    by_import: bool
    value: float
    std: float
    kept: str
    at_end: bool
    error_percent: float
    error_as_stated_percent: float

    @property
    def interval95(self) -> tuple[float | None, float | None]:
        """The 95 % interval of the fitted value; no ends where it was not fitted."""
        return interval_of(self.value, self.std)

    @property
    def times(self) -> float:
        """What was fitted over what is stated; NaN where nothing is, or nothing was fitted."""
        return math.nan if self.kept or self.by_import or not self.stated > 0.0 else self.value / self.stated

    @property
    def contradicts(self) -> bool:
        """Whether the records speak against what is stated: it lies farther off than the doubt of both, and the error would be clearly larger with it."""
        return self._far and self._matters

    @property
    def hardly_seen(self) -> bool:
        """Whether what was fitted is far from what is stated, and the error would hardly be larger with that: such a value takes up whatever the model lacks."""
        return self._far and not self._matters

    @property
    def _matters(self) -> bool:
        return self.error_as_stated_percent > _MATTERS * self.error_percent

    @property
    def _far(self) -> bool:
        within, (low, high) = _STATED_WITHIN.get(self.name), self.interval95
        if within is None or low is None or high is None or not math.isfinite(self.times):
            return False
        return low > (1.0 + within) * self.stated or high < self.stated / (1.0 + within)


def base_values(given: Actuator, bench: Bench, fit: Fitted) -> tuple[BaseValue, ...]:
    """The base values of a fit with its standard errors, `given` being the actuator that it began from."""
    kept, ends = bench.kept_because, bench.at_ends(fit)
    return tuple(
        BaseValue(
            name,
            given[name],
            given.remark(name) in STARTS,
            fit.values[name],
            math.nan if name in kept else fit.std.get(name, math.nan),
            kept.get(name, ""),
            name in ends,
            fit.errors.training,
            fit.errors.training if name in kept else bench.error_with(fit, name, given[name]),
        )
        for name in MECHANICAL_PARAMETERS
    )
