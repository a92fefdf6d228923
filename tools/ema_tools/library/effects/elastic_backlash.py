"""Friction and mass behind a play with elastic ends."""

from ema_tools.library import measurements
from ema_tools.library.record import EffectRecord, Onboard, Slight, Typical
from ema_tools.library.torques import Bending, shares_of_stroke

EFFECT = EffectRecord(
    shows="mechanical balance: after each reversal a way without dry friction, then its rise; hysteresis of torque against position with a flat floor",
    typical=Typical({"gap_mm": 0.1, "contact_mm": 0.1}, "usual: 0.03 to 10 mm, contacts of 0.1 to 3 mm"),
    # at two sizes, as what it shows does not grow in proportion
    slight=Slight(0.003, free=({"gap_mm": 0.001, "contact_mm": 0.003}, {"gap_mm": 0.003, "contact_mm": 0.003})),
    independent_shapes=4,
    shapes={"contact_mm": (0.01, 0.03, 0.1, 0.3)},
    bending=Bending(
        shares_of_stroke((0.0005, 0.002, 0.008, 0.03, 0.1)), beside={"contact_mm": shares_of_stroke((0.001, 0.004, 0.016, 0.06))}
    ),
    # without a gap it is nearly the same
    special_case="presliding",
    separated_by=(measurements.OUTSIDE_FORCE, measurements.BREAK_AWAY),
    onboard=Onboard({"contact_mm": (0.1,)}),
)
