"""The axes against which a residual is drawn: every state of the machine that a record shows, and how to tell what repeats along one from chance."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ema_tools.balances.filtering import Smoother
from ema_tools.base.arrays import Reals
from ema_tools.compare.comparison import since_reversal_s
from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record
from ema_tools.library.definitions import TableAxis

Halves = NDArray[np.bool_]

_RESTING_SHARE = 0.01  # below this share of the largest speed the rod counts as resting [judgement]
_PASSES_MIN = 6  # with fewer passes than this the halves alternate in time instead: three on either side [judgement]
_TIME_BLOCKS = 12  # stretches of time that alternate between the halves then [judgement]


@dataclass(frozen=True)
class Axis:
    """A signal on some samples, [samples]; `period` of one that repeats, 0 for none. `kind` is its number in the learned effects' `axis`, -1 for none."""

    name: str
    unit: str
    values: Reals
    period: float = 0.0
    kind: int = -1


@dataclass(frozen=True)
class MachineState:
    """The machine on every row [rows]: time s, motor speed rad/s, acceleration rad/s2, motor angle rad, motor position at the rod mm, rod position mm, direction -1, 0 or 1, time since
    reversal s, and current A and voltage V where recorded. All from smoothed signals.

    What pictures are drawn against; any record has it. The balances' `Motion`, which equations are evaluated at, needs the motor's place and current and is refused without them.
    """

    time_s: Reals
    speed_rad_s: Reals
    acceleration_rad_s2: Reals
    angle_rad: Reals
    motor_mm: Reals
    position_mm: Reals
    direction: Reals
    since_reversal_s: Reals
    current_A: Reals | None
    voltage_V: Reals | None
    lead_mm: float

    def at(self, time_s: Reals) -> MachineState:
        """The same at other times, [samples]."""

        def there(values: Reals) -> Reals:
            return np.asarray(np.interp(time_s, self.time_s, values))

        rows = np.clip(np.searchsorted(self.time_s, time_s), 0, self.time_s.size - 1)
        return MachineState(
            time_s,
            there(self.speed_rad_s),
            there(self.acceleration_rad_s2),
            there(self.angle_rad),
            there(self.motor_mm),
            there(self.position_mm),
            self.direction[rows],
            self.since_reversal_s[rows],
            None if self.current_A is None else there(self.current_A),
            None if self.voltage_V is None else there(self.voltage_V),
            self.lead_mm,
        )

    def axes(self, rod: bool = False) -> tuple[Axis, ...]:
        """Every axis that the record has; with `rod` the position is the rod's, else the motor's expressed at the rod."""
        position = self.position_mm if rod else self.motor_mm
        found = [
            Axis("speed", "rad/s", self.speed_rad_s, kind=TableAxis.SPEED),
            Axis("position", "mm", position, kind=TableAxis.POSITION),
            Axis("place in the lead", "mm", np.mod(position, self.lead_mm), self.lead_mm, kind=TableAxis.LEAD),
            Axis("motor angle", "rad", np.mod(self.angle_rad, 2.0 * math.pi), 2.0 * math.pi, kind=TableAxis.TURN),
            Axis("acceleration", "rad/s2", self.acceleration_rad_s2),
            Axis("time since reversal", "s", self.since_reversal_s),
            Axis("time", "s", self.time_s),
        ]
        if self.current_A is not None:
            found.insert(4, Axis("current", "A", self.current_A, kind=TableAxis.CURRENT))
        return tuple(found)

    @property
    def passes(self) -> NDArray[np.int64]:
        """Number of the pass, from one reversal to the next, that each sample belongs to, [samples]."""
        moving = self.direction[self.direction != 0.0]
        turned = np.concatenate(([False], moving[1:] != moving[:-1]))
        number = np.zeros(self.direction.size, dtype=np.int64)
        number[self.direction != 0.0] = np.cumsum(turned)
        return np.asarray(np.maximum.accumulate(number))

    @property
    def moving(self) -> Halves:
        """True away from rest, where friction does not answer whatever there is, [samples]; the neighbours of rest are left out too."""
        still: Halves = self.direction == 0.0
        near = still.copy()
        near[1:] |= still[:-1]
        near[:-1] |= still[1:]
        return ~near

    def halves(self) -> Halves:
        """True on one half of the passes, both directions in each half; stretches of time where there are few passes. [samples]"""
        passes = self.passes
        if passes[-1] + 1 >= _PASSES_MIN:
            return np.asarray((passes // 2) % 2 == 0)
        block = np.arange(passes.size) * _TIME_BLOCKS // passes.size
        return np.asarray(block % 2 == 0)


def machine_state_of(actuator: Actuator, record: Record, smoother: Smoother) -> MachineState:
    """What moves in a record, from the motor encoder where it is recorded, else from the rod."""
    motor = record.position_mm if record.motor_position_mm is None else record.motor_position_mm
    period_s = record.period_s
    motor_mm = smoother.smooth(motor)
    angle = motor_mm / actuator.lead_mm_per_rad
    speed = np.gradient(angle, period_s)
    fastest = float(np.max(np.abs(speed[smoother.edge_rows : -smoother.edge_rows]), initial=0.0))
    direction = np.sign(speed) * (np.abs(speed) > _RESTING_SHARE * fastest)
    return MachineState(
        record.time_s,
        speed,
        np.gradient(speed, period_s),
        angle,
        motor_mm,
        smoother.smooth(record.position_mm),
        direction,
        since_reversal_s(direction, period_s),
        None if record.current_A is None else smoother.smooth(record.current_A),
        None if record.voltage_V is None else smoother.smooth(record.voltage_V),
        actuator["screw.lead_mm"],
    )


def foretold(residual: Reals, columns: Reals, half: Halves) -> Reals:
    """What a fit of `columns` [samples, p] on one half makes of the other, for both, [samples]."""
    out = np.zeros_like(residual)
    for fitted in (half, ~half):
        if np.count_nonzero(fitted) > columns.shape[1]:
            out[~fitted] = columns[~fitted] @ np.linalg.lstsq(columns[fitted], residual[fitted], rcond=1e-8)[0]
    return out


def explained(residual: Reals, columns: Reals, half: Halves) -> float:
    """Share of the squared residual [samples] that columns explain on samples that they were not fitted to; negative when they do harm."""
    total = float(residual @ residual)
    return 1.0 - float(np.sum((residual - foretold(residual, columns, half)) ** 2)) / total if total > 0.0 else 0.0


def fitted_energy(residual: Reals, columns: Reals) -> float:
    """Squared length of the part of the residual [samples] that columns [samples, p] can follow."""
    solved = columns @ np.linalg.lstsq(columns, residual, rcond=1e-8)[0]
    return float(solved @ solved)


def hats(values: Reals, first: float, last: float, nodes: int) -> Reals:
    """Columns [samples, nodes] whose sum with weights is a table over `values` [samples]: linear between equally spaced nodes, its edges held."""
    place = np.clip((values - first) / (last - first), 0.0, 1.0) * (nodes - 1)
    low = np.minimum(place.astype(int), nodes - 2)
    share = place - low
    columns = np.zeros((values.size, nodes))
    rows = np.arange(values.size)
    columns[rows, low] = 1.0 - share
    columns[rows, low + 1] = share
    return columns
