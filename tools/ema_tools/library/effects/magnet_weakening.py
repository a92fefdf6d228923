"""Magnets that lost flux."""

from ema_tools.library import measurements
from ema_tools.library.record import ConfoundedParameter, EffectRecord, Typical

EFFECT = EffectRecord(
    shows="mechanical and electrical balance at once: less torque per current and less back-EMF per speed, by the same share",
    typical=Typical({"loss": 0.02}, "usual: 0 to 10 %; estimate, a fifth of the upper end"),
    confounded=ConfoundedParameter("motor.torque_constant_Nm_per_A", -1.0),
    separated_by=(measurements.BUS_AND_WINDING, measurements.BACK_EMF),
)
