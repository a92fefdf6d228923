"""Priors of causes and of their values, in one table. `posterior` weighs fitted sets of causes by them.

| quantity | prior |
|---|---|
| a cause is present | `PRESENT`; CSJ and BLK `WORN`; effects that nearly every machine has `USUAL` without baseline records |
| size of a cause | normal about none, standard deviation `SIZES` times the library's typical size; half of it where the size has one sign |
| phase | uniform over a turn; number of periods: uniform over those that are tried |
| positive shape value | lognormal about its nominal value, standard deviation 1 of the logarithm |
| place on the stroke | normal, standard deviation the reach of the command |
| other shape value | normal about its nominal value, standard deviation 0.5 |
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass

from ema_tools.data.actuator import Actuator, row_of
from ema_tools.library.definitions import is_size
from ema_tools.library.faults import FAULT_RECORDS, FAULTS, effect_of
from ema_tools.library.registry import record_of

PRESENT = 0.01  # probability of one of some thirty causes [judgement]
WORN = 0.05  # of each of the two that are watched [judgement]
USUAL = 0.3  # of an effect that nearly every machine has, on a unit that is known by its data sheet alone [judgement]
SIZES = 3.0  # standard deviation of a size, in typical sizes [judgement]
_SHAPES = 0.5  # standard deviation of a shape value that may have either sign [judgement]
_OF_PEAK = 0.7  # share of the largest current within which a limit is sought [judgement]


@dataclass(frozen=True)
class ValuePrior:
    """Prior of one fitted value at its estimate: logarithm of the density, and precision, both per unit of the coordinate; `slope`: the value's change per unit of the coordinate."""

    log_density: float
    precision: float
    slope: float = 1.0


def log_odds(causes: Collection[str], relative: bool) -> float:
    """Logarithm of the prior odds that these causes are present, `relative` to baseline records or on a unit that is known by its data sheet alone."""
    shares = [WORN if cause in FAULTS else USUAL if record_of(cause).usual and not relative else PRESENT for cause in causes]
    return sum(math.log(share / (1.0 - share)) for share in shares)


def value_prior(actuator: Actuator, name: str, value: float, reach_mm: float, peak_A: float) -> ValuePrior:
    """Prior of the value `name` of a cause at `value`, under a command that reaches `reach_mm` and draws `peak_A` at most."""
    effect, row = effect_of(name), row_of(name)
    if effect in FAULTS:
        nominal = actuator[row.name]
        return normal(value - nominal, SIZES * FAULT_RECORDS[effect].typical_share * nominal)
    record = record_of(effect)
    if is_size(name):
        if record.below_peak is not None:
            return _uniform(_OF_PEAK * peak_A)
        typical = abs(record.typical.values[name.rpartition(".")[2]]) if record.typical is not None else abs(value)
        return normal(value - actuator[row.name], SIZES * typical, one_sided=row.lower == row.nominal)
    if name.endswith("phase_rad"):
        return _uniform(2.0 * math.pi)
    if row.nominal > 0.0 and row.lower >= 0.0:
        positive = max(value, 1e-12)
        return ValuePrior(normal(math.log(positive / row.nominal), 1.0).log_density, 1.0, positive)
    if name.endswith("_mm"):
        return normal(value, reach_mm)
    return normal(value - row.nominal, _SHAPES)


def normal(distance: float, std: float, one_sided: bool = False) -> ValuePrior:
    """A value at a distance from the middle of a normal distribution, `one_sided`: of the half of one."""
    log_density = -0.5 * (distance / std) ** 2 - math.log(std) - 0.5 * math.log(2.0 * math.pi)
    return ValuePrior(log_density + (math.log(2.0) if one_sided else 0.0), std**-2)


def _uniform(width: float) -> ValuePrior:
    return ValuePrior(-math.log(width), 12.0 / width**2)


def log_choices(values: Collection[str]) -> float:
    """Logarithm of the number of choices among which the discrete values of a fit were picked: numbers of periods per turn."""
    counts = [
        len(periodic.periods)
        for name in values
        if name.endswith(".periods") and (periodic := record_of(effect_of(name)).periodic) is not None
    ]
    return sum(math.log(max(count, 1)) for count in counts)
