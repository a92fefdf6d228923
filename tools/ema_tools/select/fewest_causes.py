"""One new effect in place of several changes of a healthy machine.

Base values that are free beside an effect take up most of what it does: a drag that grows with the square of the speed is more viscous friction and less dry friction, and what little is left is
named nothing. Healthy records say how far a day moves each value. With the values inside of that, the effect that began has to explain the rest, and often does so alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ema_tools.balances.mechanical import MECHANICAL_PARAMETERS
from ema_tools.base.progress import Report
from ema_tools.data.actuator import row_of
from ema_tools.data.motion_records import AnyRecord
from ema_tools.select.balance_bench import LOAD, size_of_load
from ema_tools.select.fixes import Fixes
from ema_tools.select.force_balance import improve_by_forces
from ema_tools.select.force_steps import ForceSteps
from ema_tools.select.healthy_balance import HealthyByBalance
from ema_tools.select.value_changes import Changes, changes_of

_BETTER = 0.9  # of the error of as many causes of another kind, clearly less ... [judgement]
_PLAINLY = 0.7  # ... where healthy records do not leave as much anyhow: there, what nobody takes for chance [judgement]


@dataclass(frozen=True)
class Causes:
    """An answer: effects that began, and how values of the healthy machine changed beside them."""

    forces: ForceSteps
    told: Changes

    @property
    def count(self) -> int:
        """Of effects and of values that changed."""
        return len(self.forces.steps) + sum(one.counts for one in self.told.values)


def fewer_causes(
    machine: HealthyByBalance, found: Causes, records: Sequence[AnyRecord], holdout: Sequence[AnyRecord], fixes: Fixes, report: Report
) -> Causes:
    """`found`, or what explains the records as well with fewer causes, or clearly better with as many: effects beside base values that stay as near to the healthy ones as days move them."""
    if not any(one.counts for one in found.told.values):
        return found
    near = _as_days_move(machine, found.told, fixes)
    forces = improve_by_forces(machine.actuator, records, holdout, report, near, machine.veto)
    if not forces.steps:
        return found
    other = Causes(forces, changes_of(machine, forces.actuator, records, fixes, {step.effect for step in forces.steps}))
    before, after = found.forces.errors.training, forces.errors.training
    fewer = other.count < found.count and after <= before
    clearly = _BETTER if machine.beyond(0.01 * before * found.forces.drive_Nm) else _PLAINLY
    clearer = other.count == found.count and after < clearly * before
    return other if fewer or clearer else found


def _as_days_move(machine: HealthyByBalance, told: Changes, fixes: Fixes) -> Fixes:
    """Base values between the ends of what is no change."""
    base = {size_of_load(): LOAD}
    between = {}
    for one in told.values:
        name = base.get(one.name, one.name)
        if name in MECHANICAL_PARAMETERS and name not in fixes.as_stated:
            row, value = row_of(name), machine.actuator[name]
            between[name] = (max(value - one.limit, row.lower), min(value + one.limit, row.upper))
    return replace(fixes, between={**between, **fixes.between})
