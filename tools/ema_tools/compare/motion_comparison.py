"""A model against a record of a machine whose controller is not known: the mechanical balance, and by what its residual goes. Nothing is simulated."""

from __future__ import annotations

import math

import numpy as np

from ema_tools.balances.mechanical import mechanical, quiet_smoother
from ema_tools.balances.motion import motion_of
from ema_tools.base.errors import InputError
from ema_tools.base.noise import white_noise
from ema_tools.compare.comparison import BalanceError, Comparison, State, divided, even_parts, reversal_parts
from ema_tools.compare.motion_validity import judge_motion
from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import DRIVES, MOTIONS, MotionRecord

_MOVING = 0.01  # of the largest speed: slower counts as resting [judgement]
_NOT_SIMULATED = "without the controller nothing is simulated"


def compare_motion(actuator: Actuator, record: MotionRecord) -> Comparison:
    """The mechanical balance of a record. Raises InputError for one that has none, or cannot answer."""
    gate = judge_motion(actuator, record)
    for remark in gate.remarks:
        if remark.severity == "blocks":
            raise InputError(f"{record.file}: {remark.text}: {remark.next}")
    smoother = quiet_smoother(actuator, record)
    found, noisy = mechanical(actuator, record, smoother), mechanical(actuator, _with_own_noise(record), smoother)
    noise = float(np.sqrt(np.mean((noisy.residual - found.residual) ** 2)))
    error = BalanceError(found.unit, found.rms, found.relative_percent, noise, 0.0, found.resting_percent)
    others = {
        name: BalanceError("", math.nan, math.nan, math.nan, math.nan, math.nan, _NOT_SIMULATED)
        for name in ("electrical", "kinematic", "controller")
    }
    places = divided("mechanical balance", found, _states(actuator, record), record.first_time_s)
    return Comparison(record.file, {}, {"mechanical": error, **others}, tuple(sorted(places, key=lambda place: -place.share)), None)


def _with_own_noise(record: MotionRecord) -> MotionRecord:
    """The record with as much white noise again as it seems to hold."""
    random = np.random.default_rng(1)
    signals = [name for name in (*MOTIONS, *DRIVES) if name in record.present]
    return record.with_columns(
        {name: record.recorded(name) + random.normal(0.0, white_noise(record.recorded(name)), record.rows) for name in signals}
    )


def _states(actuator: Actuator, record: MotionRecord) -> list[State]:
    """Time, speed, the place within a turn of the motor where it is known, direction, time since the last reversal."""
    motion, period_s = motion_of(actuator, record, quiet_smoother(actuator, record)), record.period_s
    speed = motion.speed_rad_s
    direction = np.sign(speed) * (np.abs(speed) > _MOVING * float(np.max(np.abs(speed), initial=0.0)))
    states = [
        even_parts("time", record.time_s, "s", period_s),
        even_parts("speed", np.abs(speed), "rad/s", period_s),
        even_parts("place in a motor turn", np.mod(motion.angle_rad, 2.0 * math.pi), "rad", period_s) if motion.placed else None,
        *reversal_parts(direction, period_s),
    ]
    return [state for state in states if state is not None]
