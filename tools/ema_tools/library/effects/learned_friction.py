"""Dry friction that was learned."""

from ema_tools.library.record import EffectRecord, LearnedKind
from ema_tools.library.torques import AlongStroke

_WAVES = 6  # over the stroke: a bump of a tenth of it is still seen, and some passes tell that many apart [judgement]

EFFECT = EffectRecord(
    shows="mechanical balance: whatever change of the friction level repeats against the axis of the table; over the position it is position_friction, which the balance of forces seeks",
    learned=LearnedKind("mechanical", frozenset({0, 1, 2, 3, 4}), friction=True),
    along=AlongStroke(_WAVES, "position_friction"),
    special_case="jam_spot",
)
