"""What the best of an effect's shapes explains of pure noise."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from ema_tools.library.registry import record_of


def penalty(effects: Collection[str]) -> float:
    """What the free choice of these effects' shapes explains of pure noise, in units of cost."""
    return float(sum(2.0 * np.log(record_of(effect).independent_shapes) for effect in effects))
