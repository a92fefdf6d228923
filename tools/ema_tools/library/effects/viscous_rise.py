"""Cold grease."""

from ema_tools.library import measurements
from ema_tools.library.record import ConfoundedParameter, EffectRecord, Typical

EFFECT = EffectRecord(
    shows="mechanical balance: torque in proportion to speed; the upper frequencies",
    typical=Typical({"rise": 0.5}, "usual: 1.5 to 10 times the damping"),
    confounded=ConfoundedParameter("screw.viscous_Nm_s_per_rad", 1.0),
    separated_by=(measurements.CONSTANT_SPEEDS,),
)
