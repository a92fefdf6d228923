"""Turbulent drag on the rotor."""

from ema_tools.library import measurements
from ema_tools.library.record import EffectRecord, Slight, Typical

EFFECT = EffectRecord(
    shows="mechanical balance: torque that grows with the square of speed; top speeds, the highest frequencies alone",
    typical=Typical({"drag_Nm_s2_per_rad2": 1e-07}, "usual: 1e-7 to 2e-6 Nm s2/rad2"),
    # a bend of the law of friction: 0.65 % at 200 rad/s, where it steepens
    slight=Slight(0.0065 / 200.0**2, of_friction=True),
    adds=True,
    separated_by=(measurements.CONSTANT_SPEEDS,),
)
