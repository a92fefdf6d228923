"""Dry friction that was learned."""

from ema_tools.library.record import EffectRecord, LearnedKind

EFFECT = EffectRecord(
    shows="mechanical balance: whatever change of the friction level repeats against the axis of the table",
    learned=LearnedKind("mechanical", frozenset({0, 1, 2, 3, 4}), friction=True),
)
