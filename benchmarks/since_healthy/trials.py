"""The trials: each machine of the machines' benchmark on some healthy days and on one day when one of its values has changed, one effect has begun, or nothing has."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from benchmarks.machines.plants import COMMANDS, EFFECTS, KINDS, Machine, records_of_day, shows
from benchmarks.machines.trials import ALWAYS, SIZES, actuator_of
from ema_tools.base.errors import InputError
from ema_tools.results.codec import to_json
from ema_tools.select.healthy_balance import HealthyByBalance, healthy_machine
from ema_tools.tasks.diagnose_by_balance import answer_against, gates_of
from ema_tools.words.answers.method import diagnosis

NOTHING = "nothing"
# What is changed of the machine's own values, as shares, and the value of the model that says so.
CHANGES: Mapping[str, tuple[str, float]] = {
    "friction": ("screw.csj_Nm", 0.3),
    "viscous": ("screw.viscous_Nm_s_per_rad", 0.8),
    "inertia": ("screw.inertia_kgm2", 0.25),
    "constant": ("motor.torque_constant_Nm_per_A", -0.12),
}
# One speed at a time tells neither inertia from nothing nor friction from drag.
MOVING = tuple(command for command in COMMANDS if command != "steady speeds")
HEALTHY_DAYS, TODAY = (1, 2), 3


@dataclass(frozen=True)
class DayTrial:
    """One diagnosis: kind of machine, unit, command, and what has happened since it was healthy: a value, an effect of a size, or nothing."""

    kind: str
    number: int
    command: str
    since: str
    size: str = ""

    @property
    def key(self) -> str:
        """Of its row."""
        return f"{self.kind}, unit {self.number}, {self.command}, {self.since} {self.size}".rstrip()

    @property
    def group(self) -> str:
        """File of its rows."""
        return f"{self.kind}_{self.number}_{self.command}".replace(" ", "_")

    @property
    def today(self) -> Machine:
        """The machine as it is."""
        if self.since in CHANGES:
            return Machine(self.kind, self.number, {}, {self.since: CHANGES[self.since][1]})
        return Machine(self.kind, self.number, {} if self.since == NOTHING else {self.since: EFFECTS[self.since] * SIZES[self.size]})


def plan(units: int) -> list[DayTrial]:
    """All trials of so many units of each kind."""
    found = []
    for kind, one in KINDS.items():
        values = [name for name in CHANGES if name != "constant" or one.drive == "current_A"]
        for number in range(units):
            for command in MOVING:
                found += [DayTrial(kind, number, command, name) for name in (NOTHING, *values)]
                found += [
                    DayTrial(kind, number, command, effect, size) for effect in EFFECTS if shows(kind, effect, command) for size in SIZES
                ]
    return found


@lru_cache(maxsize=1)
def _healthy(kind: str, number: int, command: str) -> HealthyByBalance:
    """What a machine's healthy days show, of which all trials of a group are told."""
    sound = Machine(kind, number, {})
    return healthy_machine(actuator_of(kind, number), [record for day in HEALTHY_DAYS for record in records_of_day(sound, command, day)])


def perform(trial: DayTrial) -> dict[str, Any]:
    """The row of a trial: what the command would write, in a few words."""
    row: dict[str, Any] = {"key": trial.key, "kind": trial.kind, "command": trial.command, "since": trial.since, "size": trial.size}
    actuator, today = actuator_of(trial.kind, trial.number), records_of_day(trial.today, trial.command, TODAY)
    try:
        found = answer_against(_healthy(trial.kind, trial.number, trial.command), today, (), gates_of(actuator, today))
        result = to_json(diagnosis(found, {}, because=""))
    except InputError as error:
        return {**row, "refused": str(error)}
    accepted = [one for one in result["effects"] if one["accepted"]]
    return {
        **row,
        "verdict": result["verdict"],
        "accepted": [one["name"] for one in accepted if one["name"] not in ALWAYS],
        "classes": [one["class"] for one in accepted if one["name"] not in ALWAYS],
        "as_well": result.get("as_well") or [],
        "changed": {name: one["change_percent"] for name, one in result["changes"].items() if one["counts"]},
        "error": [result["error"]["before"], result["error"]["after"]],
    }
