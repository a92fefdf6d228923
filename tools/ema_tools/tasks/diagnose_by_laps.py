"""What `ema diagnose` answers on one record of a command that repeats, without healthy repeats: by the mechanical balance, effect by effect, laps held out.

In a stiff loop the position hardly shows the mechanics; the drive does, and its balance needs no simulation that a wrong block could spoil. Laps of one record say what the machine repeats.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ema_tools.balances.mechanical import mechanical
from ema_tools.base.errors import InputError, MissingSignal
from ema_tools.base.progress import Report
from ema_tools.compare.localisation import Where, where
from ema_tools.compare.validity import Gate, judge
from ema_tools.data.actuator import Actuator, row_of
from ema_tools.data.records import Record
from ema_tools.fit.laps import laps_of
from ema_tools.library.registry import record_of
from ema_tools.select.force_balance import ForceStep, ForceSteps, improve_by_forces
from ema_tools.tasks.diagnose import size_text

# Fewer laps than these leave too little to hold out.
LAPS_MIN = 3
_INTERVAL = 1.96
# What the first model leaves beyond the floor must be more than this, relative, for anything to be missing.
_FLOOR_MARGIN = 1.2


@dataclass(frozen=True)
class LapsAnswer:
    """Everything that was found; errors are relative force errors in %."""

    record: Record
    gate: Gate
    where: Where
    forces: ForceSteps

    @property
    def accepted(self) -> tuple[ForceStep, ...]:
        """The steps whose effects are in the last model."""
        return tuple(
            step for step in self.forces.steps if step.effect in self.forces.actuator.active_effects or record_of(step.effect).base_value
        )

    @property
    def actuator(self) -> Actuator:
        """The model with every accepted effect and the base values refitted beside them."""
        return self.forces.actuator

    @property
    def verdict(self) -> str:
        """missing when effects were accepted; unknown when none explains what exceeds the laps' own repeatability."""
        if self.accepted:
            return "missing"
        exceeds = math.isfinite(self.forces.floor_percent) and self.forces.refitted.training > _FLOOR_MARGIN * self.forces.floor_percent
        return "unknown" if exceeds else "adequate"

    def sentence(self) -> str:
        """The answer in a sentence or two."""
        given = self.forces.given
        floor = f"the laps repeat to {self.forces.floor_percent:.2f} %" if math.isfinite(self.forces.floor_percent) else "no floor is known"
        if not self.accepted:
            said = (
                "no effect of the library carries over to the laps held out"
                if self.verdict == "unknown"
                else "nothing exceeds what the laps repeat"
            )
            return f"{self.record.file}: {said} (force error {given.training:.2f} %, {floor})."
        last = self.forces.steps[-1].errors
        names = ", ".join(step.effect for step in self.accepted)
        return (
            f"{self.record.file}: missing are {names}: force error {given.training:.2f} % on the laps fitted and {given.holdout:.2f} % on the laps held out before,"
            f" {last.training:.2f} % and {last.holdout:.2f} % after; {floor}."
        )

    def next_step(self) -> str:
        """What to do next."""
        if self.accepted:
            return (
                "Next: --fitted NEW.toml writes the model with these effects; hold it against a record of another motion with ema compare."
            )
        return "Next: record another motion, and the current, so that more of the mechanics is seen."

    def result(self) -> dict[str, Any]:
        """For JSON: the keys that programs read, and what the page draws."""
        found = self.forces
        last = found.steps[-1].errors if found.steps else found.refitted
        kept = {step.effect for step in self.accepted}
        effects = [self._effect(step) for step in self.accepted]
        refused = [
            {
                "name": one.effect,
                "class": [one.effect],
                "parameters": _numbers(one.effect, one.values),
                "std": _numbers(one.effect, one.std),
                "score": 0.0,
                "limit": 0.0,
                "accepted": False,
                "reason": one.reason,
            }
            for one in found.refused
            if one.effect not in kept
        ]
        steps = [
            {"effects": [], "added": "as given", "error_training": found.given.training, "error_holdout": found.given.holdout},
            {
                "effects": [],
                "added": "base values refitted",
                "error_training": found.refitted.training,
                "error_holdout": found.refitted.holdout,
            },
        ]
        names: list[str] = []
        for step in found.steps:
            names.append(step.effect)
            steps.append(
                {"effects": list(names), "added": step.effect, "error_training": step.errors.training, "error_holdout": step.errors.holdout}
            )
        return {
            "verdict": self.verdict,
            "sentence": self.sentence(),
            "mode": "laps of one record",
            "effects": effects + refused,
            "faults": {},
            "error": {
                "before": found.given.training,
                "after": last.training,
                "floor": found.floor_percent if math.isfinite(found.floor_percent) else None,
                "holdout_before": found.given.holdout,
                "holdout_after": last.holdout,
            },
            "error_unit": "% of the drive's force",
            "next_experiment": self.next_step(),
            "steps": steps,
            "forces": found.result(),
            "gate": self.gate.result(),
            "where": self.where.result(),
            "unknown": None,
        }

    def _effect(self, step: ForceStep) -> dict[str, Any]:
        """One accepted effect, with its size as the last joint fit has it."""
        place = self.forces.steps.index(step)
        before = self.forces.steps[place - 1].errors if place else self.forces.refitted
        last = self.forces.steps[-1]
        values, std = _numbers(step.effect, last.values), _numbers(step.effect, last.std)
        return {
            "name": step.effect,
            "class": [step.effect, *step.alike],
            "parameters": values,
            "std": std,
            "interval95": {
                name: [values[name] - _INTERVAL * doubt, values[name] + _INTERVAL * doubt] for name, doubt in std.items() if name in values
            },
            "score": before.holdout**2 - step.errors.holdout**2,
            "limit": 0.0,
            "accepted": True,
        }


def _numbers(effect: str, values: Any) -> dict[str, float]:
    """Values of one effect by field."""
    base_value = record_of(effect).base_value
    return {name.split(".")[-1]: float(value) for name, value in values.items() if f"{effect}." in name or name == base_value}


def size_of(step: ForceStep, last: ForceStep) -> str:
    """The size of a step's effect as the last fit has it, with its standard error."""
    name = next(
        (name for name in last.values if f"{step.effect}." in name or name == record_of(step.effect).base_value),
        None,
    )
    return f"{row_of(name).field} {size_text(name, last.values[name], last.std.get(name))}" if name is not None else ""


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
    tell = report or (lambda _share, _text: None)
    gate = judge(actuator, record)
    if not gate.answerable:
        remark = next(one for one in gate.remarks if one.severity == "blocks")
        raise InputError(f"{record.file}: {remark.text}: {remark.next}")
    forces = improve_by_forces(actuator, record, lambda share, text: tell(0.95 * share, text))
    return LapsAnswer(record, gate, where(actuator, record), forces)
