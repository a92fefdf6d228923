"""An error of the rod sensor that was learned."""

from ema_tools.library.record import EffectRecord, LearnedKind

EFFECT = EffectRecord(
    shows="kinematic balance: whatever error of the rod sensor repeats against the axis of the table",
    learned=LearnedKind("kinematic", frozenset({0, 1, 2, 3})),
)
