"""The rod as a mass on spring and damper behind the play."""

from ema_tools.library import measurements
from ema_tools.library.record import EffectRecord, Onboard, Slight, Typical

EFFECT = EffectRecord(
    shows="kinematic balance: rod minus motor position in step with the acceleration of the rod, growing with the square of the frequency",
    typical=Typical({"period_s": 0.02, "mass_kg": 2.0}, "usual: 20 to 100 Hz, 2 to 20 kg; 50 Hz"),
    slight=Slight(5e-4),
    independent_shapes=3,
    shapes={"mass_kg": (2.0, 6.0, 20.0), "damping_ratio": (0.06,)},
    first=(0.0022, 0.0028, 0.0035, 0.0045, 0.006, 0.008, 0.011, 0.015, 0.02, 0.03, 0.05),
    power=2.0,
    separated_by=(measurements.OUTSIDE_FORCE, measurements.GAUGE, measurements.TAP_THE_ROD),
    onboard=Onboard({"mass_kg": (2.0, 6.0, 20.0), "damping_ratio": (0.06,)}, sizes=(0.01, 0.02)),
)
