"""Dead time of the half bridges."""

from ema_tools.library.record import EffectRecord, Onboard, Slight, Typical

EFFECT = EffectRecord(
    shows="electrical balance: a voltage with the sign of the current, of equal height at all frequencies; with the position alone it looks like dry friction",
    typical=Typical({"drop_V": 0.1}, "usual: 0.1 to 1 V"),
    slight=Slight(0.01),
    today=0.1,
    shapes={"width_A": (0.05, 0.3)},
    onboard=Onboard({"width_A": (0.15,)}),
)
