"""Dry friction behind a play whose ends are springs: nothing is felt inside the gap, friction slides once a spring carries all of it.

Source: M. Nordin and P.-O. Gutman, Controlling mechanical systems with backlash - a survey, Automatica 38 (2002).

The memory is how far the shaft is ahead of what it drives, mm from the middle of the gap. `direction`: sign of the speed.
"""

import math
from typing import Any

from ema_tools.base.compiled import compiled

EXAMPLE = {"gap_mm": 0.1, "contact_mm": 0.3}


@compiled
def share(effect: Any, memory: float) -> float:
    """Share of dry friction that the springs carry, -1 to 1."""
    pressed = max(abs(memory) - 0.5 * effect.gap_mm, 0.0)
    return math.copysign(min(pressed / effect.contact_mm, 1.0), memory)


@compiled
def slope_per_rad(effect: Any, memory: float, direction: int, lead_mm_per_rad: float) -> float:
    """Change of the memory per turn of the shaft: none once what it drives slides along."""
    slides = memory * direction >= 0.5 * effect.gap_mm + effect.contact_mm
    return 0.0 if slides else lead_mm_per_rad


@compiled
def fastest_rate_per_s(effect: Any, level_per_inertia: float, speed_rad_s: float, lead_mm_per_rad: float) -> float:
    """Largest rate of change, for the choice of the integration step: the shaft on the spring, and its passing through contact and gap at `speed_rad_s`."""
    shortest_rad = min(effect.contact_mm, effect.contact_mm + effect.gap_mm) / lead_mm_per_rad
    return max(math.sqrt(level_per_inertia * lead_mm_per_rad / effect.contact_mm), speed_rad_s / shortest_rad)
