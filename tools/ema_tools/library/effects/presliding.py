"""A contact that stretches before it slides."""

from ema_tools.library import measurements
from ema_tools.library.record import EffectRecord, Slight, Typical
from ema_tools.library.torques import Bending

EFFECT = EffectRecord(
    shows="mechanical balance: the first hundredths of a radian after each reversal, at all frequencies; nothing while sliding",
    typical=Typical({"stretch_rad": 0.02}, "usual: 0.02 to 0.1 rad"),
    # at two sizes, as what it shows does not grow in proportion
    slight=Slight(0.003, free=({"stretch_rad": 0.001}, {"stretch_rad": 0.003})),
    independent_shapes=2,
    usual="nearly every contact yields a little before it slides, so by itself it is how the machine is and no defect",
    bending=Bending((0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5)),
    separated_by=(measurements.OUTSIDE_FORCE, measurements.BREAK_AWAY),
)
