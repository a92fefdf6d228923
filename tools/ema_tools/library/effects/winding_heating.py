"""A warm winding."""

from ema_tools.library import measurements
from ema_tools.library.record import ConfoundedParameter, EffectRecord, Typical

EFFECT = EffectRecord(
    shows="electrical balance: voltage in proportion to the current; the position shows it where currents are large, at the highest frequencies",
    typical=Typical({"rise_degC": 30.0}, "usual: 0 to 39 % of the resistance; estimate, 12 %"),
    confounded=ConfoundedParameter("motor.resistance_ohm", 1.0 / 0.00393),  # copper, IEC 60028, as the effect has it
    separated_by=(measurements.BUS_AND_WINDING,),
)
