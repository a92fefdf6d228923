"""What the best of an effect's shapes explains of pure noise, and what a general effect must explain beyond its special case."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from ema_tools.library.registry import record_of

_GENERAL = 9.0  # a general effect must explain so much more than its special case: three standard deviations [chance]


def penalty(effects: Collection[str]) -> float:
    """What the free choice of these effects' shapes explains of pure noise, in units of cost; more of an effect that is another one in a special case."""
    return float(
        sum(
            2.0 * np.log(record_of(effect).independent_shapes) + (_GENERAL if record_of(effect).special_case else 0.0) for effect in effects
        )
    )
