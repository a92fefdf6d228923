"""Torques of single effects in closed form, so that hundreds of shapes are tried at once: on the residual of a record by a matched filter, and in the balance of forces."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ema_tools.base.arrays import Reals

# Numbers of periods per motor turn that pairs of slots and poles make [physics]
PERIODS_PER_TURN = (*range(1, 61), 64, 66, 72, 78, 80, 84, 90, 96, 108, 120, 126, 132, 144, 156, 168, 180)

WIDEST_SPOT = 0.1  # of the stroke, to either side of a spot's middle, at most: wider, it is friction by place [judgement]

Shape = Mapping[str, float]


@dataclass(frozen=True)
class States:
    """What the torque of an effect depends on, each [rows], simulated or measured.

    `direction`: of dry friction, the sign of the motion; at rest none of it, or the share of its level that holds the shaft. `screw_rad`: angle of the screw.
    `time_s`: since the record's start. `level_Nm`, `viscous_Nm_s_per_rad`: friction as the model has it.
    """

    direction: Reals
    speed_rad_s: Reals
    angle_rad: Reals
    screw_rad: Reals
    screw_mm: Reals
    current_A: Reals
    time_s: Reals
    torque_constant_Nm_per_A: float
    back_emf_V_s_per_rad: float
    level_Nm: float
    viscous_Nm_s_per_rad: float


# Values to try of each field of shape: fixed ones, or made for the states of a record.
Grid = Mapping[str, Sequence[float] | Callable[[States], Sequence[float]]]


def values_in(grid: Grid, states: States) -> dict[str, Sequence[float]]:
    """The values of each field for the states of a record."""
    return {name: values(states) if callable(values) else values for name, values in grid.items()}


def combined(values: Mapping[str, Sequence[float]]) -> list[Shape]:
    """Every shape of these values by field, the last field changing fastest."""
    return [dict(zip(values, chosen, strict=True)) for chosen in itertools.product(*values.values())]


@dataclass(frozen=True)
class PeriodicTorque:
    """A torque that repeats `periods` times per turn of `angle`, with an amplitude and a phase: fields `periods` and `phase_rad`. No `periods`: once per turn, no such field.

    `torque`: on the motor shaft per unit of the size, positive accelerates, what the wave is multiplied by; `voltage`: in the winding beside it; `cosine`: of the angle and phase, else sine.
    `of_level`: the size is a share of the level of dry friction. `in_balance`: periods tried in a force balance.
    """

    angle: Callable[[States], Reals]
    torque: Callable[[States], Reals]
    periods: tuple[int, ...] = ()
    in_balance: tuple[int, ...] = ()
    voltage: Callable[[States], Reals] | None = None
    cosine: bool = False
    of_level: bool = False
    # Whether it may turn with what a belt or a gear drives, so that any number of periods per motor turn is possible.
    behind_gear: bool = False
    # When it is large beside the friction it holds the motor at rest, and a filter that knows no rest is right in the periods and wrong in the phase.
    holds_at_rest: bool = False
    # Without the current, dozens of periods per turn show only where the machine nearly rests, which no linear filter sees: the size, as a share of the friction or of the
    # torque, at which every number of periods is then simulated. 0: none is.
    simulated_at: float = 0.0


@dataclass(frozen=True)
class LocalTorque:
    """A torque of one sign in a shape that is tried from a grid: `torque` on the motor shaft per unit of the size, positive accelerates, for states and a shape by field.

    `tried`: shapes that a matched filter tries; `in_balance`: those that a force balance tries, between which it then searches, its values held inside the row's ranges; none where it
    does not seek the effect.
    `spot`: the field of its width, which is no more than a small share of the stroke, else it is no spot. `of_level`: the size is a share of the level of dry friction.
    `falls`: with it friction is less at some higher speed than at some lower one, or it is no such effect.
    """

    torque: Callable[[States, Shape], Reals]
    tried: Grid
    in_balance: Grid = field(default_factory=dict)
    of_level: bool = False
    falls: bool = False
    spot: str = ""


@dataclass(frozen=True)
class AlongStroke:
    """Friction that is another one at every place: a table over the stroke that the records show, in a force balance a sum of so many waves, all of them fitted at once.

    `called`: what people know it by, where its row is one for any axis.
    """

    waves: int
    called: str


@dataclass(frozen=True)
class Bending:
    """An effect that changes the mechanical balance itself, so that its size is searched in a force balance, from these, and its shape from those `beside`;
    `of_drive`: only where it changes the drive's torque."""

    sizes: Sequence[float] | Callable[[States], Sequence[float]]
    of_drive: bool = False
    beside: Grid = field(default_factory=dict)


def turn(states: States) -> Reals:
    """Angle of the motor."""
    return states.angle_rad


def screw_turn(states: States) -> Reals:
    """Angle of the screw."""
    return states.screw_rad


def everywhere(states: States) -> Reals:
    """One at every row."""
    return np.ones_like(states.angle_rad)


def against_motion(states: States) -> Reals:
    """Minus one forward and one backward, as friction."""
    return -states.direction


def places(count: int) -> Callable[[States], Sequence[float]]:
    """So many places along the stroke."""

    def along(states: States) -> Sequence[float]:
        found: list[float] = np.linspace(float(states.screw_mm.min()), float(states.screw_mm.max()), count).tolist()
        return found

    return along


def shares_of_stroke(shares: Sequence[float]) -> Callable[[States], Sequence[float]]:
    """Lengths as shares of the stroke."""

    def lengths(states: States) -> Sequence[float]:
        stroke = float(states.screw_mm.max()) - float(states.screw_mm.min())
        return [share * stroke for share in shares]

    return lengths


def shares_of_speed(shares: Sequence[float]) -> Callable[[States], Sequence[float]]:
    """Speeds as shares of the largest."""

    def speeds(states: States) -> Sequence[float]:
        fastest = float(np.max(np.abs(states.speed_rad_s), initial=0.0))
        return [share * fastest for share in shares]

    return speeds


def shares_of_time(shares: Sequence[float]) -> Callable[[States], Sequence[float]]:
    """Times as shares of the longest record."""

    def times(states: States) -> Sequence[float]:
        longest = float(np.max(states.time_s, initial=0.0))
        return [share * longest for share in shares]

    return times
