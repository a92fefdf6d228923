"""Torque constant and back-EMF that vary with the motor angle."""

from ema_tools.library.record import EffectRecord, Onboard, Slight, Typical
from ema_tools.library.torques import PERIODS_PER_TURN, PeriodicTorque, turn

EFFECT = EffectRecord(
    shows="mechanical and electrical balance: repeats with the motor's angle and grows with the current, so at accelerations",
    typical=Typical({"ratio": 0.02, "periods": 6.0, "phase_rad": 0.5}, "usual: 2 to 7 %; the phase is any"),
    slight=Slight(0.002),
    independent_shapes=90,
    periodic=PeriodicTorque(
        angle=turn,
        torque=lambda states: states.torque_constant_Nm_per_A * states.current_A,
        voltage=lambda states: -states.back_emf_V_s_per_rad * states.speed_rad_s,
        cosine=True,
        periods=tuple(range(1, 49)),
        in_balance=PERIODS_PER_TURN,
        simulated_at=0.02,
    ),
    onboard=Onboard({"periods": (6.0, 12.0, 18.0, 24.0, 30.0)}),
)
