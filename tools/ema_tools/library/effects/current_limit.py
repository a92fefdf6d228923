"""A drive that limits the current."""

from ema_tools.library.record import BelowPeak, EffectRecord

EFFECT = EffectRecord(
    shows="electrical balance and the current itself: nothing below a level, a cut at it; highest frequencies and starts",
    below_peak=BelowPeak(tried=(0.995, 0.98, 0.95, 0.9, 0.8, 0.65, 0.5, 0.4, 0.35, 0.3), typical=0.95, onboard=(0.95, 0.85)),
)
