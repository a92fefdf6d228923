"""What `ema diagnose` answers by the mechanical balance, effect by effect, on one record or on several, parts of them held out.

It needs the drive and the motion and no simulation, so that it serves a machine whose controller is not known; and a loop so stiff that the position hardly shows the mechanics, while
the drive does. What repeats in the records is missing model.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ema_tools.balances.mechanical import mechanical
from ema_tools.base.errors import InputError, MissingSignal
from ema_tools.base.progress import Report, untold
from ema_tools.compare.localisation import Where, where
from ema_tools.compare.motion_validity import judge_motion
from ema_tools.compare.validity import RecordValidity, judge
from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import AnyRecord, MotionRecord
from ema_tools.fit.laps import laps_of
from ema_tools.library.registry import record_of
from ema_tools.results.diagnosis import Verdict
from ema_tools.select.force_balance import ForceStep, ForceSteps, improve_by_forces

LAPS_MIN = 3  # fewer laps than these leave too little to hold out [judgement]
_FLOOR_MARGIN = 1.2  # what the first model leaves beyond the floor must be more than this, relative, for anything to be missing [judgement]


@dataclass(frozen=True)
class BalanceAnswer:
    """Everything that was found, `known` being the actuator as given; errors are relative force errors in %. `gates`: of every record fitted; `where`: of the first where it can be simulated."""

    records: tuple[AnyRecord, ...]
    holdout: tuple[AnyRecord, ...]
    known: Actuator
    gates: tuple[RecordValidity, ...]
    where: Where | None
    forces: ForceSteps

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
    def unexplained(self) -> float | None:
        """Share of the squared error above the floor, of the refitted base values, that stays; None where the floor is not known."""
        floor = self.forces.floor_percent
        if not math.isfinite(floor):
            return None
        before, after = (
            self.forces.refitted.training,
            (self.forces.steps[-1].errors if self.forces.steps else self.forces.refitted).training,
        )
        excess = before**2 - floor**2
        return min(max((after**2 - floor**2) / excess, 0.0), 1.0) if excess > 0.0 else 0.0

    @property
    def verdict(self) -> Verdict:
        """missing when effects were accepted; unknown when none explains what exceeds the laps' own repeatability."""
        if self.accepted:
            return "missing"
        exceeds = math.isfinite(self.forces.floor_percent) and self.forces.refitted.training > _FLOOR_MARGIN * self.forces.floor_percent
        return "unknown" if exceeds else "adequate"


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


def answer_by_balance(
    actuator: Actuator, records: Sequence[AnyRecord], holdout: Sequence[AnyRecord] = (), report: Report | None = None
) -> BalanceAnswer:
    """Diagnoses records by their balance; nothing is fitted to `holdout`. Raises InputError for a record that cannot answer."""
    tell = report or untold
    gates = tuple(judge_motion(actuator, record) if isinstance(record, MotionRecord) else judge(actuator, record) for record in records)
    for record, gate in zip(records, gates, strict=True):
        if not gate.answerable:
            remark = next(one for one in gate.remarks if one.severity == "blocks")
            raise InputError(f"{record.file}: {remark.text}: {remark.next}")
    for record in (*records, *holdout):
        try:
            mechanical(actuator, record)
        except MissingSignal as error:
            raise InputError(f"{record.file}: no balance of forces: {error}: record the motion and the drive (current_A)") from None
    forces = improve_by_forces(actuator, records, holdout, lambda share, text: tell(0.95 * share, text))
    first = records[0]
    there = where(actuator, first) if not isinstance(first, MotionRecord) else None
    return BalanceAnswer(tuple(records), tuple(holdout), actuator, gates, there, forces)
