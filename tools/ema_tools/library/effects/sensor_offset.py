"""Zero shift of the rod sensor."""

from ema_tools.library import measurements
from ema_tools.library.record import ConfoundedParameter, EffectRecord, Typical

EFFECT = EffectRecord(
    shows="kinematic balance: rod minus motor position shifted by a constant, the same at all frequencies",
    typical=Typical({"offset_mm": 0.01}, "usual: up to 0.1 mm; estimate, a tenth of that"),
    confounded=ConfoundedParameter("encoder.rod_offset_mm", 1.0),
    separated_by=(measurements.GAUGE,),
)
