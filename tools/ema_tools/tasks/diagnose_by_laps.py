"""What `ema diagnose` answers on one record of a command that repeats, without healthy repeats: by the mechanical balance, effect by effect, laps held out.

In a stiff loop the position hardly shows the mechanics; the drive does, and its balance needs no simulation that a wrong block could spoil. Laps of one record say what the machine repeats.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from ema_tools.balances.mechanical import mechanical
from ema_tools.base.errors import InputError, MissingSignal
from ema_tools.base.progress import Report, untold
from ema_tools.compare.localisation import Where, where
from ema_tools.compare.validity import RecordValidity, judge
from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record
from ema_tools.fit.laps import laps_of
from ema_tools.library.registry import record_of
from ema_tools.results.diagnosis import Verdict
from ema_tools.select.force_balance import ForceStep, ForceSteps, improve_by_forces

LAPS_MIN = 3  # fewer laps than these leave too little to hold out [judgement]
_FLOOR_MARGIN = 1.2  # what the first model leaves beyond the floor must be more than this, relative, for anything to be missing [judgement]


@dataclass(frozen=True)
class LapsAnswer:
    """Everything that was found, `known` being the actuator as given; errors are relative force errors in %."""

    record: Record
    known: Actuator
    gate: RecordValidity
    where: Where
    forces: ForceSteps

    @property
    def accepted(self) -> tuple[ForceStep, ...]:
        """The steps whose effects are in the last model."""
        return tuple(
            step for step in self.forces.steps if step.effect in self.forces.actuator.active_effects or record_of(step.effect).base_value
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
    def verdict(self) -> Verdict:
        """missing when effects were accepted; unknown when none explains what exceeds the laps' own repeatability."""
        if self.accepted:
            return "missing"
        exceeds = math.isfinite(self.forces.floor_percent) and self.forces.refitted.training > _FLOOR_MARGIN * self.forces.floor_percent
        return "unknown" if exceeds else "adequate"


def applies(actuator: Actuator, record: Record) -> bool:
    """Whether a record has laps enough and a mechanical balance."""
    found = laps_of(record)
    if not found.period_rows or found.count < LAPS_MIN:
        return False
    try:
        mechanical(actuator, record)
    except (MissingSignal, InputError):
        return False
    return True


def answer_by_laps(actuator: Actuator, record: Record, report: Report | None = None) -> LapsAnswer:
    """Diagnoses a record by its laps. Raises InputError for a record that cannot answer."""
    tell = report or untold
    gate = judge(actuator, record)
    if not gate.answerable:
        remark = next(one for one in gate.remarks if one.severity == "blocks")
        raise InputError(f"{record.file}: {remark.text}: {remark.next}")
    forces = improve_by_forces(actuator, (record,), progress=lambda share, text: tell(0.95 * share, text))
    return LapsAnswer(record, actuator, gate, where(actuator, record), forces)
