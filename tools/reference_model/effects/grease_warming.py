"""Grease that softens while the record runs: (level + D w) (1 - fall z), time dz/dt = 1 - z.

Source: L. Simoni et al., Friction modeling with temperature effects for industrial robot manipulators (2015). `memory` is z.
"""

from typing import Any

from ema_tools.base.compiled import compiled

EXAMPLE = {"fall": 0.3, "time_s": 1.5}


@compiled
def change(effect: Any, memory: float) -> float:
    """Relative change of dry and viscous friction."""
    return -effect.fall * memory


@compiled
def rate_per_s(effect: Any, memory: float, heat_W: float) -> float:
    """Rate of the memory."""
    return (1.0 - memory) / effect.time_s
