"""A spring at the rod."""

from ema_tools.library import measurements
from ema_tools.library.record import EffectRecord, Slight, Typical

EFFECT = EffectRecord(
    shows="mechanical balance: torque in proportion to the rod's position; the lowest frequencies, where little else acts",
    typical=Typical({"stiffness_Nm_per_mm": 0.004}, "usual: 0.004 to 0.1 Nm/mm"),
    # per mm
    slight=Slight(0.001, of_friction=True),
    separated_by=(measurements.LONG_STROKE,),
)
