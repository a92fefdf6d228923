"""A supply with inner resistance."""

from ema_tools.library import measurements
from ema_tools.library.record import EffectRecord, Typical

EFFECT = EffectRecord(
    shows="electrical balance: voltage with the sign of the output that grows with output times current; only at large currents",
    typical=Typical({"resistance_ohm": 0.05}, "usual: 0.05 to 0.3 ohm"),
    separated_by=(measurements.BUS_AND_WINDING,),
)
