"""How many shapes of an effect are tried, and what the best of them explains of pure noise."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

# Shapes that are as good as independent of each other: among so many the best one explains some noise.
_TRIED: Mapping[str, int] = {
    "cogging_torque": 150,
    "torque_ripple": 90,
    "pitch_ripple": 4,
    "stribeck_friction": 6,
    "jam_spot": 60,
    "transmission_compliance": 3,
    "presliding": 2,
}


def penalty(effects: Collection[str]) -> float:
    """What the free choice of these effects' shapes explains of pure noise, in units of cost."""
    return float(sum(2.0 * np.log(_TRIED.get(effect, 1)) for effect in effects))
