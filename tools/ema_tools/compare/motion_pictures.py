"""What is drawn of records of a machine whose controller is not known: torque against speed, over one turn of the motor, and its loop at reversals, of a record and of a model."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ema_tools.balances.balance import Balance
from ema_tools.balances.effects import adjusted
from ema_tools.balances.mechanical import best_placed, known_torque_Nm, mechanical, quiet_smoother
from ema_tools.balances.motion import Motion, motion_of, train_of
from ema_tools.base.arrays import Reals
from ema_tools.compare.axes import Axis
from ema_tools.compare.localisation import binned, short
from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import MotionRecord
from ema_tools.results import localisation as picture

_POINTS_MAX = 1500  # of a picture [layout]
_TURN_BINS = 48  # of one turn [layout]
_REVERSALS = 0.02  # of the largest speed: beyond it to both sides, a record reverses [judgement]


@dataclass(frozen=True)
class _Seen:
    """One record at the samples of its balance, each [samples]: torque without inertia and what the model leaves of it, Nm; speed, acceleration and angle of the motor."""

    torque: Reals
    residual: Reals
    speed: Reals
    angle: Reals
    placed: bool


def motion_pictures(actuator: Actuator, records: Sequence[MotionRecord]) -> picture.Pictures:
    """Pictures of records under a model. Raises MissingSignal."""
    seen = [_seen(actuator, record) for record in records]
    torque, residual, speed = (np.concatenate([getattr(one, name) for one in seen]) for name in ("torque", "residual", "speed"))
    axis = Axis("speed", "rad/s", speed)
    measured, model = binned(axis, torque), binned(axis, torque - residual)
    every = max(1, torque.size // _POINTS_MAX)
    points = picture.Points(short(speed[::every]), short(torque[::every]))
    against = picture.TorqueSpeed("Nm", "rad/s", "model", points, measured.drawn() if measured else None, model.drawn() if model else None)
    return picture.Pictures((), {}, against, picture.Hysteresis(None, _loop(actuator, seen)), _turn(actuator, seen))


def _seen(actuator: Actuator, record: MotionRecord) -> _Seen:
    smoother = quiet_smoother(actuator, record)
    begun = best_placed(actuator, record, smoother)
    assert isinstance(begun, MotionRecord)
    balance: Balance = mechanical(actuator, begun, smoother)
    motion: Motion = motion_of(actuator, begun, smoother)
    inertia = adjusted(actuator)["screw.inertia_kgm2"] * motion.acceleration_rad_s2 + known_torque_Nm(actuator, begun, smoother)
    # where the model's waves were aligned with it, the place is as good as known
    placed = motion.placed or begun is not record
    torque = balance.measured - smoother.decimated(inertia)
    return _Seen(torque, balance.residual, smoother.kept(motion.speed_rad_s), smoother.kept(motion.angle_rad), placed)


def _turn(actuator: Actuator, seen: Sequence[_Seen]) -> picture.TurnTorque | None:
    """Torque over one turn: of all records whose place is known, else of the one that turns most."""
    there = [one for one in seen if one.placed] or sorted(seen, key=lambda one: -float(np.ptp(one.angle)))[:1]
    if max(float(np.ptp(one.angle)) for one in there) < 2.0 * math.pi:
        return None
    angle, torque, residual, speed = (
        np.concatenate([getattr(one, name) for one in there]) for name in ("angle", "torque", "residual", "speed")
    )
    values = adjusted(actuator)
    dry = values["screw.dynamic_ratio"] * values["screw.csj_Nm"]
    base = values["screw.viscous_Nm_s_per_rad"] * speed + dry * np.sign(speed) + values["screw.load_torque_Nm"]
    axis = Axis("motor angle", "rad", np.mod(angle, 2.0 * math.pi))
    measured, model = binned(axis, torque - base, _TURN_BINS), binned(axis, torque - residual - base, _TURN_BINS)
    return picture.TurnTorque("Nm", "rad", measured.drawn(), model.drawn()) if measured and model else None


def _loop(actuator: Actuator, seen: Sequence[_Seen]) -> picture.Loop | None:
    """Torque without inertia over the way, of the record that reverses most often; None where none does."""

    def reversals(one: _Seen) -> int:
        moving = np.sign(one.speed) * (np.abs(one.speed) > _REVERSALS * float(np.max(np.abs(one.speed), initial=0.0)))
        sides = moving[moving != 0.0]
        return int(np.sum(sides[1:] != sides[:-1]))

    most = max(seen, key=reversals)
    if not reversals(most):
        return None
    train = train_of(actuator)
    unit, scale = ("mm", train.mm_per_rad) if train.mm_per_rad else ("rad", 1.0)
    every = max(1, most.torque.size // _POINTS_MAX)
    way, torque, model = (short(values[::every]) for values in (scale * most.angle, most.torque, most.torque - most.residual))
    return picture.Loop("Nm", unit, picture.Points(way, torque), picture.Points(way, model))
