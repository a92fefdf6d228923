"""What motor and rod position together say of the play between them, today's records against healthy ones, whoever controls the machine.

The balance of forces hardly sees a play: the motor moves the same masses with and without it, but for moments. Two encoders see it directly: the rod stands half of it to one side of the motor or to
the other. Which side, friction decides (the side that the motor comes from, the play of the module), or a load that outweighs it: then it changes where the load does and not where the motion
turns.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from ema_tools.balances.effects import transmission_of
from ema_tools.balances.filtering import Smoother
from ema_tools.balances.motion import train_of
from ema_tools.base.arrays import Reals
from ema_tools.data.actuator import STARTS, Actuator, row_of
from ema_tools.data.motion_records import AnyRecord
from ema_tools.plant.native import library
from ema_tools.select.base_values import BaseValue
from ema_tools.select.healthy_balance import HealthyByBalance
from ema_tools.select.value_changes import Change

PLAY = "screw.blk_mm"
_LEAST = 0.05  # scatter of a play from record to record, relative, at least: contacts seat otherwise each day [judgement]
_OF_LEFT = 0.3  # ... and as a share of what the play leaves of the rod's position, rms: a width in that is not seen well [judgement]
_FORM = 0.07  # of a play, that contacts which yield and a rod with a mass take off what is seen, one standard deviation [judgement]
_LEAST_TIMES = 3.0  # such standard deviations are a change [chance]
_EXPLAINED = 0.999  # of the rod's square about its mean, that the motor must explain: else other things lie between the two, or one is of another axis [judgement]
_WIDEST = 0.25  # of the motor's way: a play as wide as that is not seen as one [judgement]
_WIDTHS = 24  # widths looked at before the best is refined [effort]
_NARROWEST = 1e-4  # of the widest, the first of them [precision]
_SHARES = np.linspace(0.0, 1.2, 25)  # friction of the rod, as a share of the largest load, that are tried [effort]
_MOVES = 0.02  # of the greatest speed: slower than that, the rod's friction has no direction [judgement]


@dataclass(frozen=True)
class SeenPlay:
    """The play that one record shows, and what it leaves of the rod's position, rms; both in mm."""

    width_mm: float
    left_mm: float


def play_seen(actuator: Actuator, record: AnyRecord) -> SeenPlay | None:
    """Play between motor and rod by both positions of a record; None where one of them is not recorded, or the rod does not follow the motor."""
    motor, rod = _motor_mm(actuator, record), record.position_mm
    smoother = Smoother.of(record.period_s)
    if motor is None or rod is None or transmission_of(actuator) or record.rows < smoother.least_rows:
        return None
    about = float(np.var(rod))
    if not float(np.ptp(motor)) > 0.0 or not about > 0.0:
        return None
    speed = np.gradient(smoother.smooth(motor), record.period_s)
    # at rest the rod may stay anywhere in the play
    moves = np.abs(speed) > _MOVES * float(np.max(np.abs(speed)))
    by_friction = _by_motion(actuator, motor, rod, moves)
    by_load = _by_load(record, smoother, motor, rod, np.where(moves, np.sign(speed), 0.0))
    found = min((by_friction, *by_load), key=lambda one: one.left_mm)
    return found if found.left_mm**2 <= (1.0 - _EXPLAINED) * about else None


def _by_motion(actuator: Actuator, motor: Reals, rod: Reals, moves: NDArray[np.bool_]) -> SeenPlay:
    """The width of a play behind which friction holds the rod, that fits best."""
    widest = min(_WIDEST * float(np.ptp(motor)), row_of(PLAY).upper)
    seen = rod[moves] - np.mean(rod[moves])

    def left(width: float) -> float:
        behind = library().play(*actuator.changed({PLAY: width}).arrays(), motor, float(motor[0]))
        moved = behind[moves] - np.mean(behind[moves])
        gain = float(moved @ seen) / float(moved @ moved) if np.any(moved) else 0.0
        return float(np.mean((seen - gain * moved) ** 2))

    widths = [0.0, *np.geomspace(_NARROWEST * widest, widest, _WIDTHS).tolist()]
    squares = [left(width) for width in widths]
    best = int(np.argmin(squares))
    ends = widths[max(best - 1, 0)], widths[min(best + 1, len(widths) - 1)]
    found = minimize_scalar(left, bounds=ends, method="bounded", options={"xatol": _NARROWEST * widest})
    width, square = (float(found.x), float(found.fun)) if found.fun < squares[best] else (widths[best], squares[best])
    return SeenPlay(width, math.sqrt(square))


def _by_load(record: AnyRecord, smoother: Smoother, motor: Reals, rod: Reals, turned: Reals) -> Iterator[SeenPlay]:
    """Widths of a play in which a load pushes the rod to a side, of which the rod's friction is a share: the recorded load, else one that grows along the way, as a spring's. `turned`: direction of
    the motor, 0 at rest, [rows]."""
    ahead, moves = motor - rod, turned != 0.0
    along = smoother.smooth(motor - np.mean(motor))
    measured = getattr(record, "disturbance_N", None)
    for load in (along, smoother.smooth(measured)) if measured is not None else (along,):
        columns = [np.ones_like(motor), motor, *([load] if load is not along else [])]
        for share in _SHARES * float(np.max(np.abs(load))):
            side = _held(np.sign(load + share * turned))
            matrix = np.column_stack([*columns, side])[moves]
            solved, *_ = np.linalg.lstsq(matrix, ahead[moves], rcond=None)
            yield SeenPlay(2.0 * abs(float(solved[-1])), math.sqrt(float(np.mean((ahead[moves] - matrix @ solved) ** 2))))


def _held(side: Reals) -> Reals:
    """The side of each row, that of the row before where there is none, [rows]."""
    last = np.maximum.accumulate(np.where(side != 0.0, np.arange(side.size), 0))
    return np.asarray(side[last])


def plays_seen(actuator: Actuator, records: Sequence[AnyRecord]) -> tuple[SeenPlay, ...]:
    """The play of each record that tells it."""
    return tuple(one for one in (play_seen(actuator, record) for record in records) if one)


def play_changes(machine: HealthyByBalance, before: Sequence[SeenPlay], records: Sequence[AnyRecord]) -> tuple[Change, ...]:
    """The play, where two healthy records or more (`before`) and one of today tell it; nothing where they do not."""
    if len(before) < 2:
        return ()
    after = plays_seen(machine.actuator, records)
    if not after:
        return ()
    (healthy, shown), (today, _) = _told(before), _told(after)
    limit = max(machine.times * shown, _LEAST_TIMES * _least(healthy, before)) * math.sqrt(1.0 + 1.0 / len(before))
    change = today - healthy
    std = math.hypot(_std_of_mean(before), _std_of_mean(after), _FORM * change)
    return (Change(PLAY, healthy, today, std, limit, abs(change) > limit),)


def play_value(given: Actuator, seen: Sequence[SeenPlay]) -> tuple[BaseValue, ...]:
    """The play as records show it, beside what the actuator's file states; nothing where none has both positions."""
    if not seen:
        return ()
    width, _ = _told(seen)
    by_import = not given[PLAY] > 0.0 or given.remark(PLAY) in STARTS
    return (BaseValue(PLAY, given[PLAY], by_import, width, math.hypot(_std_of_mean(seen), _FORM * width), "", False, math.nan, math.nan),)


def _told(seen: Sequence[SeenPlay]) -> tuple[float, float]:
    """Mean width, and how the records differ; those of which it leaves less count for more."""
    widths, weights = np.array([one.width_mm for one in seen]), np.array([one.left_mm**-2 if one.left_mm > 0.0 else 1.0 for one in seen])
    mean = float(np.average(widths, weights=weights))
    spread = float(np.average((widths - mean) ** 2, weights=weights))
    return mean, math.sqrt(spread * len(seen) / (len(seen) - 1)) if len(seen) > 1 else 0.0


def _least(width: float, seen: Sequence[SeenPlay]) -> float:
    """By how much records differ at least."""
    return max(_LEAST * width, _OF_LEFT * min(one.left_mm for one in seen))


def _std_of_mean(seen: Sequence[SeenPlay]) -> float:
    """How far the mean of these may be off: as they differ, and no less than records do."""
    width, shown = _told(seen)
    return max(shown, _least(width, seen)) / math.sqrt(len(seen))


def _motor_mm(actuator: Actuator, record: AnyRecord) -> Reals | None:
    """The motor's position at the rod, mm, as an encoder recorded it; None where there is none: one integrated from a speed drifts by as much as a play is wide."""
    if record.motor_position_mm is not None:
        return record.motor_position_mm
    angle, lead = getattr(record, "motor_angle_rad", None), train_of(actuator).mm_per_rad
    return None if angle is None or lead is None else np.asarray(lead * angle)
