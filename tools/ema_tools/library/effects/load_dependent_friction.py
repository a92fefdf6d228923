"""Dry friction that grows with the transmitted torque."""

from ema_tools.library import measurements
from ema_tools.library.record import EffectRecord, Slight, Typical

EFFECT = EffectRecord(
    shows="mechanical balance: friction that grows with the torque of the motor, so with acceleration; the top third of the frequencies",
    typical=Typical({"ratio": 0.02}, "usual: 0.02 to 0.2 Nm/Nm"),
    slight=Slight(0.001),
    separated_by=(measurements.BACK_EMF,),
)
