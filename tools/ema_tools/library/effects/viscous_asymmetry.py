"""Viscous friction that differs between the directions."""

from ema_tools.library import measurements
from ema_tools.library.record import EffectRecord, Slight, Typical

EFFECT = EffectRecord(
    shows="mechanical balance: torque that grows with the amount of speed and not with its sign; the upper two thirds of the frequencies",
    typical=Typical({"asymmetry": 0.05}, "usual: 5 to 60 %"),
    slight=Slight(0.006),
    separated_by=(measurements.CONSTANT_SPEEDS,),
)
