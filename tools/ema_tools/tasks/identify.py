"""CSJ and BLK by the onboard module's own session: what `ema identify` does."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from scipy import special

from ema_tools.base.errors import InputError
from ema_tools.base.interval import interval95
from ema_tools.base.parallel import each
from ema_tools.data.actuator import Actuator, row_of
from ema_tools.data.records import Record
from ema_tools.fit.detection import UNSEEN_STDS, ShiftTest
from ema_tools.fit.evidence import simulate_channels
from ema_tools.fit.interval import scatter_of
from ema_tools.fit.nuisance import share_from_run_to_run
from ema_tools.fit.temperature import Foretold
from ema_tools.library.definitions import load_definitions
from ema_tools.plant.native import CHANNELS, REASONS, Identification, IdentifiedValue, Progress, SearchSettings, Table
from ema_tools.select.baseline import same_command
from ema_tools.select.cross_check import CrossCheck, cross_check
from ema_tools.select.healthy_records import check_apart
from ema_tools.select.known_machine import Compared, blocked, compared, repeats_of
from ema_tools.select.warmth import MagnetsToday, winding_alone, without_magnets
from ema_tools.tasks.healthy_runs import DRY, Baseline, baseline_of, healthy_runs
from ema_tools.tasks.onboard_search import (
    COMMAND_SPEED,
    KEYS,
    MIN_SHIFTS,
    POSITION_ALONE,
    SCATTERS,
    UNSEEN,
    check_record,
    check_table,
    identified_of,
    run,
)

_SAME_SIZE = 0.1  # nearer to what the file has, relative, it is the same effect [judgement]
_BEYOND_SCATTER = 3.0  # standard deviations of its own scatter that a healthy machine does not exceed [chance]
_SURELY_LESS = (
    1.645  # standard deviations by which a healthy machine must lie below what a healthy answer may not hide: 95 %, to one side [chance]
)
_USUALLY = 2.0  # standard deviations of its own scatter that a healthy machine seldom exceeds [chance]
_HIDES_NONE = 3.0  # of a stated threshold: a wear that a healthy answer may not hide, however much a unit scatters: +15 % of CSJ as shipped [judgement]
NOT_ADEQUATE, _NEAR_THRESHOLD = REASONS[2], REASONS[16]


# Why an answer does not stand: something is missing from the model, known or not; an effect would do as well; other signals say other values; it hangs on what the machine is today;
# one of two healthy records may not be healthy.
Objection = Literal["missing", "unknown", "rival", "signals", "open", "healthy"]


@dataclass(frozen=True)
class Identified:
    """The answer of one record; `costs` are the objective of every model run in their order, `seeds` the answers of further seeds.

    `scatter`: how far the estimates move from run to run with what scatters on a healthy machine, standard deviations by name.
    `seen`: the record as it was searched, `settings`: how; `tried`: the values of every model run, in the order of `costs`, none where they are not known.
    `least_percent`: the shifts that are called a fault, by name; `doubt`: why two healthy records may not both be, in words; `checked`: what all signals say of the
    estimates; None where it was not wanted; `foretold`: what dry friction should be today beside that of the healthy records, where they can tell; the healthy value is that of today.
    `winding`: by what share its resistance is off that of the healthy records, where nothing else of the record is as warm.
    `since`: effects of the model that the healthy records do not have.
    """

    actuator: Actuator
    healthy: Actuator
    answer: Identification
    baseline: Baseline | None
    costs: tuple[float, ...]
    seeds: tuple[Identification, ...]
    seed: int
    precision: int
    wall_s: float
    weighted: bool
    seen: Record
    settings: SearchSettings
    tried: tuple[tuple[float, ...], ...] = ()
    least_percent: Mapping[str, float] = field(default_factory=dict)
    checked: CrossCheck | None = None
    doubt: str = ""
    scatter: Mapping[str, float] = field(default_factory=dict)
    foretold: Foretold | None = None
    magnets: MagnetsToday | None = None
    winding: float | None = None
    since: tuple[str, ...] = ()

    def interval95(self, one: IdentifiedValue) -> tuple[float | None, float | None]:
        """Where a value lies with 95 % certainty: sensor noise, what lasts in the residual, what the machine may be today, and what moves from run to run, as healthy records show it
        where there are two or more."""
        bias = math.hypot(one.bias if math.isfinite(one.bias) else 0.0, self._unseen(one.name))
        stands = self.checked.open.get(one.name) if self.checked is not None else None
        if stands is not None and math.isfinite(stands.beyond):
            bias = math.hypot(bias, stands.beyond, stands.moved)
        # how the same search reads healthy records apart has their noise in it
        day = (
            max(one.std, self.day_std(one.name)) if self._shown and math.isfinite(one.std) else math.hypot(one.std, self.day_std(one.name))
        )
        low, high = interval95(one.estimate, bias, day)
        if low is None or high is None:
            return low, high
        if self.checked is not None and one.name in self.checked.faults and self.stands_beside_effect:
            # beside the effect it is another value, as sure as this one
            away = self.checked.faults[one.name] - one.estimate
            return low + min(away, 0.0), high + max(away, 0.0)
        if stands is None:
            return low, high
        below, above = math.hypot(one.estimate - low, stands.reach.below), math.hypot(high - one.estimate, stands.reach.above)
        return one.estimate - below, one.estimate + above

    @property
    def stands_beside_effect(self) -> bool:
        """Whether the module's answer stands, though all signals say that an effect is missing from the model."""
        return self.checked is not None and self.checked.kind == "missing" and not self.objects

    def day_std(self, name: str) -> float:
        """By how much a machine's value is read apart from run to run, against the mean of its healthy records where there are two or more: as the actuator states, as those records show it,
        else the usual."""
        # what scatters does so by a share of itself
        shares = (self._scatters(name) and self._shown) or self._stated(name) > 0.0
        value = next((one.estimate for one in self.answer.identified if one.name == name), self.actuator[name])
        grown = max(1.0, value / self.healthy[name]) if shares else 1.0
        return grown * self.healthy_std(name)

    def healthy_std(self, name: str) -> float:
        """The same of a healthy machine."""
        if self.foretold is not None and name == DRY:
            return self.foretold.std * abs(self.healthy[name])
        if self.baseline is None or not self._shown:
            return self._stated(name) or self.scatter.get(name, 0.0)
        is_stated = not self._scatters(name) or name in self.healthy.scatter
        return self.baseline.scatter[name] * ShiftTest(runs=self.baseline.records).spread(is_stated)

    def _stated(self, name: str) -> float:
        """The same as the unit's own model states it; zero where it does not, or healthy records show it."""
        percent = next((one.scatter_percent for one in self.answer.identified if one.name == name), 0.0)
        return 0.0 if self._shown else 0.01 * percent * abs(self.healthy[name])

    def _unseen(self, name: str) -> float:
        """What the unit's own model states of what its ground test does not show, one standard deviation."""
        return 1e-4 * self.healthy[UNSEEN] * self.least_percent.get(name, 0.0) / UNSEEN_STDS * abs(self.healthy[name])

    def _scatters(self, name: str) -> bool:
        """Whether the value itself differs from run to run."""
        return share_from_run_to_run(self.healthy, name) > 0.0

    @property
    def _shown(self) -> bool:
        """Whether healthy records show the scatter."""
        return self.baseline is not None and bool(self.baseline.scatter)

    @property
    def objection(self) -> Objection | None:
        """Why the module's answer does not stand, by all signals; None where it does."""
        checked = self.checked
        if checked is None:
            return None
        if checked.kind in ("unknown", "rival"):
            return checked.kind
        if checked.kind == "missing":
            # a unit that is known by its data sheet alone has more than the effect that is named
            by_sheet = checked.against == 0 and self.answer.verdict == "fault"
            # what has changed may hide wear beside it, and a small one where the effect is large
            taken_back = checked.withheld or by_sheet or self.answer.verdict == "healthy" or not self.answer.adequate
            return "missing" if taken_back or any(map(self._moved, self.answer.identified)) else None
        if self.sound_by_scatter:
            return None
        if self.answer.verdict == "undecided":
            return "open" if self._is_near and (self.within_scatter() or self._open_by_climate()) else None
        if self.doubt:
            return "healthy"
        if any(map(self._moved, self.answer.identified)):
            return "signals"
        return None if self._stands(checked) else "open"

    @property
    def _is_near(self) -> bool:
        """Whether all that keeps the module from a verdict is that a shift lies near its threshold."""
        return self.answer.reasons == (_NEAR_THRESHOLD,)

    def _moved(self, estimate: IdentifiedValue) -> bool:
        """Whether all signals say another shift than the module does."""
        shift = self.checked.shift.get(estimate.name) if self.checked is not None else None
        if shift is None:
            return False
        healthy = abs(self.healthy[estimate.name])
        std = estimate.std / healthy
        return abs(shift - (estimate.today / healthy - 1.0)) > max(self._least(estimate.name), 3.0 * (std if np.isfinite(std) else 0.0))

    def _least(self, name: str) -> float:
        return 0.01 * self.least_percent[name]

    def _stands(self, checked: CrossCheck) -> bool:
        """Whether the verdict is the same for all that the machine may be today."""
        if self.answer.verdict == "fault":
            return self._surely_faulty(checked)
        doubt = self._doubts(checked)
        # a fall within the scatter is no wear
        return not self._open_by_climate() and all(
            shift + doubt[name] <= self._least(name) and doubt[name] - shift <= self._threshold(name)
            for name, shift in checked.shift.items()
        )

    def _threshold(self, name: str) -> float:
        """The shift beyond which a fault is one: what is called so, and what a healthy machine does not show by its scatter or by today's temperature, relative."""
        return max(self._least(name), self._most_by_scatter(name))

    def _most_by_scatter(self, name: str, stds: float = _BEYOND_SCATTER) -> float:
        """The shift that a healthy machine shows as seldom as a normal one lies more than so many standard deviations above its mean."""
        if self.foretold is not None and name == DRY:
            return self.foretold.within(float(special.ndtr(stds)))
        return stds * self.healthy_std(name) / abs(self.healthy[name])

    def within_climate(self) -> bool:
        """Whether today's temperature is most of what makes a fault no more than what a healthy machine may do."""
        return self._open_by_climate() or (self.within_scatter() and self.mostly_climate())

    def mostly_climate(self) -> bool:
        """Whether today's temperature is most of what is open of friction."""
        foretold = self.foretold
        return foretold is not None and foretold.by_temperature > math.sqrt(0.5) * foretold.std

    def _open_by_climate(self) -> bool:
        """Whether an answer that is or may be healthy is one of a faulty machine at today's temperature as well."""
        shifts = self.checked.shift if self.checked is not None else {}
        may_be_healthy = self.answer.verdict == "healthy" or self._is_near
        if self.foretold is None or not may_be_healthy or DRY not in shifts or not self.mostly_climate():
            return False
        return shifts[DRY] + _SURELY_LESS * self.foretold.std > self.not_hidden(DRY)

    def not_hidden(self, name: str) -> float:
        """The shift that a healthy answer may not hide, relative."""
        return max(self._least(name), 0.01 * _HIDES_NONE * self._stated_least(name))

    @property
    def sound_by_scatter(self) -> bool:
        """Whether a shift at or beyond its threshold is one that the unit's healthy runs show as well, and surely none that a healthy answer may not hide."""
        checked = self.checked
        if checked is None or checked.kind != "adequate" or checked.against == 0 or self.doubt or not self._shown:
            return False
        is_near = self.answer.verdict == "fault" or self._is_near
        if not is_near or any(map(self._moved, self.answer.identified)):
            return False
        doubt = self._doubts(checked)
        return all(
            -self._threshold(name) <= shift <= max(self._least(name) - doubt[name], self._most_by_scatter(name, _USUALLY))
            and shift + doubt[name] + self._most_by_scatter(name, _SURELY_LESS) <= self.not_hidden(name)
            for name, shift in checked.shift.items()
        )

    def _stated_least(self, name: str) -> float:
        """The shift that the actuator's file calls a fault, in %."""
        return self.healthy[MIN_SHIFTS[name]]

    def within_scatter(self) -> bool:
        """Whether what is read beyond a threshold is no more than what healthy records of the machine differ by."""
        shifts = self.checked.shift if self.checked is not None else {}
        is_beyond = self.answer.verdict == "fault" or any(shift > self._least(name) for name, shift in shifts.items())
        return is_beyond and self.answer.verdict != "healthy" and all(shift <= self._threshold(name) for name, shift in shifts.items())

    @property
    def sure_beside_remainder(self) -> bool:
        """Whether the module withholds its answer for a remainder alone, which beside healthy records is too little to be the cause of what is surely a fault: what a unit always has grows
        with its friction."""
        checked = self.checked
        if checked is None or checked.kind != "adequate" or checked.against == 0 or self.doubt or self.objects:
            return False
        withheld = self.answer.verdict == "undecided" and self.answer.reasons == (NOT_ADEQUATE,)
        return withheld and not any(map(self._moved, self.answer.identified)) and self._surely_faulty(checked)

    def _surely_faulty(self, checked: CrossCheck) -> bool:
        """Whether a shift is beyond its threshold for all that the machine may be today."""
        doubt = self._doubts(checked)
        return any(shift - doubt[name] > self._threshold(name) for name, shift in checked.shift.items())

    def _doubts(self, checked: CrossCheck) -> dict[str, float]:
        """How far each shift may be off for what the machine may be today, relative."""
        sure = self.healthy["verdict.confidence_std"]
        return {name: one.doubt(sure, self.healthy[name]) for name, one in checked.open.items()}

    @property
    def objects(self) -> bool:
        """Whether the module's answer does not stand."""
        return self.objection is not None

    def least_sure(self) -> str:
        """Of CSJ and BLK, the one that is least known for what the machine may be today, by name."""
        stands = self.checked.open if self.checked is not None else {}
        return max(stands, key=lambda name: stands[name].std / self._least(name) / abs(self.healthy[name]))

    @property
    def verdict(self) -> str:
        """The module's verdict, undecided where all signals object to it."""
        if self.sound_by_scatter:
            return "healthy"
        if self.objects:
            return "undecided"
        return "fault" if self.sure_beside_remainder else self.answer.verdict

    @property
    def adequate(self) -> bool:
        """Whether the model explains the record: the rod position by the module, every signal by the cross-check."""
        return (self.answer.adequate or self.sure_beside_remainder) and self.objection not in ("unknown", "missing")


def _check_healthy(actuator: Actuator, healthy: Sequence[Record]) -> None:
    """Raises InputError, naming the file, for a healthy record of which nothing can be concluded."""
    for other, why in zip(healthy, each(lambda one: blocked(actuator, one), healthy), strict=True):
        if why:
            raise InputError(f"{other.file}: cannot serve as a healthy record: {why}")


def _blamed(actuator: Actuator, record: Record, healthy: Sequence[Record], error: InputError) -> InputError:
    """What healthy records could not do each by itself is today's record's doing where it runs none of their commands."""
    why = blocked(actuator, record)
    if why:
        return InputError(f"{record.file}: {why}")
    first = healthy[0]
    if any(same_command(record, one) for one in healthy):
        return error
    rows = min(record.rows, first.rows)
    begun = np.allclose(record.command_mm[:rows], first.command_mm[:rows], atol=1e-6)
    what = f"its {record.rows} rows are the beginning of the command of {first.file}, which has {first.rows}: it was cut off"
    unlike = what if begun and record.rows < first.rows else f"not the command of {first.file}"
    return InputError(
        f"{record.file}: command_mm: {unlike}: record today's under the whole command of the healthy records; each of them by itself cannot serve ({error})"
    )


def _holds(actuator: Actuator, values: Mapping[str, float]) -> bool:
    """Whether the effect of these values, its size first, is in the actuator at this very size."""
    if not values:
        return False
    size, value = next(iter(values.items()))
    held = actuator[row_of(size).name]
    return abs(value - held) < _SAME_SIZE * abs(held)


def _of_today(shift: Mapping[str, float], foretold: Foretold | None) -> dict[str, float]:
    """Shifts from the healthy records as shifts from what should be today."""
    should_be = {DRY: 1.0 + foretold.shift} if foretold is not None else {}
    return {name: (1.0 + one) / should_be.get(name, 1.0) - 1.0 for name, one in shift.items()}


def _untold(_: str) -> None:
    """Nobody asked what is begun."""


def identify(
    actuator: Actuator,
    record: Record,
    healthy: Sequence[Record] = (),
    search: SearchSettings | None = None,
    seeds: int = 1,
    bits: int = 32,
    progress: Progress | None = None,
    guarding: bool = True,
    table: Table | None = None,
    stage: Callable[[str], None] | None = None,
) -> Identified:
    """Identify CSJ and BLK as `_identify` does, and once more with effects of the model that the healthy records lack counted for today's record alone, where that decides the verdict."""

    def answered(since: Sequence[str] = ()) -> Identified:
        return _identify(actuator, record, healthy, search, seeds, bits, progress, guarding, table, stage, since)

    baseline = actuator.baseline
    if baseline is not None and baseline.before is not None and healthy and baseline.covers(healthy):
        # the file says which effects the healthy records lack
        return answered(baseline.since)
    found = answered()
    checked = found.checked
    held = actuator.active_effects
    if checked is None or not checked.against or not held or not found.objects or checked.unusable:
        return found
    # only what the healthy records contradict by name: an effect that they have is part of the unit
    since = tuple(effect for effect in checked.effects if effect in held)
    other = answered(since) if since else found
    return other if other.verdict != "undecided" else found


def _since(beside: Compared, effects: Mapping[str, float]) -> Compared:
    """The record against a machine that got `effects`, by name, after the healthy repeats were made."""
    unit = beside.unit
    machine = unit.actuator.changed(effects)
    without = simulate_channels(unit.actuator, unit.record, unit.channels, unit.start_mm)
    added = simulate_channels(machine, unit.record, unit.channels, unit.start_mm) - without
    return replace(beside, unit=unit.of_machine(machine, added))


def _identify(
    actuator: Actuator,
    record: Record,
    healthy: Sequence[Record],
    search: SearchSettings | None,
    seeds: int,
    bits: int,
    progress: Progress | None,
    guarding: bool,
    table: Table | None,
    stage: Callable[[str], None] | None,
    since: Sequence[str],
) -> Identified:
    """Identify CSJ and BLK on `record`, against the actuator's healthy values or those of the `healthy` records.

    Unless `guarding` is off, the answer is held against all signals, and an effect that the model lacks is sought behind it. `seeds` further searches
    (seed, seed + 1, ...) run beside the first and show how much the answer depends on the seed. `stage` is told what is begun, in words.
    `since`: effects of the model that began after the healthy records were made: only today's record is compared with them.
    With a `table` of signatures the answer is the one that firmware gives with it, guarded by the table alone. Raises InputError.
    """
    begin = stage or _untold
    settings = search or SearchSettings()
    check_record(actuator, record, settings)
    check_apart(record, healthy)
    _check_healthy(actuator, healthy)
    if table is not None:
        check_table(table, record)
    seed = settings.seed if settings.seed is not None else int(actuator["search.seed"])
    settings = replace(settings, seed=seed)
    same = repeats_of(record, healthy) if table is None else ()
    new = [load_definitions().effect(effect) for effect in since]
    added = {f"effects.{value.name}": actuator[value.name] for effect in new for value in effect.parameters}
    own = actuator.before_baseline()
    before = own if own is not actuator or not new else actuator.changed({f"effects.{one.size.name}": one.size.nominal for one in new})
    repeats = compared(before, record, same) if same else None
    magnets: MagnetsToday | None = None
    winding: float | None = None
    baseline: Baseline | None = None
    doubt = ""
    foretold: Foretold | None = None
    if repeats is not None:
        begin("healthy runs")
        without, repeats = repeats, _since(repeats, added) if added else repeats
        base = repeats.known.base({})
        warm = without_magnets(repeats.known, base)
        if warm is not None:
            unit, magnets = warm
            repeats = replace(repeats, unit=unit)
            base = repeats.known.base({})
        winding = winding_alone(repeats.known, base) if magnets is None else None
        # the healthy runs are of the machine without what has begun since
        runs = healthy_runs(before, without if added else repeats, settings, bits)
        baseline, settings, doubt = runs.baseline, runs.search, runs.doubt
        # grease and winding as all signals say that they are today: the search itself sees two values
        today = repeats.known.today(base)
        foretold = runs.foretold(today)
        known = runs.known.changed({**today, **added})
        if foretold is not None:
            # what the runs scatter is known to the module, as a unit's own model tells it
            percent = 100.0 * foretold.std
            known = known.changed({DRY: known[DRY] * (1.0 + foretold.shift), SCATTERS[DRY]: percent})
    elif healthy:
        try:
            baseline = baseline_of(actuator, healthy, settings, bits)
        except InputError as error:
            raise _blamed(actuator, record, healthy, error) from error
        known = actuator.changed(baseline.values)
    else:
        known = actuator
    beside = repeats or (compared(known, record, ()) if guarding and table is None else None)
    seen_record = repeats.corrected(record) if repeats is not None else record
    check_record(known, record, settings)
    costs: list[float] = []
    points: list[tuple[float, ...]] = []

    def seen(evaluation: int, cost: float, best: float, tried: tuple[float, ...]) -> None:
        costs.append(cost)
        points.append(tried)
        if progress is not None:
            progress(evaluation, cost, best, tried)

    # healthy records run today's command, and other signals contradict where the position alone cannot tell
    drive_told = record.current_A is not None or record.voltage_V is not None
    if healthy or (beside is not None and drive_told):
        known = known.changed({COMMAND_SPEED: 0.0, UNSEEN: 0.0})
    begin("searching")
    begun = time.perf_counter()
    answer = run(known, seen_record, settings, bits, seen, table)
    wall_s = time.perf_counter() - begun
    others = each(
        lambda other: run(known, seen_record, replace(settings, seed=other), bits, None, table), [seed + place for place in range(1, seeds)]
    )
    found = known.changed(
        {
            estimate.name: min(max(estimate.today, row_of(estimate.name).lower), row_of(estimate.name).upper)
            for estimate in answer.identified
        }
    )
    estimates = {estimate.name: estimate.today for estimate in answer.identified if estimate.name in KEYS}
    searched = identified_of(known)
    given = dict(zip(searched, settings.min_shift_percent, strict=True)) if settings.min_shift_percent else {}
    least_percent = {name: known[MIN_SHIFTS[name]] for name in KEYS} | given
    checked = None
    if guarding and beside is not None and estimates:
        begin("holding it against all signals")
        least = {name: 0.01 * percent for name, percent in least_percent.items()}
        checked = cross_check(known, record, beside, estimates, least, not answer.adequate)
        checked = replace(checked, as_given=_holds(actuator, checked.values), shift=_of_today(checked.shift, foretold))
    weighted = search is not None and search.weight is not None
    scatter = scatter_of(found, record, searched, dict(zip(CHANNELS, settings.weight or POSITION_ALONE, strict=True)))
    return Identified(
        found,
        known,
        answer,
        baseline,
        tuple(costs),
        tuple(others),
        seed,
        bits,
        wall_s,
        weighted,
        seen_record,
        settings,
        tuple(points),
        least_percent,
        checked,
        doubt,
        scatter,
        foretold,
        magnets,
        winding,
        tuple(since),
    )
