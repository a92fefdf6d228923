"""Friction that grows with the transmitted torque and falls with speed."""

from ema_tools.library import measurements
from ema_tools.library.record import EffectRecord, Onboard, Slight, Typical

EFFECT = EffectRecord(
    shows="mechanical balance: extra friction around a reversal that grows with the torque of the motor; low speeds under load",
    typical=Typical({"ratio": 0.05, "speed_rad_s": 5.0}, "usual: 0.02 to 0.2 Nm/Nm"),
    slight=Slight(0.004),
    independent_shapes=6,
    # it reads the drive, and beside refitted base values it stands in for any drag
    in_balance=False,
    shapes={"speed_rad_s": (4.0, 15.0), "shape": (1.0,)},
    separated_by=(measurements.OUTSIDE_FORCE, measurements.BREAK_AWAY),
    onboard=Onboard({"speed_rad_s": (3.0, 12.0), "shape": (1.0,)}),
)
