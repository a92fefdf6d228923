"""The trials: each machine with one effect hidden in it or with none, asked about as a user would who knows the inertia and has a rough idea of the friction."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.machines.plants import COMMANDS, EFFECTS, KINDS, Machine, records, shows
from ema_tools.base.errors import InputError
from ema_tools.data.actuator import Actuator, read_actuator
from ema_tools.results.codec import to_json
from ema_tools.tasks.method import chosen, diagnosed
from ema_tools.words.answers.method import diagnosis

SIZES = {"medium": 1.0, "large": 2.5}
HEALTHY = "healthy"
# Every machine's contacts yield before they slide.
ALWAYS = ("presliding",)


@dataclass(frozen=True)
class MachineTrial:
    """One diagnosis: kind of machine, unit, command, what is hidden (or healthy) and how much of it."""

    kind: str
    number: int
    command: str
    effect: str
    size: str = ""

    @property
    def key(self) -> str:
        """Of its row."""
        return f"{self.kind}, unit {self.number}, {self.command}, {self.effect} {self.size}".rstrip()

    @property
    def group(self) -> str:
        """File of its rows."""
        return f"{self.kind}_{self.number}".replace(" ", "_")


def plan(units: int, healthy: int = 0) -> list[MachineTrial]:
    """All trials of so many units of each kind, and those of healthy ones until they are so many."""
    found = []
    for kind in KINDS:
        for number in range(max(units, healthy)):
            for command in COMMANDS:
                found.append(MachineTrial(kind, number, command, HEALTHY))
                if number >= units:
                    continue
                found += [
                    MachineTrial(kind, number, command, effect, size)
                    for effect in EFFECTS
                    if shows(kind, effect, command)
                    for size in SIZES
                ]
    return found


def actuator_of(kind: str, number: int) -> Actuator:
    """What a user knows of a unit: its inertia to some percent, friction and drag of the kind roughly."""
    one, random = KINDS[kind], np.random.default_rng([15_485_863, list(KINDS).index(kind), number])
    own = Machine(kind, number, {}).values()
    lines = [
        "[screw]",
        f"inertia_kgm2 = {own['inertia'] * float(random.uniform(0.95, 1.05)):.6g}",
        f"viscous_Nm_s_per_rad = {one.viscous_Nm_s_per_rad:.6g}",
        f"csj_Nm = {one.friction_Nm:.6g}",
    ]
    if one.mm_per_rad:
        lines += [f"lead_mm = {one.mm_per_rad * 2.0 * np.pi * one.ratio:.9g}", "[gearbox]", f"ratio = {one.ratio:g}"]
    lines += ["[motor]", f"torque_constant_Nm_per_A = {one.constant_Nm_per_A:g}"]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "machine.toml"
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        return read_actuator(path, complete=False)


def perform(trial: MachineTrial) -> dict[str, Any]:
    """The row of a trial: what the command would write, in a few words."""
    hidden = {} if trial.effect == HEALTHY else {trial.effect: EFFECTS[trial.effect] * SIZES[trial.size]}
    row: dict[str, Any] = {"key": trial.key, "kind": trial.kind, "command": trial.command, "effect": trial.effect, "size": trial.size}
    actuator = actuator_of(trial.kind, trial.number)
    found = records(Machine(trial.kind, trial.number, hidden), trial.command)
    try:
        way = chosen(actuator, found)
        result = to_json(diagnosis(diagnosed(actuator, found, way=way), {}, because=way.because))
    except InputError as error:
        return {**row, "refused": str(error)}
    accepted = [one for one in result["effects"] if one["accepted"]]
    return {
        **row,
        "verdict": result["verdict"],
        "accepted": [one["name"] for one in accepted],
        "classes": [one["class"] for one in accepted],
        "error": [result["error"]["before"], result["error"]["after"]],
        "parameters": accepted[0]["parameters"] if accepted else {},
    }


def right(row: dict[str, Any]) -> bool:
    """Whether the hidden effect, or one that such records cannot tell from it, is accepted, and first."""
    first: list[str] = next(
        (alike for name, alike in zip(row.get("accepted", []), row.get("classes", []), strict=True) if name not in ALWAYS), []
    )
    return row["effect"] in first


def named(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Rows in which something was hidden."""
    return [row for row in rows if row["effect"] != HEALTHY]


def wrong(row: dict[str, Any]) -> list[str]:
    """Accepted effects that are not there, nor what is in their class."""
    return [
        name
        for name, alike in zip(row.get("accepted", []), row.get("classes", []), strict=True)
        if row["effect"] not in alike and name not in ALWAYS
    ]
