"""What could be told at best: an observer who knows the machine's form, the forms of all effects and the noise, and asks which of them made the torque.

The torque of what is hidden, along the motion it made, less what base values and any size of another effect make of it, in standard deviations of the drive's white noise. Half of that,
against the nearest other effect, is how sure the best possible answer is. Errors of the motion's sensor are left out: the observer is too good rather than too bad.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy import stats

from benchmarks.machines.plants import EFFECTS, KINDS, NOISE_SHARE, Machine, columns_of, shows, torques
from benchmarks.machines.trials import HEALTHY, SIZES, MachineTrial
from ema_tools.base.arrays import Reals

# A constant torque, and friction that is larger one way: no record of one machine tells them apart, and either answer is right.
_ONE = frozenset({"constant_load", "coulomb_asymmetry"})


def observed(trial: MachineTrial) -> dict[str, Any]:
    """The row of a trial: the chance of the best possible answer to be right; 1 for a healthy machine, which has nothing to name."""
    row: dict[str, Any] = {"key": trial.key, "kind": trial.kind, "command": trial.command, "effect": trial.effect, "size": trial.size}
    if trial.effect == HEALTHY:
        return {**row, "chance": 1.0}
    hidden = {trial.effect: EFFECTS[trial.effect] * SIZES[trial.size]}
    machine = Machine(trial.kind, trial.number, hidden)
    motions = torques(machine, trial.command)
    base = np.concatenate([columns_of(machine, motion, "") for motion in motions])
    made = np.concatenate([columns_of(machine, motion, trial.effect)[:, 0] for motion in motions]) * hidden[trial.effect]
    others = [
        name for name in EFFECTS if name != trial.effect and not {name, trial.effect} <= _ONE and shows(trial.kind, name, trial.command)
    ]
    # none at all is an answer, too
    rivals = [base, *(np.column_stack([base, *_apart(machine, motions, name)]) for name in others)]
    noise_Nm = NOISE_SHARE * KINDS[trial.kind].friction_Nm
    nearest = min(float(np.linalg.norm(_left(made, rival))) for rival in rivals) / noise_Nm
    return {**row, "chance": float(stats.norm.cdf(0.5 * nearest))}


def _apart(machine: Machine, motions: list[Mapping[str, Reals]], name: str) -> list[Reals]:
    """The columns of an effect on all records, [rows] each: a wave has an amplitude and a phase."""
    found = np.concatenate([columns_of(machine, motion, name) for motion in motions])
    return list(found.T)


def _left(made: Reals, columns: Reals) -> Reals:
    """What is left of a torque beside any sizes of columns [rows, k]."""
    size = np.linalg.norm(columns, axis=0)
    scaled = columns / np.where(size > 0.0, size, 1.0)
    return np.asarray(made - scaled @ np.linalg.lstsq(scaled, made, rcond=None)[0])
