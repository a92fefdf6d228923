"""Dry friction that differs between the directions."""

from ema_tools.library import measurements
from ema_tools.library.record import ConfoundedParameter, EffectRecord, Typical

EFFECT = EffectRecord(
    shows="mechanical balance: a constant torque whenever the shaft moves, at all frequencies, as a constant load makes it",
    typical=Typical({"asymmetry": 0.01}, "usual: 1 to 15 %"),
    confounded=ConfoundedParameter("screw.friction_asymmetry", 1.0),
    inseparable=("constant_load",),
    separated_by=(measurements.TURN_OVER,),
)
