"""Friction that falls with speed."""

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.library import measurements
from ema_tools.library.record import EffectRecord, Onboard, Slight, Typical
from ema_tools.library.torques import LocalTorque, Shape, States, shares_of_speed


def _torque(states: States, shape: Shape) -> Reals:
    return -(states.direction * np.exp(-((np.abs(states.speed_rad_s) / shape["speed_rad_s"]) ** shape["shape"])))


EFFECT = EffectRecord(
    shows="mechanical balance: extra friction in the moments around a reversal, strongest in the lowest third of the frequencies",
    typical=Typical({"rise": 0.1, "speed_rad_s": 5.0}, "usual: a break-away of 1.1 to 2 times the sliding level, speeds of 2 to 50 rad/s"),
    slight=Slight(0.008),
    independent_shapes=6,
    local=LocalTorque(
        torque=_torque,
        tried={"speed_rad_s": (2.0, 4.0, 7.0, 12.0, 20.0, 32.0, 50.0), "shape": (1.0, 2.0)},
        in_balance={"speed_rad_s": shares_of_speed((0.01, 0.02, 0.04, 0.08, 0.15, 0.25, 0.4, 0.6)), "shape": (0.5, 1.0, 2.0)},
        of_level=True,
        falls=True,
    ),
    separated_by=(measurements.OUTSIDE_FORCE, measurements.BREAK_AWAY),
    onboard=Onboard({"speed_rad_s": (3.0, 8.0, 20.0), "shape": (1.0, 2.0)}),
)
