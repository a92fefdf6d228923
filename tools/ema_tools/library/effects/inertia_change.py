"""Added or removed mass."""

from ema_tools.library import measurements
from ema_tools.library.record import ConfoundedParameter, EffectRecord, Typical

EFFECT = EffectRecord(
    shows="mechanical balance: torque in proportion to acceleration; the top third of the frequencies",
    typical=Typical({"change": 0.05}, "usual: 5 to 30 %"),
    confounded=ConfoundedParameter("screw.inertia_kgm2", 1.0),
    separated_by=(measurements.BACK_EMF, measurements.TAP_THE_ROD),
)
