"""A constant torque against extension."""

from ema_tools.library import measurements
from ema_tools.library.record import EffectRecord, Typical

EFFECT = EffectRecord(
    shows="mechanical balance: a constant torque at all frequencies; the integrator holds it, so the position hardly shows it",
    typical=Typical({"torque_Nm": 0.005}, "usual: 0 to 0.1 Nm; estimate, a twentieth of the upper end"),
    base_value="screw.load_torque_Nm",
    inseparable=("coulomb_asymmetry",),
    separated_by=(measurements.TURN_OVER,),
)
