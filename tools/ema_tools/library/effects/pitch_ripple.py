"""Dry friction that varies once per lead."""

from ema_tools.library import measurements
from ema_tools.library.record import EffectRecord, Slight, Typical
from ema_tools.library.torques import PeriodicTorque, against_motion, screw_turn

EFFECT = EffectRecord(
    shows="mechanical balance: friction that repeats with every lead of the screw; the phase is another one after the screw was referenced again",
    typical=Typical({"ratio": 0.03, "phase_rad": 0.7}, "usual: 3 to 10 % of the level; the phase is any"),
    # in both phases
    slight=Slight(0.004, free=({"ratio": 0.004, "phase_rad": 0.0}, {"ratio": 0.004, "phase_rad": 1.5707963})),
    independent_shapes=4,
    periodic=PeriodicTorque(angle=screw_turn, torque=against_motion, of_level=True),
    separated_by=(measurements.LONG_STROKE,),
)
