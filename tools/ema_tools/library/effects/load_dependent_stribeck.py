"""Friction that grows with the transmitted torque and falls with speed."""

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.library import measurements
from ema_tools.library.record import EffectRecord, Onboard, Slight, Typical
from ema_tools.library.torques import LocalTorque, Shape, States


def _torque(states: States, shape: Shape) -> Reals:
    torque_Nm = np.abs(states.torque_constant_Nm_per_A * states.current_A)
    return -(states.direction * torque_Nm * np.exp(-((np.abs(states.speed_rad_s) / shape["speed_rad_s"]) ** shape["shape"])))


EFFECT = EffectRecord(
    shows="mechanical balance: extra friction around a reversal that grows with the torque of the motor; low speeds under load",
    typical=Typical({"ratio": 0.05, "speed_rad_s": 5.0}, "usual: 0.02 to 0.2 Nm/Nm"),
    slight=Slight(0.004),
    independent_shapes=6,
    # it reads the drive, and beside refitted base values it stands in for any drag
    in_balance=False,
    # one that falls off only beyond the speeds of the motion
    special_case="load_dependent_friction",
    local=LocalTorque(torque=_torque, tried={"speed_rad_s": (2.0, 4.0, 7.0, 12.0, 20.0, 32.0, 50.0), "shape": (1.0, 2.0)}),
    separated_by=(measurements.OUTSIDE_FORCE, measurements.BREAK_AWAY),
    onboard=Onboard({"speed_rad_s": (3.0, 12.0), "shape": (1.0,)}),
)
