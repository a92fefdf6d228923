"""Block 4, gearbox: motor angle to rod travel, and what the load torque loses on its way to the motor.

Equations: docs/DESIGN.md, "4. Gearbox".
"""

from __future__ import annotations

from typing import Any

from ema_tools.base.compiled import compiled
from reference_model.elementary import TWO_PI


@compiled
def lead_mm_per_rad(gearbox: Any, screw: Any) -> float:
    """Rod travel per motor angle."""
    return screw.lead_mm / (TWO_PI * gearbox.ratio)


@compiled
def friction_Nm(gearbox: Any, load_Nm: float, direction: int) -> float:
    """Dry friction that the load torque adds to a shaft that slides, or is about to, in `direction` (1 is extension)."""
    if load_Nm * direction > 0.0:
        return (1.0 / gearbox.efficiency - 1.0) * abs(load_Nm)
    return (1.0 - gearbox.efficiency) * abs(load_Nm)
