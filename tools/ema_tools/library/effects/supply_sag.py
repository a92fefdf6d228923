"""A bus voltage below its nominal value."""

from ema_tools.library import measurements
from ema_tools.library.record import ConfoundedParameter, EffectRecord, Typical

EFFECT = EffectRecord(
    shows="electrical balance: a fixed share of the applied voltage; most at the highest speeds",
    typical=Typical({"sag": 0.02}, "usual: 2 to 10 %"),
    confounded=ConfoundedParameter("drive.supply_V", -1.0),
    varies=0.001,  # as the voltage that is asked for shows a supply of another day [judgement]
    separated_by=(measurements.BUS_AND_WINDING, measurements.CONTROLLERS_OUTPUT),
)
