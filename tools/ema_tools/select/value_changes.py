"""Which values of a healthy machine have changed, by today's records.

Base values trade off against each other where one motion shows them alike, so that a fit of all of them spreads one change over several. Changes are therefore taken one after another: the value
that alone explains most of what the healthy machine leaves, then the next beside it, as long as the error falls clearly. All of the drive at once is one such value: a motor whose torque constant
has changed. How far a change may be off is told by leaving out each of the healthy records, and each of today's, in turn: friction differs from one to the next.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ema_tools.balances.effects import adjusted
from ema_tools.balances.mechanical import MECHANICAL_PARAMETERS
from ema_tools.base.arrays import Reals
from ema_tools.base.jackknife import LEAST_RECORDS, jackknife_std
from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import AnyRecord
from ema_tools.library.definitions import load_definitions
from ema_tools.library.registry import record_of
from ema_tools.select.balance_bench import LOAD, Bench, load_effect, size_of_load, solved
from ema_tools.select.balance_setting import LEVEL
from ema_tools.select.fixes import Fixes
from ema_tools.select.force_judge import WORSE_OF_GAIN, WORSE_THIRD, is_load
from ema_tools.select.force_refit import ForceRefit, refit_by_forces
from ema_tools.select.healthy_balance import LEAST_SCATTER, HealthyByBalance, least_scatter

CONSTANT = "motor.torque_constant_Nm_per_A"
_CLEAR_CHANGE = 1.1  # times the error is, or more, where a value stays as it was healthy, that has clearly changed [judgement]
_LEAST_CHANGE = 0.03  # of a value, that few records may differ by on other days, and nobody acts upon [judgement]
_OF_A_LOAD = 0.01  # scatter of what a machine carries, relative: a weight and a spring are the same on every day [judgement]
_AS_THE_DRIVE = 0.3  # of a load's change: so near to that of the drive as a whole, it may be that [judgement]
_MORE = 0.5  # of a load: by how much it is changed to see what it does, in which all is linear [precision]
_STAYS = 0.125  # of what the healthy machine leaves beyond its own, in squares, that values which changed may not explain [judgement]
_CLEARER = 0.95  # of the error of any single value must the drive as a whole leave, to be what has changed [judgement]


@dataclass(frozen=True)
class Change:
    """A value of the healthy machine as today's records have it. `limit`: beyond which it has changed; `counts`: whether it has, and the records say so."""

    name: str
    healthy: float
    today: float
    std: float
    limit: float
    counts: bool


@dataclass(frozen=True)
class _Column:
    """What a value of today adds to the torque of the healthy machine, per unit of it, [samples]; `scatter`: by how much it differs from record to record."""

    name: str
    torque: Reals
    healthy: float
    scatter: float


@dataclass(frozen=True)
class Changes:
    """`values`: of the healthy machine, those that have changed and the others; `left_Nm`: rms of what it leaves of today's records as it is, but for what days make of its values, and `doubt_Nm`:
    by how much that may be off, one standard deviation, for what the healthy records tell of today's motion; `nearest`: the base value that would explain most of it, where none has surely
    changed."""

    values: tuple[Change, ...]
    left_Nm: float = 0.0
    doubt_Nm: float = 0.0
    nearest: str = ""


class _Today:
    """Today's records on the healthy machine: what it leaves of them, and what its uncertainty makes of that."""

    def __init__(
        self,
        machine: HealthyByBalance,
        today: Actuator,
        records: Sequence[AnyRecord],
        fixes: Fixes,
        names: Sequence[str],
        load_Nm: float,
        effects: Mapping[str, float],
    ) -> None:
        self.machine = machine
        healthy = machine.actuator
        # a constant torque that is not sought is as it is today, since a force along the stroke begins somewhere
        # friction whose mean is that of a table of places is as it is today, too
        values = {name: healthy[name] for name in machine.refit.values if name != LEVEL or LEVEL in names}
        constant = {CONSTANT: healthy[CONSTANT]} if healthy.has(CONSTANT) else {}
        held = today.changed({**values, **constant, LOAD: healthy[LOAD] if LOAD in names else load_Nm, **effects})
        self.bench = Bench(held, records, (), fixes, whole=True)
        start, rows = self.bench.start, self.bench.fitted
        self.record = self.bench.of_record[rows]
        self.factor = np.array([1.0, 1.0, healthy["screw.dynamic_ratio"] or 1.0, 1.0])
        self.base = start.base[rows] * self.factor
        # with what the effects make of base values, those of today too
        acting = adjusted(held)
        known = np.array([acting[name] for name in MECHANICAL_PARAMETERS])
        known[list(self.bench.taken)] = 0.0
        self.left = start.target[rows] - self.base @ known
        self.columns = [
            _Column(name, self.base[:, MECHANICAL_PARAMETERS.index(name)], healthy[name], machine.scatter[name]) for name in names
        ]
        if _constant_shows(healthy, records):
            # what is read of a torque is one over the constant
            self.columns.append(_Column(CONSTANT, start.drive[rows] - self.left, 1.0, machine.scatter_of_drive))
        self.moved = self._moved()

    def _moved(self) -> list[Reals]:
        """What the base values change in the torque of today, when one healthy record after another is left out, each [samples]; none of fewer than three."""
        bench, here = self.machine.bench, self.bench
        base, target, rows = bench.start.base * self.factor, bench.start.target, bench.fitted
        numbers = np.unique(bench.of_record[rows])
        if numbers.size < LEAST_RECORDS:
            return []
        told = [solved(base[kept], target[kept], base) for kept in (rows & (bench.of_record != number) for number in numbers)]
        mean = np.mean(told, axis=0)
        asked = [place for place in range(len(MECHANICAL_PARAMETERS)) if place not in here.taken and place not in bench.taken]
        return [self.base[:, asked] @ (one - mean)[asked] for one in told]

    def changes(self, chosen: Sequence[_Column], rows: NDArray[np.bool_] | None = None) -> Reals:
        """By how much each of these has changed, fitted together, [k]."""
        here = np.ones(self.left.size, dtype=bool) if rows is None else rows
        return solved(np.column_stack([one.torque for one in chosen])[here], self.left[here])

    def _rest(self, chosen: Sequence[_Column], fitted: NDArray[np.bool_], told: NDArray[np.bool_]) -> float:
        """Rms of what is left of some samples with these changed as others tell it."""
        rest = self.left[told]
        if chosen:
            rest = rest - np.column_stack([one.torque for one in chosen])[told] @ self.changes(chosen, fitted)
        return math.sqrt(float(np.mean(rest**2)))

    def error(self, chosen: Sequence[_Column]) -> float:
        """Rms of what is left with these changed."""
        every = np.ones(self.left.size, dtype=bool)
        return self._rest(chosen, every, every)

    def held_out(self, chosen: Sequence[_Column]) -> list[float]:
        """The same of each record when the others tell the changes; of a single record as it is."""
        parts = [self.record == number for number in np.unique(self.record)]
        return [self._rest(chosen, ~here if len(parts) > 1 else here, here) for here in parts]

    @property
    def drive_change(self) -> float:
        """By what share all of the drive would have changed, were it that alone; NaN where no constant stands between."""
        whole = [one for one in self.columns if one.name == CONSTANT]
        return float(self.changes(whole)[0]) if whole else math.nan

    @property
    def doubt_Nm(self) -> float:
        """Rms of how far the torque of the healthy machine may be off on today's motion, one standard deviation."""
        return math.sqrt(float(np.mean(jackknife_std(self.moved) ** 2))) if self.moved else 0.0

    def std(self, chosen: Sequence[_Column], place: int) -> float:
        """How far one of the changes may be off by what the healthy records, and today's, differ among themselves."""
        columns = np.column_stack([one.torque for one in chosen])
        by_healthy = [float(solved(columns, one)[place]) for one in self.moved]
        numbers = np.unique(self.record)
        by_today = (
            [float(self.changes(chosen, self.record != number)[place]) for number in numbers] if numbers.size >= LEAST_RECORDS else []
        )
        return math.hypot(*(float(jackknife_std(told)) for told in (by_healthy, by_today) if told))


def _limit(today: _Today, chosen: Sequence[_Column], place: int) -> float:
    """Beyond which a change is none of chance."""
    return today.machine.limit(chosen[place].scatter, today.std(chosen, place))


def _matters(today: _Today, chosen: Sequence[_Column], column: _Column) -> bool:
    """Whether one of the changes is more than days make of it."""
    return abs(float(today.changes(chosen)[list(chosen).index(column)])) > _LEAST_CHANGE * abs(column.healthy)


def _clearly(today: _Today, before: Sequence[_Column], after: Sequence[_Column]) -> bool:
    """Whether the last of the changes lowers the error clearly, or that of the records held out, and lies beyond its limit."""
    lowers = today.error(before) > _CLEAR_CHANGE * today.error(after) or _held_out_too(today.held_out(after), today.held_out(before))
    return lowers and abs(float(today.changes(after)[-1])) > _limit(today, after, len(after) - 1)


def _chosen(today: _Today) -> list[_Column]:
    """The changes, one after another, as long as each lowers the error clearly."""
    chosen: list[_Column] = []
    while True:
        rest = [one for one in today.columns if one not in chosen and (one.name != CONSTANT or not chosen)]
        if not rest:
            return chosen
        single = [one for one in rest if one.name != CONSTANT]
        best = min(single, key=lambda one: today.error([*chosen, one])) if single else rest[0]
        whole = [one for one in rest if one.name == CONSTANT and today.error([one]) < _CLEARER * today.error([best])]
        best = whole[0] if whole else best
        if not _clearly(today, chosen, [*chosen, best]):
            return chosen
        chosen.append(best)


def _explained(today: _Today, chosen: Sequence[_Column]) -> bool:
    """Whether with these changed hardly more is left than the healthy machine leaves: values that explain the lesser part stand in for something else."""
    floor = today.machine.error_Nm**2
    if not today.machine.beyond(today.error(chosen), today.doubt_Nm):
        return True
    return today.error(chosen) ** 2 - floor <= _STAYS * (today.error([]) ** 2 - floor)


def _held_out_too(now: Sequence[float], before: Sequence[float]) -> bool:
    """Whether the parts held out have less error with a change, and none clearly more; one that rests throughout says nothing."""
    pairs = [(one, other) for one, other in zip(now, before, strict=True) if math.isfinite(one) and math.isfinite(other)]
    gain = sum(other**2 - one**2 for one, other in pairs)
    return gain > 0.0 and not any(one > WORSE_THIRD * other and one**2 - other**2 > WORSE_OF_GAIN * gain for one, other in pairs)


def changes_of(
    machine: HealthyByBalance,
    today: Actuator,
    records: Sequence[AnyRecord],
    fixes: Fixes,
    missing: Collection[str],
    loads: Mapping[str, float] | None = None,
) -> Changes:
    """Every value of the healthy machine that is fitted on both sides, but for those that effects which are `missing` today stand for. `today`: the model with these; `loads`: sizes of
    `changed_alone`. Raises MissingSignal, InputError."""
    today, free, names = _as_today(machine, today, records, fixes, missing)
    # a load that the machine has anyhow is as it is today
    load = {**(loads or {}), **{name: free.values[name] for name in names if name == size_of_load()}}
    here = _beside(machine, today, free, records, fixes, names, load)
    own = [name for name in names if name not in MECHANICAL_PARAMETERS]
    others = _of_effects(machine, today, free, records, fixes, own, math.nan if here is None else here.drive_change)
    if here is None:
        return Changes(tuple(others))
    chosen = _chosen(here)
    chosen = chosen if _explained(here, chosen) else []
    nearest = min(here.columns, key=lambda one: here.error([one])).name if not chosen else ""
    slight = [one for one in chosen if not _matters(here, chosen, one)]
    return Changes((*_of_base(here, chosen, nearest), *others), here.error(slight), here.doubt_Nm, nearest)


def changed_alone(machine: HealthyByBalance, records: Sequence[AnyRecord], fixes: Fixes) -> dict[str, float]:
    """The one value that alone makes of the healthy machine, its standing effects and all, what today's records show, as they have it: the size of a load that it has anyhow, else the motor's torque
    constant; empty where neither does.

    To be asked before effects are sought: these and the base values would each take their share of it. The load comes first, since the drive with three base values beside it does as much as one.
    Raises MissingSignal, InputError.
    """
    sizes = _own_loads(machine.actuator)
    if not sizes and not _constant_shows(machine.actuator, records):
        return {}
    today, free, names = _as_today(machine, machine.actuator, records, fixes, ())

    def with_sizes(sized: Mapping[str, float]) -> _Today | None:
        return _beside(machine, today, free, records, fixes, names, sized)

    here = with_sizes({})
    if here is None:
        return {}
    loads = []
    for name in sizes:
        value = machine.actuator[name]
        more = with_sizes({name: (1.0 + _MORE) * value})
        if more is not None:
            loads.append(_Column(name, (here.left - more.left) / (_MORE * value), value, _scatter(machine.actuator, name, value)))
    best = min(loads, key=lambda one: here.error([one]), default=None)
    if best is not None and _does_all(here, best, here.columns):
        return {best.name: best.healthy + float(here.changes([best])[0])}
    single = [one for one in here.columns if one.name != CONSTANT]
    if any(_does_all(here, one, single) for one in here.columns if one.name == CONSTANT):
        return {CONSTANT: machine.actuator[CONSTANT] / (1.0 + here.drive_change)}
    return {}


def _does_all(here: _Today, column: _Column, rivals: Sequence[_Column]) -> bool:
    """Whether one change is clear, leaves no more than the healthy machine may, and clearly less than each of its rivals alone."""
    left = here.error([column])
    if here.machine.beyond(left, here.doubt_Nm) or not _clearly(here, [], [column]) or not _matters(here, [column], column):
        return False
    return all(here.error([one]) * _CLEARER > left for one in rivals)


def _own_loads(actuator: Actuator) -> list[str]:
    """Sizes of what a machine carries anyhow: a constant torque, a spring, a weight that swings."""
    effects = [
        name for name in actuator.active_effects if name == load_effect() or is_load(name, actuator.values.get(f"{name}.periods", 1.0))
    ]
    return [load_definitions().effect(name).size.name for name in effects]


def _scatter(actuator: Actuator, name: str, value: float) -> float:
    """By how much a value of a standing effect differs from day to day, at least."""
    loads = _own_loads(actuator)
    # where a force along the stroke begins, a day decides that counts from another place
    if name in loads and (name != size_of_load() or len(loads) == 1):
        return least_scatter(actuator, name, value) * _OF_A_LOAD / LEAST_SCATTER
    # the size of a standing effect differs as much as all of its machine does
    return least_scatter(actuator, name, value)


def _constant_shows(healthy: Actuator, records: Sequence[AnyRecord]) -> bool:
    """Whether a torque constant stands between what these records hold and the torque."""
    return healthy.has(CONSTANT) and all(record.current_A is not None for record in records)


def _as_today(
    machine: HealthyByBalance, today: Actuator, records: Sequence[AnyRecord], fixes: Fixes, missing: Collection[str]
) -> tuple[Actuator, ForceRefit, list[str]]:
    """Today's model with the constant torque where the healthy machine has it, its free fit, and the values that are fitted on both sides."""
    # what a table of places says has a mean, which is friction
    apart = {record_of(name).base_value for name in missing} | {LEVEL for name in missing if record_of(name).along is not None}
    if load_effect() in machine.actuator.active_effects:
        today = today.changed({LOAD: machine.actuator[LOAD]})
    free = refit_by_forces(today, records, fixes)
    return today, free, [name for name in machine.refit.values if name not in apart and _fitted_on_both(machine.refit, free, name)]


def _beside(
    machine: HealthyByBalance,
    today: Actuator,
    free: ForceRefit,
    records: Sequence[AnyRecord],
    fixes: Fixes,
    names: Sequence[str],
    load: Mapping[str, float],
) -> _Today | None:
    """Today's records on the healthy machine, with `load` for what it is loaded with anyhow; None where no base value is fitted on both sides."""
    base = [name for name in names if name in machine.scatter]
    if not base:
        return None
    return _Today(machine, today, records, fixes, base, free.values.get(LOAD, machine.actuator[LOAD]), load)


def _fitted_on_both(healthy: ForceRefit, today: ForceRefit, name: str) -> bool:
    stds = [side.std.get(name, math.nan) for side in (healthy, today)]
    return name not in healthy.kept and name not in today.kept and name in today.values and all(map(math.isfinite, stds))


def _of_base(today: _Today, chosen: Sequence[_Column], nearest: str) -> list[Change]:
    """Base values: those that have changed, as they are together, and every other as it would be beside them; all of the drive only where it has, or is what comes nearest."""
    found = []
    for column in today.columns:
        counts = column in chosen and _matters(today, chosen, column)
        if column.name == CONSTANT and not counts and nearest != CONSTANT:
            continue
        beside = chosen if column in chosen else [*chosen, column]
        place = beside.index(column)
        change = float(today.changes(beside)[place])
        limit = max(_limit(today, beside, place), _LEAST_CHANGE * abs(column.healthy))
        std = math.hypot(column.scatter, today.std(beside, place))
        if column.name == CONSTANT:
            constant = today.machine.actuator[CONSTANT]
            found.append(Change(CONSTANT, constant, constant / (1.0 + change), std * constant, limit * constant, counts))
        else:
            found.append(Change(column.name, column.healthy, column.healthy + change, std, limit, counts))
    return found


def _of_effects(
    machine: HealthyByBalance,
    today: Actuator,
    free: ForceRefit,
    records: Sequence[AnyRecord],
    fixes: Fixes,
    names: Sequence[str],
    drive_change: float,
) -> list[Change]:
    """Values of the effects that the machine has anyhow. `drive_change`: share by which the drive as a whole may have changed, which a load is no surer than where it changed by the same."""
    found = []
    for name in names:
        healthy, value = machine.refit.values[name], free.values[name]
        share = value / healthy - 1.0 if healthy else math.nan
        as_the_drive = abs(share - drive_change) < _AS_THE_DRIVE * abs(share)
        spread = (least_scatter if as_the_drive else _scatter)(machine.actuator, name, healthy)
        stds = machine.refit.std[name], free.std[name]
        limit = machine.limit(spread, *stds)
        if name.endswith("phase_rad"):
            if not limit < math.pi:
                continue
            # the turn nearest to the healthy one
            value = healthy + math.remainder(value - healthy, 2.0 * math.pi)
        counts = abs(value - healthy) > limit
        if counts:
            effect = name.partition(".")[0]
            kept = fixes.with_effects(frozenset({effect}))
            # the base value that does the same would take it up
            kept = kept.without(LOAD) if effect == load_effect() else kept
            held = refit_by_forces(today.changed({name: healthy}), records, kept)
            # few records held out in turn say little of values that need them all: what the change is worth in all of them says it as well
            counts = _CLEAR_CHANGE * free.errors.training < held.errors.training or _held_out_too(free.errors.each, held.errors.each)
        found.append(Change(name, healthy, value, math.hypot(*stds, spread), limit, counts))
    return found
