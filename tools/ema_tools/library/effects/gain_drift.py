"""A position gain that has drifted."""

from ema_tools.library import measurements
from ema_tools.library.record import ConfoundedParameter, EffectRecord, Typical

EFFECT = EffectRecord(
    shows="controller balance alone: output in proportion to the position error; the other balances stay clean",
    typical=Typical({"drift": 0.02}, "usual: 2 to 50 %"),
    confounded=ConfoundedParameter("control.kp_per_m", 1.0),
    separated_by=(measurements.BUS_AND_WINDING, measurements.CONTROLLERS_OUTPUT),
)
