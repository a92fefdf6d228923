"""A voltage that was learned."""

from ema_tools.library.record import EffectRecord, LearnedKind

EFFECT = EffectRecord(
    shows="electrical balance: whatever voltage repeats against the axis of the table",
    learned=LearnedKind("electrical", frozenset({0, 1, 2, 3, 4})),
)
