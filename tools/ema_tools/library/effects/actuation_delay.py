"""A drive that is late."""

from ema_tools.library import measurements
from ema_tools.library.record import EffectRecord, Slight, Typical
from ema_tools.library.torques import Bending

EFFECT = EffectRecord(
    shows="electrical balance: the applied voltage comes late, so the drive torque misses a share of the jerk; the top third of the frequencies, spikes at steps of the command",
    typical=Typical({"delay_s": 0.0001}, "usual: 0.1 to 3 ms"),
    slight=Slight(5e-6),
    bending=Bending((5e-5, 1e-4, 2e-4, 3.5e-4, 5e-4, 7e-4, 1e-3, 1.5e-3, 2e-3, 3e-3), of_drive=True),
    separated_by=(measurements.CONTROLLERS_CLOCK, measurements.TAP_THE_ROD),
)
