"""A contact that stretches before it slides: dry friction * z, dz/dtheta = (1 - z sgn w) / stretch.

Source: P. R. Dahl, A solid friction model, Aerospace Corp. TOR-158 (1968).

The memory is z: -1 or 1 once the contact slides. `direction`: sign of the speed.
"""

import math
from typing import Any

from ema_tools.base.compiled import compiled

EXAMPLE = {"stretch_rad": 0.05}


@compiled
def share(effect: Any, memory: float) -> float:
    """Share of dry friction that is carried."""
    return memory


@compiled
def slope_per_rad(effect: Any, memory: float, direction: int, lead_mm_per_rad: float) -> float:
    """Change of the memory per turn of the shaft."""
    return (1.0 - memory * direction) / effect.stretch_rad


@compiled
def fastest_rate_per_s(effect: Any, level_per_inertia: float, speed_rad_s: float, lead_mm_per_rad: float) -> float:
    """Largest rate of change, for the choice of the integration step: the contact as a spring, and its slipping at `speed_rad_s`."""
    return max(math.sqrt(level_per_inertia / effect.stretch_rad), speed_rad_s / effect.stretch_rad)
