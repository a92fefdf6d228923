"""A machine by its healthy records, by the balance of forces: its base values, the effects that it has anyhow, and how much each of them scatters from record to record.

The scatter of a value is what one healthy record asks of it alone, everything else as all of them show it: run to run, and whatever the model lacks of the healthy machine, which is no change.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ema_tools.balances.effects import adjusted
from ema_tools.balances.mechanical import MECHANICAL_PARAMETERS
from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.base.progress import Report, untold
from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import AnyRecord
from ema_tools.fit.nuisance import stated_std
from ema_tools.library.definitions import load_definitions
from ema_tools.library.registry import record_of
from ema_tools.select.balance_bench import LOAD, Bench, Fitted, load_effect, solved
from ema_tools.select.balance_setting import LEVEL
from ema_tools.select.fixes import NONE, Fixes
from ema_tools.select.force_balance import ForceSearch, improve_by_forces
from ema_tools.select.force_refit import ForceRefit, refit_by_forces
from ema_tools.select.force_steps import ForceSteps, Tried
from ema_tools.select.torque_patterns import Pattern, pattern_of
from ema_tools.select.two_groups import FRICTION_OF_DAYS, two_groups

SURE_RECORDS = 3  # fewer say little of how records differ: parts of each stand in, and the answer says so [judgement]
_CHANCE = 0.995  # of a healthy record to lie below the limit of one value, to one side [chance]
LEAST_SCATTER = 0.05  # of a base value, relative, where too few records tell it and none is stated: a day's grease moves friction by as much [judgement]
_LEAST_OF_DRIVE = 0.005  # scatter of a drive's reading, relative: as well as currents are measured [judgement]
_SEEN = (
    0.05  # a record that shows less of a value than this, as a share of the one that shows most, says nothing of its scatter [judgement]
)
_AS_HEALTHY = 0.1  # an effect that takes so much of its gain off the healthy records too is no change [judgement]
_AS_HEALTHY_LEFT = 1.1  # of what is left of the healthy records: more is left of today's before an effect is sought in it [judgement]
_LIKE_AT, _LIKE = (0.5, 0.95), 1.25  # quantiles of the speed that records of like motion share, to this factor [judgement]
_MARGIN = 1.3  # over the worst healthy record, that an error is beyond it [judgement]


@dataclass(frozen=True)
class HealthyByBalance:
    """What healthy records show. `actuator`: the machine with its `standing` effects; `steps`: how these were found; `refit`: the last fit; `scatter`: standard deviation of one record, by name.

    `groups`: what the scatter was taken over; `sure`: whether these are records; `error_Nm`: rms of what is left of the healthy records, and `worst_Nm` of the worst of them.
    """

    records: tuple[AnyRecord, ...]
    actuator: Actuator
    standing: tuple[str, ...]
    steps: ForceSteps
    refit: ForceRefit
    scatter: Mapping[str, float]
    groups: int
    error_Nm: float
    worst_Nm: float
    bench: Bench = field(repr=False)

    @property
    def sure(self) -> bool:
        """Whether there are records enough to tell how they differ."""
        return len(self.records) >= SURE_RECORDS

    @property
    def times(self) -> float:
        """So many standard deviations a value must differ to be a change."""
        return float(special.stdtrit(max(self.groups - 1, 1), _CHANCE))

    @property
    def scatter_of_drive(self) -> float:
        """By how much all of the drive differs from record to record, as a share of it: what one healthy record asks of the machine as all of them show it, standard deviation."""
        bench, rows = self.bench, self.bench.sliding
        left = _residual(bench, self.actuator)
        told = _alone((bench.start.drive - left)[rows, None], left[rows], _groups(bench, self.sure)[rows])
        return max(_rms([float(one[0]) for one in told]), _LEAST_OF_DRIVE if self.sure else LEAST_SCATTER)

    def limit(self, scatter: float, *std: float) -> float:
        """By how much a value must differ."""
        return self.times * math.hypot(scatter, *std)

    def beyond(self, error_Nm: float, doubt_Nm: float = 0.0) -> bool:
        """Whether what a model leaves of a record is more than of any healthy one, and than it may be off there."""
        return error_Nm > _MARGIN * math.hypot(self.worst_Nm, doubt_Nm)

    def scatter_of(self, pattern: Pattern, along: Reals | None = None) -> float:
        """Scatter of the size of an effect that the healthy machine does not have, in one shape; NaN where its records show nothing of it. `along`: coefficients of a table of unit size, [k], whose
        scatter is meant and not that of any table.
        """
        bench = self.bench
        found = pattern_of(bench.start.setting, pattern.effect, pattern.shape)
        if isinstance(found, str) or found.bends:
            return math.nan
        size, rows = load_definitions().effect(pattern.effect).size.name, bench.sliding
        columns, left, group = bench.decimated(found.columns)[rows], _residual(bench, self.actuator)[rows], _groups(bench, self.sure)[rows]
        if along is not None:
            return _rms([float(one[0]) for one in _alone((columns @ along)[:, None], left, group)])
        levels = {name: self.actuator[name] for name in MECHANICAL_PARAMETERS}
        return _rms([found.values(one, levels)[size] for one in _alone(columns, left, group)])

    def veto(self, search: ForceSearch, accepted: Fitted, tried: Tried) -> str:
        """Why an effect of today's records is no change; empty where it is one."""
        if accepted.square(search.bench.training) <= (_AS_HEALTHY_LEFT * self.error_Nm) ** 2:
            return "no change: without it the records leave no more than the healthy ones"
        if tried.effect == load_effect():
            scatter, std = self.scatter.get(LOAD, math.nan), self.refit.std.get(LOAD, 0.0)
        else:
            pattern = tried.fit.patterns[-1]
            if pattern.bends:
                return self._same_when_healthy(search, accepted, tried)
            width = pattern.columns.shape[1]
            found = tried.fit.values[load_definitions().effect(tried.effect).size.name]
            along = tried.fit.coefficients[-width:] / found if record_of(tried.effect).along is not None and found else None
            scatter, std = self.scatter_of(pattern, along), 0.0
        if not math.isfinite(scatter):
            return ""
        size = load_definitions().effect(tried.effect).size.name
        value = tried.fit.values[size]
        limit = self.limit(scatter, std, tried.fit.std.get(size, 0.0))
        if abs(value) > limit:
            return ""
        over = "healthy records" if self.sure else "parts of the healthy records"
        return f"no change: its size {value:.3g} is within what {over} differ by, {limit:.3g}"

    def _same_when_healthy(self, search: ForceSearch, accepted: Fitted, tried: Tried) -> str:
        """An effect that bends the balance: whether it does the healthy records as much good."""
        bench = self.bench
        before = bench.fit(bench.start, (), np.zeros((bench.fold.size, 0)))
        known = search.patterns[tried.effect]
        if isinstance(known, str):
            return ""
        # another size may be the best of the healthy records
        after = bench.searched(before, tried.effect, known)
        healthy = 1.0 - after.square(bench.training) / before.square(bench.training)
        rows = search.bench.training
        today = 1.0 - tried.fit.square(rows) / accepted.square(rows)
        return "no change: it lowers the error of the healthy records as well" if healthy > _AS_HEALTHY * today else ""


def _rms(values: Sequence[float]) -> float:
    return math.sqrt(sum(value * value for value in values) / max(len(values) - 1, 1)) if values else math.nan


def _groups(bench: Bench, by_record: bool) -> NDArray[np.int64]:
    """The group of every sample, over which scatter is taken: its record, or its part of the record, [samples]."""
    if by_record:
        return bench.of_record
    parts = bench.kept(np.concatenate([laps.fold for laps in bench.division.laps]))
    return np.asarray(1000 * bench.of_record + parts)


def _residual(bench: Bench, actuator: Actuator) -> Reals:
    """What a machine as it is known leaves of the bench's target, [samples]: base values with what its effects make of them."""
    start, values = bench.start, adjusted(actuator)
    coefficients = np.array([values[name] for name in MECHANICAL_PARAMETERS]) * (
        1.0,
        1.0,
        start.setting.actuator["screw.dynamic_ratio"],
        1.0,
    )
    taken = list(bench.taken)
    coefficients[taken] = 0.0
    return start.target - start.base @ coefficients


def _alone(columns: Reals, left: Reals, group: NDArray[np.int64]) -> list[Reals]:
    """What each group asks of a pattern [samples, k] alone, each [k]; groups that hardly show it are left out."""
    seen = {number: float(np.sum(columns[group == number] ** 2)) for number in np.unique(group)}
    most = max(seen.values(), default=0.0)
    return [
        np.linalg.lstsq(columns[group == number], left[group == number], rcond=None)[0]
        for number, square in seen.items()
        if square > _SEEN * most > 0.0
    ]


def _check_states(bench: Bench, known: Actuator, left: Reals) -> None:
    """Raises InputError where the friction of one or more of several records of like motion is far from that of the others: one that is not healthy would be taken for scatter.

    `left` [samples]: by the machine as it is known.
    """
    place, level = MECHANICAL_PARAMETERS.index(LEVEL), known[LEVEL] * (known["screw.dynamic_ratio"] or 1.0)
    if len(bench.records) < 2 or place in bench.taken or not level > 0.0:
        return
    column, rows = bench.start.base[:, place], bench.sliding
    speed = bench.kept(np.abs(bench.start.setting.states.speed_rad_s))
    of_record = [rows & (bench.of_record == number) for number in range(len(bench.records))]
    if not all(here.any() for here in of_record):
        return
    friction = np.array([float(solved(column[here, None], left[here])[0]) for here in of_record]) / level
    found = two_groups(np.abs(friction[:, None] - friction[None, :]), FRICTION_OF_DAYS)
    if found is None:
        return
    few, rest = ([one for place, one in enumerate(of_record) if (place in found[0]) is side] for side in (True, False))
    # friction at other speeds is another friction, of which a model lacks something
    if not all(_within([speed[one] for one in rest], speed[here]) for here in few):
        return
    names = [record.file for record in bench.records]
    odd = ", ".join(names[number] for number in found[0])
    others = ", ".join(name for number, name in enumerate(names) if number not in found[0])
    by = 100.0 * (float(np.mean(friction[list(found[0])])) - float(np.mean(np.delete(friction, list(found[0])))))
    raise InputError(
        f"{odd}: not of the same state as {others}: friction (CSJ) differs by {by:+.0f} %, which is no scatter of one machine: leave out of --healthy what is not healthy"
    )


def _within(others: Sequence[Reals], speed: Reals) -> bool:
    """Whether speeds are like those of some others, by their middle and their fastest."""
    for share in _LIKE_AT:
        ends = [float(np.quantile(one, share)) for one in others]
        if not min(ends) / _LIKE <= float(np.quantile(speed, share)) <= max(ends) * _LIKE:
            return False
    return True


def least_scatter(actuator: Actuator, name: str, value: float) -> float:
    """The least scatter of a value, in its unit: as the actuator states, else a share of `value`."""
    stated = stated_std(actuator, name)
    return LEAST_SCATTER * abs(value) if stated is None else stated


def healthy_machine(
    actuator: Actuator, records: Sequence[AnyRecord], fixes: Fixes = NONE, report: Report | None = None
) -> HealthyByBalance:
    """The machine as healthy records show it. Raises MissingSignal, InputError."""
    tell = report or untold
    steps = improve_by_forces(actuator, records, (), lambda share, text: tell(0.8 * share, text), fixes)
    # today's drive is the same one
    refit = refit_by_forces(steps.actuator.with_drive_lag(steps.actuator.drive_lag_s or 0.0), records, fixes)
    known = refit.actuator
    bench = Bench(known, records, (), fixes, whole=True)
    bench.keep_undetermined()
    sure = len(records) >= SURE_RECORDS
    group, left = _groups(bench, sure), _residual(bench, known)
    _check_states(bench, known, left)
    left, group, base = left[bench.sliding], group[bench.sliding], bench.start.base[bench.sliding]
    scatter: dict[str, float] = {}
    for place, name in enumerate(MECHANICAL_PARAMETERS):
        if place in bench.taken:
            continue
        factor = known["screw.dynamic_ratio"] if name == "screw.csj_Nm" else 1.0
        spread = _rms([float(one[0]) / (factor or 1.0) for one in _alone(base[:, place : place + 1], left, group)])
        if math.isfinite(spread):
            # what records show holds what the model lacks of them, too: what is stated from run to run is the least
            scatter[name] = max(spread, least_scatter(known, name, 0.0 if sure else known[name]))
    squares = [float(np.mean(left[group == number] ** 2)) for number in np.unique(group)]
    tell(1.0, "done")
    return HealthyByBalance(
        tuple(records),
        known,
        tuple(name for name in known.active_effects if name not in actuator.active_effects),
        steps,
        refit,
        scatter,
        len(squares),
        math.sqrt(float(np.mean(left**2))),
        math.sqrt(max(squares)),
        bench,
    )
