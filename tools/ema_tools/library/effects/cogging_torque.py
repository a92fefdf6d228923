"""Torque of the magnets against the teeth, or of whatever turns with the motor or behind it."""

from ema_tools.library import measurements
from ema_tools.library.record import EffectRecord, Onboard, Slight, Typical
from ema_tools.library.torques import PERIODS_PER_TURN, PeriodicTorque, everywhere, turn

EFFECT = EffectRecord(
    shows="mechanical balance: a torque that repeats a whole number of times per motor turn, whatever the current; slow passages show it best",
    typical=Typical(
        {"amplitude_Nm": 0.0148, "periods": 12.0, "phase_rad": 0.7},
        "usual: 1 to 3 % of the stall torque, which is 1.48 Nm; the phase is any",
    ),
    slight=Slight(0.0075, of_friction=True),
    independent_shapes=150,
    periodic=PeriodicTorque(
        angle=turn,
        torque=everywhere,
        periods=PERIODS_PER_TURN,
        in_balance=PERIODS_PER_TURN,
        behind_gear=True,
        holds_at_rest=True,
        simulated_at=0.05,
    ),
    separated_by=(measurements.LONG_STROKE,),
    onboard=Onboard({"periods": (12.0, 18.0, 24.0, 30.0, 36.0, 48.0, 60.0, 72.0)}, larger=(300.0,)),
)
