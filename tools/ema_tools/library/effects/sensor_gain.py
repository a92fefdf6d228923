"""Scale error of the rod sensor."""

from ema_tools.library import measurements
from ema_tools.library.record import ConfoundedParameter, EffectRecord, Typical

EFFECT = EffectRecord(
    shows="kinematic balance: rod minus motor position in proportion to the position, the same at all frequencies",
    typical=Typical({"error": 0.001}, "usual: 0.1 to 1 %"),
    confounded=ConfoundedParameter("encoder.rod_gain_error", 1.0),
    separated_by=(measurements.GAUGE,),
)
