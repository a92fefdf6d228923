"""Grease that softens as the record runs."""

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.library import measurements
from ema_tools.library.record import EffectRecord, Onboard, Slight, Typical
from ema_tools.library.torques import LocalTorque, Shape, States, shares_of_time


def _torque(states: States, shape: Shape) -> Reals:
    come = 1.0 - np.exp(-states.time_s / shape["time_s"])
    return come * (states.level_Nm * states.direction + states.viscous_Nm_s_per_rad * states.speed_rad_s)


EFFECT = EffectRecord(
    shows="mechanical balance: friction, dry and viscous alike, that falls from the record's start to its end, lap by lap",
    typical=Typical({"fall": 0.05, "time_s": 4.0}, "usual: 1 to 40 % within a record"),
    # what a running-in of seconds leaves of any machine's friction
    slight=Slight(0.003),
    independent_shapes=3,
    # friction that rises as a machine runs has another cause
    adds=True,
    local=LocalTorque(
        torque=_torque,
        tried={"time_s": (0.5, 1.0, 2.0, 4.0, 8.0, 20.0)},
        in_balance={"time_s": shares_of_time((0.03, 0.06, 0.12, 0.25, 0.5, 1.0, 2.0))},
    ),
    separated_by=(measurements.CONSTANT_SPEEDS,),
    onboard=Onboard({"time_s": (3.0,)}),
)
