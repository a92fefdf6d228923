"""A feedback that is late."""

from ema_tools.library import measurements
from ema_tools.library.record import EffectRecord, Slight, Typical

EFFECT = EffectRecord(
    shows="controller balance: position error in proportion to speed; the top third of the frequencies, a phase that grows with frequency",
    typical=Typical({"delay_s": 0.0002}, "usual: 0.2 to 5 ms"),
    slight=Slight(2.5e-5),
    separated_by=(measurements.CONTROLLERS_CLOCK, measurements.TAP_THE_ROD),
)
