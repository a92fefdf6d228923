"""One new effect in place of several changes of a healthy machine.

Base values that are free beside an effect take up most of what it does: a drag that grows with the square of the speed is more viscous friction and less dry friction, and what little is left is
named nothing; or an effect is named beside which friction itself is gone. Healthy records say how far a day moves each value. With the values inside of that, the effect that began has to explain
the rest, and often does so alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ema_tools.balances.effects import adjusted
from ema_tools.balances.mechanical import MECHANICAL_PARAMETERS
from ema_tools.base.progress import Report
from ema_tools.data.actuator import row_of
from ema_tools.data.motion_records import AnyRecord
from ema_tools.library.definitions import load_definitions
from ema_tools.library.display_names import value_coded
from ema_tools.library.registry import called
from ema_tools.select.balance_bench import LOAD, Fitted, load_effect
from ema_tools.select.balance_setting import LEVEL
from ema_tools.select.fixes import Fixes
from ema_tools.select.force_balance import ForceSearch, improve_by_forces
from ema_tools.select.force_steps import ForceSteps, Tried
from ema_tools.select.healthy_balance import HealthyByBalance
from ema_tools.select.value_changes import Changes, changes_of

_DAYS = 3.0  # scatters that a day takes a value off the healthy one [chance]
_GONE = 0.5  # of the dry friction: what leaves no more of it stands in for it [judgement]
_AS_WELL = 1.03  # times the error of more values, which the simpler answer may have [judgement]
_BETTER = 0.9  # of the error of another effect with as many values, clearly less [judgement]
_CLEARLY = 0.7  # of the error of as many causes of another kind, which nobody takes for chance [judgement]
_AS_MUCH = 1.1  # times the error, that another answer may have which the records hardly tell from it [judgement]


@dataclass(frozen=True)
class Causes:
    """An answer: effects that began, and how values of the healthy machine changed beside them.

    `as_well`: effects, and what looks like them, that explain the records about as well beside values that have not changed.
    """

    forces: ForceSteps
    told: Changes
    as_well: tuple[str, ...] = ()

    @property
    def effects(self) -> tuple[str, ...]:
        """Those that began."""
        return tuple(step.effect for step in self.forces.steps)

    @property
    def changed(self) -> frozenset[str]:
        """Values that have changed, by name."""
        return frozenset(one.name for one in self.told.values if one.counts)

    @property
    def count(self) -> int:
        """Of causes."""
        return len(self.effects) + len(self.changed)

    @property
    def free(self) -> int:
        """Of the values that the causes have."""
        return len(self.changed) + sum(len(load_definitions().effect(effect).parameters) for effect in self.effects)


def fewer_causes(
    machine: HealthyByBalance, found: Causes, records: Sequence[AnyRecord], holdout: Sequence[AnyRecord], fixes: Fixes, report: Report
) -> Causes:
    """`found`, or what explains the records as well with less: effects beside base values that stay as near to the healthy ones as days move them."""
    if not found.count:
        return found

    def veto(search: ForceSearch, accepted: Fitted, tried: Tried) -> str:
        return _of_base(machine, tried) or machine.veto(search, accepted, tried)

    near = _as_days_move(machine, fixes)
    # a constant torque is asked first and leaves the others what it does not do: here it is left out
    near = near.without(LOAD) if load_effect() in found.effects and LOAD not in near.between else near
    forces = improve_by_forces(machine.actuator, records, holdout, report, near, veto)
    other = Causes(forces, changes_of(machine, forces.actuator, records, fixes, {step.effect for step in forces.steps}))
    if found.effects and any(one.counts and one.name == LEVEL and one.today < _GONE * one.healthy for one in found.told.values):
        return other
    if not other.effects:
        # an effect beside which values change that do not change without it takes their place, and is none
        return other if found.effects and found.changed and not found.changed & other.changed else found
    # what is told of a part by the others, since values that are free take up what they have no part in
    before, after = found.forces.errors.foretold, forces.errors.foretold
    simpler = other.free < found.free and after <= _AS_WELL * before
    # of two effects the better one, though less was free beside it
    better = not found.changed and other.free <= found.free and after < _BETTER * before
    if simpler or better or (other.count <= found.count and after < _CLEARLY * before):
        return other
    if other.count > found.count or after > _AS_MUCH * before or set(other.effects) & set(found.effects):
        return found
    told = {name for step in found.forces.steps for name in step.alike}
    names = [called(name) for step in forces.steps for name in (step.effect, *step.alike) if name not in told]
    return replace(found, as_well=tuple(dict.fromkeys(names)))


def _of_base(machine: HealthyByBalance, tried: Tried) -> str:
    """Why an effect is no cause of its own: it does what another base value does, and nothing else. A constant torque is one, since it may begin."""
    size = load_definitions().effect(tried.effect).size.name
    before, after = (adjusted(one) for one in (machine.actuator, machine.actuator.changed({size: tried.fit.values[size]})))
    moved = [name for name, value in after.items() if value != before[name] and name != size]
    other = moved and all(name in MECHANICAL_PARAMETERS and name != LOAD for name in moved)
    return f"it is {value_coded(moved[0])}, a value that has changed or has not" if other else ""


def _as_days_move(machine: HealthyByBalance, fixes: Fixes) -> Fixes:
    """Base values between the ends of what healthy records do of themselves. A constant torque stays free, since it is an effect as well, unless the machine carries one anyhow."""
    between = {}
    for name, scatter in machine.scatter.items():
        if name not in fixes.as_stated and (name != LOAD or load_effect() in machine.actuator.active_effects):
            row, value = row_of(name), machine.actuator[name]
            reach = _DAYS * scatter
            between[name] = (max(value - reach, row.lower), min(value + reach, row.upper))
    return replace(fixes, between={**between, **fixes.between})
