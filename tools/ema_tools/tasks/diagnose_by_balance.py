"""What `ema diagnose` answers by the mechanical balance, effect by effect, on one record or on several, parts of them held out.

It needs the drive and the motion and no simulation, so that it serves a machine whose controller is not known; and a loop so stiff that the position hardly shows the mechanics, while
the drive does. What repeats in the records is missing model.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from ema_tools.balances.mechanical import MECHANICAL_PARAMETERS, mechanical, mechanical_model
from ema_tools.base.errors import InputError, MissingSignal
from ema_tools.base.progress import Report, untold
from ema_tools.compare.friction_map import MeasuredBump, measured_bump
from ema_tools.compare.localisation import Where, where
from ema_tools.compare.motion_pictures import motion_pictures
from ema_tools.compare.motion_validity import judge_motion, one_way, turned
from ema_tools.compare.odd_rows import UNSEEN
from ema_tools.compare.validity import RecordRemark, RecordValidity, judge
from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import AnyRecord, MotionRecord
from ema_tools.fit.laps import laps_of
from ema_tools.library.faults import FAULTS
from ema_tools.library.registry import record_of
from ema_tools.results.diagnosis import FloorFrom, Verdict
from ema_tools.results.localisation import Pictures
from ema_tools.select.balance_bench import LOAD, Bench, Fitted, FoldErrors, compared_percent, given_errors, load_effect
from ema_tools.select.base_values import BaseValue
from ema_tools.select.fewest_causes import Causes, fewer_causes
from ema_tools.select.fixes import NONE, Fixes
from ema_tools.select.force_balance import ForceSearch, improve_by_forces
from ema_tools.select.force_refit import refit_by_forces
from ema_tools.select.force_steps import ForceStep, ForceSteps, Tried
from ema_tools.select.foreign_records import FOREIGN, another_machine, foreign_records
from ema_tools.select.forward_errors import Forward, forward_of
from ema_tools.select.healthy_balance import HealthyByBalance, healthy_machine
from ema_tools.select.healthy_records import check_apart, check_once
from ema_tools.select.play_changes import lag_remarks, play_changes, play_value, plays_seen
from ema_tools.select.standstill_changes import looks_like, standstill_changes
from ema_tools.select.value_changes import CONSTANT, Change, changed_alone, changes_of
from ema_tools.select.winding_changes import winding_changes

LAPS_MIN = 3  # fewer laps than these leave too little to hold out [judgement]
# What the first model leaves beyond the floor must be more than this, relative, for anything to be missing: an estimate is within a factor of two on machines
# that lack nothing, noise alone within five [judgement]
_MARGINS: dict[FloorFrom, float] = {"laps": 1.2, "healthy records": 1.3, "estimate": 2.5, "noise": 8.0}
# ... or less where so much of what is left is foretold of one record by the others: it is no chance then [judgement]
_FORETOLD, _MARGIN_FORETOLD = 0.3, 1.5
# ... or where so much of the drive is left that nobody would call it explained [judgement]
_MUCH, _MARGIN_MUCH = 10.0, 2.0
_TELLS = 5.0  # % of the drive, of which more is not called chance on an estimate's word [judgement]
_GROWN = 1.0  # by which at most what is left of a machine grows with what has changed of it, as a share [judgement]
_BETTER = 0.9  # of another answer's error, clearly less [judgement]
# % of the drive that the model leaves, or by which today's records are worse than any healthy one, in squares, else nobody asks for what is missing [judgement]
MATTERS = 1.0


@dataclass(frozen=True)
class BalanceAnswer:
    """Everything that was found, `known` being the actuator as given; errors are relative force errors in %. `gates`: of every record fitted; `where`: of the first where it can be simulated.

    `compared`: what `ema compare` reads of all rows of the records, before and after.
    `pictures`: of records without a controller. With `healthy` records `known` is the machine that these show, `changes` are of its values, and `left_Nm` is what it leaves of today's
    records as it is, with the standard deviation of that; `nearest` is the base value that would explain most of it.
    `as_well`: effects that explain the records about as well as what is told. `base`: base values as fitted, those of the healthy machine where there is
    one, beside what the actuator as given states.
    """

    records: tuple[AnyRecord, ...]
    holdout: tuple[AnyRecord, ...]
    known: Actuator
    gates: tuple[RecordValidity, ...]
    where: Where | None
    forces: ForceSteps
    compared: tuple[float, float]
    forward: Forward
    pictures: Pictures | None = None
    healthy: HealthyByBalance | None = None
    changes: tuple[Change, ...] = ()
    left_Nm: float = 0.0
    doubt_Nm: float = 0.0
    base: tuple[BaseValue, ...] = ()
    nearest: str = ""
    as_well: tuple[str, ...] = ()

    @functools.cached_property
    def bump(self) -> MeasuredBump | None:
        """Friction at low speed above its least, as runs at constant speed show it without any model."""
        return measured_bump(self.known, self.records)

    @property
    def record(self) -> AnyRecord:
        """The first of the records."""
        return self.records[0]

    @property
    def names(self) -> str:
        """The records, for a sentence."""
        others = len(self.records) - 1
        return f"{self.record.file} and {others} more record{'s' if others > 1 else ''}" if others else self.record.file

    @property
    def accepted(self) -> tuple[ForceStep, ...]:
        """The steps whose effects are in the last model."""
        gone = {one.effect for one in self.forces.refused}
        return tuple(
            step
            for step in self.forces.steps
            if step.effect in self.forces.actuator.active_effects or (record_of(step.effect).base_value and step.effect not in gone)
        )

    @property
    def recommended(self) -> bool:
        """Whether `actuator` is better than the one that was given."""
        return bool(self.accepted)

    @property
    def fits(self) -> bool:
        """Whether anything of what was fitted is kept."""
        return bool(self.accepted)

    @property
    def fitted(self) -> Actuator:
        """The machine with everything that was fitted and kept."""
        return self.actuator

    @property
    def actuator(self) -> Actuator:
        """The model with every accepted effect and the base values refitted beside them."""
        return self.forces.actuator

    @property
    def machine(self) -> Actuator:
        """What `--fitted` writes: beside healthy records with their CSJ and BLK, else with those of the records."""
        return self.actuator if self.healthy is None else self.actuator.keeping(self.known, FAULTS.values())

    @property
    def changed(self) -> tuple[Change, ...]:
        """Values of the healthy machine that have changed."""
        return tuple(one for one in self.changes if one.counts)

    @property
    def last(self) -> FoldErrors:
        """Errors of the last model."""
        return self.forces.errors

    @property
    def floor_from(self) -> FloorFrom | None:
        """What the floor is taken from; None where none is known."""
        if math.isfinite(self.forces.floor_percent):
            return "laps"
        if self.healthy is not None:
            return "healthy records"
        if math.isfinite(self.forces.estimated.percent):
            return "estimate" if self.forces.estimated.compared else "noise"
        return None

    @property
    def floor_percent(self) -> float:
        """What no model can be better than, %; NaN where it is not known."""
        if self.floor_from == "healthy records":
            return self.healthy_percent
        return self.forces.floor_percent if self.floor_from == "laps" else self.forces.estimated.percent

    @property
    def healthy_percent(self) -> float:
        """What is left of the healthy records, in % of today's drive; NaN without any."""
        return 100.0 * self.healthy.error_Nm / self.forces.drive_Nm if self.healthy is not None else math.nan

    @property
    def unexplained(self) -> float | None:
        """Share of the squared error above the floor, of the refitted base values, that stays; None where the floor is not known."""
        floor = self.floor_percent
        if not math.isfinite(floor):
            return None
        before, after = self.forces.refitted.training, self.last.training
        excess = before**2 - floor**2
        return min(max((after**2 - floor**2) / excess, 0.0), 1.0) if excess > 0.0 else 0.0

    @property
    def exceeds(self) -> bool:
        """Whether the first model leaves more than what is known to be there anyhow."""
        before = self.forces.refitted.training
        if self.healthy is not None:
            # what the model lacks of a force grows with the force
            grown = 1.0 + min(max((abs(one.today / one.healthy - 1.0) for one in self.changed if one.healthy), default=0.0), _GROWN)
            worst = 100.0 * grown * self.healthy.worst_Nm / self.forces.drive_Nm
            fitted_leaves = self.healthy.beyond(0.01 * before * self.forces.drive_Nm / grown) and math.hypot(MATTERS, worst) < before
            return fitted_leaves or (self.untold and not self.changed)
        return self._beyond_floor or self.untellable

    @property
    def _beyond_floor(self) -> bool:
        """Whether more is left than what records without healthy ones beside them show to be chance, and enough that anyone asks for it."""
        return self.beyond_chance and self.forces.refitted.training > MATTERS

    @property
    def beyond_chance(self) -> bool:
        """Whether more is left than what records without healthy ones beside them show to be chance."""
        before = self.forces.refitted.training
        if self.floor_from is None:
            return False
        margin = _MARGINS[self.floor_from]
        if self.floor_from in ("estimate", "noise") and self.forces.estimated.foretold > _FORETOLD:
            margin = min(margin, _MARGIN_FORETOLD)
        if before > _MUCH:
            margin = min(margin, _MARGIN_MUCH)
        return before > margin * self.floor_percent

    @property
    def untellable(self) -> bool:
        """Whether so much is left that it is no model's word, and nothing but an estimate says that it is chance: what is missing may be as irregular. Laps that differ by more than the model
        errs say it no more: what drifts from lap to lap is in their floor."""
        before = self.forces.refitted.training
        by_laps = self.floor_from == "laps" and self.floor_percent <= before
        return self.healthy is None and not by_laps and not self._beyond_floor and before > _TELLS

    @property
    def untold(self) -> bool:
        """Whether the healthy machine as it is leaves more of today's records than its own records, and what they tell of today's motion, allow. Few records do not say what they tell."""
        return self.healthy is not None and self.healthy.sure and self.healthy.beyond(self.left_Nm, self.healthy.times * self.doubt_Nm)

    @property
    def verdict(self) -> Verdict:
        """missing when effects were accepted; unknown when none explains what exceeds the floor. A value of the machine that has changed is a fault of the machine, not of the model."""
        if self.accepted:
            return "missing"
        return "unknown" if self.exceeds or self.unseen else "adequate"

    @property
    def unseen(self) -> str:
        """What the drive of a record does above all that its balance can see, or that a record is another machine's, in words; empty where nothing of either shows."""
        return next((one.text for gate in self.gates for one in gate.remarks if one.topic in (UNSEEN, FOREIGN)), "")


def has_balance(actuator: Actuator, record: AnyRecord) -> bool:
    """Whether a record has a mechanical balance."""
    try:
        mechanical(actuator, record)
    except (MissingSignal, InputError):
        return False
    return True


def has_laps(record: AnyRecord) -> bool:
    """Whether a record repeats itself often enough to hold laps out."""
    found = laps_of(record)
    return bool(found.period_rows) and found.count >= LAPS_MIN


def gates_of(actuator: Actuator, records: Sequence[AnyRecord], holdout: Sequence[AnyRecord] = ()) -> tuple[RecordValidity, ...]:
    """Whether each of the records can answer by its balance. Raises InputError for the first that cannot, for one that is held out and has no balance, and for one that is given twice."""
    check_once((*records, *holdout), "run")
    gates = tuple(judge_motion(actuator, record) if isinstance(record, MotionRecord) else judge(actuator, record) for record in records)
    for record, gate in zip(records, gates, strict=True):
        if not gate.answerable:
            remark = next(one for one in gate.remarks if one.severity == "blocks")
            raise InputError(remark.of(record.file))
    for record in (*records, *holdout):
        try:
            mechanical(actuator, record)
        except MissingSignal as error:
            raise InputError(f"{record.file}: no balance of forces: {error}: record the motion and the drive (current_A)") from None
    for record in holdout:
        if isinstance(record, MotionRecord) and (remarks := turned(mechanical_model(actuator, record))):
            raise InputError(remarks[0].of(record.file))
    shown = one_way(gates)
    return gates if shown is None else (replace(gates[0], remarks=(*gates[0].remarks, shown)), *gates[1:])


def answer_by_balance(
    actuator: Actuator,
    records: Sequence[AnyRecord],
    holdout: Sequence[AnyRecord] = (),
    report: Report | None = None,
    fixes: Fixes = NONE,
    healthy: Sequence[AnyRecord] = (),
) -> BalanceAnswer:
    """Diagnoses records by their balance, against the machine that `healthy` ones show where there are any; nothing is fitted to `holdout`.

    Raises InputError for a record that cannot answer.
    """
    tell = report or untold
    gates = gates_of(actuator, records, holdout)
    if healthy:
        for record in (*records, *holdout):
            check_apart(record, healthy)
        gates_of(actuator, healthy)
        machine = healthy_machine(actuator, healthy, fixes, lambda share, text: tell(0.45 * share, f"healthy machine, {text}"))
        return answer_against(machine, records, holdout, gates, fixes, lambda share, text: tell(0.45 + 0.5 * share, text))
    forces = improve_by_forces(actuator, records, holdout, lambda share, text: tell(0.95 * share, text), fixes)
    first = records[0]
    there = where(actuator, first) if not isinstance(first, MotionRecord) else None
    compared = (compared_percent(actuator, records), compared_percent(forces.actuator, records))
    forward = forward_of(actuator, forces.actuator, records, holdout, forces.division, forces.foretold)
    plays = plays_seen(actuator, records)
    return BalanceAnswer(
        tuple(records),
        tuple(holdout),
        actuator,
        _with(gates, (*foreign_records(forces.actuator, (*records, *holdout)), *lag_remarks(plays))),
        there,
        forces,
        compared,
        forward,
        _pictures(forces, records),
        base=(*forces.base, *play_value(actuator, plays)),
    )


def _with(gates: tuple[RecordValidity, ...], remarks: Sequence[RecordRemark]) -> tuple[RecordValidity, ...]:
    """The gates with remarks about all records."""
    return (replace(gates[0], remarks=(*remarks, *gates[0].remarks)), *gates[1:]) if remarks else gates


def _pictures(forces: ForceSteps, records: Sequence[AnyRecord]) -> Pictures | None:
    """What is drawn of the last model on records without a controller; None of others, of which more is drawn."""
    there = [record for record in records if isinstance(record, MotionRecord)]
    return motion_pictures(forces.actuator, there) if there else None


def _with_own_sizes(
    machine: HealthyByBalance, start: Actuator, forces: ForceSteps, records: Sequence[AnyRecord], fixes: Fixes
) -> tuple[Actuator, bool] | None:
    """The machine with what it has anyhow as large as today's records have it, and whether no more is left then than of healthy ones; None where it has nothing of its own, or nothing more than
    that is left without, and nothing was named."""
    if not start.active_effects or not (forces.steps or machine.beyond(0.01 * forces.refitted.training * forces.drive_Nm)):
        return None
    # a load that began is none of these
    free = refit_by_forces(start, records, fixes if load_effect() in start.active_effects else fixes.without(LOAD))
    sized = start.changed({name: value for name, value in free.values.items() if name not in MECHANICAL_PARAMETERS})
    return sized, not machine.beyond(0.01 * free.errors.training * forces.drive_Nm)


def _nothing_more(_search: ForceSearch, _accepted: Fitted, _tried: Tried) -> str:
    """Why no effect is sought where the machine's own, of another size, leave no more than healthy records do."""
    return "no change: with what the machine has anyhow as large as it is today, the records leave no more than healthy ones"


def _explains(resized: ForceSteps, new: ForceSteps) -> bool:
    """Whether effects of the machine that are of another size explain its records better than new ones, or as well with fewer."""
    after, before = resized.errors.training, new.errors.training
    return after < _BETTER * before or (len(resized.steps) < len(new.steps) and after <= before / _BETTER)


def answer_against(
    machine: HealthyByBalance,
    records: Sequence[AnyRecord],
    holdout: Sequence[AnyRecord],
    gates: tuple[RecordValidity, ...],
    fixes: Fixes = NONE,
    report: Report = untold,
) -> BalanceAnswer:
    """What has changed against a healthy machine. `gates`: whether each of the records can answer."""
    known = machine.actuator
    alone = changed_alone(machine, records, fixes)
    start = known.changed(alone)
    forces = improve_by_forces(start, records, holdout, lambda share, text: report(0.5 * share, text), fixes, machine.veto)
    resized = _with_own_sizes(machine, start, forces, records, fixes)
    if resized is not None:
        sized, enough = resized
        veto = _nothing_more if enough else machine.veto
        again = improve_by_forces(sized, records, holdout, lambda share, text: report(0.5 + 0.4 * share, text), fixes, veto)
        forces = again if enough or _explains(again, forces) else forces
    if alone or resized is not None:
        # what the healthy machine leaves is told with its own values
        forces = replace(forces, given=given_errors(known, Bench(known, records, holdout, fixes)))
    named = {step.effect for step in forces.steps}
    loads = {name: value for name, value in alone.items() if name != CONSTANT}
    found = Causes(forces, changes_of(machine, forces.actuator, records, fixes, named, loads))
    if not alone:
        found = fewer_causes(machine, found, records, holdout, fixes, lambda share, text: report(0.9 + 0.1 * share, text))
    report(1.0, "done")
    forces, told = found.forces, found.told
    plays, today = plays_seen(known, machine.records), plays_seen(machine.actuator, records)
    # what is no change is as it was: a value that was fitted may have taken up something else
    as_told = {one.name: one.today if one.counts else one.healthy for one in told.values}
    rests = standstill_changes(machine, forces.actuator.changed(as_told), records, found.effects)
    changes = (*told.values, *play_changes(machine, plays, today), *rests, *winding_changes(machine, records))
    compared = (compared_percent(known, records), compared_percent(forces.actuator, records))
    forward = forward_of(known, forces.actuator, records, holdout, forces.division, forces.foretold)
    odd = [*foreign_records(forces.actuator, (*records, *holdout)), *another_machine(changes), *lag_remarks(today)]
    return BalanceAnswer(
        tuple(records),
        tuple(holdout),
        known,
        _with(gates, odd),
        None,
        forces,
        compared,
        forward,
        _pictures(forces, records),
        machine,
        changes,
        told.left_Nm,
        told.doubt_Nm,
        (*machine.steps.base, *play_value(known, plays)),
        told.nearest,
        tuple(dict.fromkeys([*found.as_well, *looks_like(rests)])),
    )
