"""Shear-thinning grease."""

from ema_tools.library import measurements
from ema_tools.library.record import EffectRecord, Slight, Typical

EFFECT = EffectRecord(
    shows="mechanical balance: torque that grows with the root of speed; middle speeds",
    typical=Typical({"drag_Nm_per_sqrt_rad_s": 0.001}, "usual: 0.001 to 0.01 Nm/sqrt(rad/s)"),
    # a bend of the law of friction: 0.8 % at 100 rad/s, where it flattens
    slight=Slight(0.008 / 10.0, of_friction=True),
    adds=True,
    separated_by=(measurements.CONSTANT_SPEEDS,),
)
