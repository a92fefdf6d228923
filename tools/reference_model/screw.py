"""Block 5, ball screw: dry friction of a sliding and of a resting shaft, ends of travel, play.

Equations: docs/DESIGN.md, "5. Ball screw"; friction in Borello's form of Karnopp's model, play as a dead band.
"""

from __future__ import annotations

from typing import Any

from ema_tools.base.compiled import compiled


@compiled
def level_Nm(screw: Any, level_Nm: float, direction: int) -> float:
    """A level of dry friction in `direction` (1 is extension)."""
    return level_Nm * (1.0 + direction * screw.friction_asymmetry)


@compiled
def acceleration_rad_s2(screw: Any, inertia_kgm2: float, active_Nm: float, speed_rad_s: float, friction_Nm: float, share: float) -> float:
    """Acceleration of a shaft that moves; `active_Nm` is every torque but viscous and dry friction.

    `share`: part of the level of dry friction that acts against extension: -1 or 1 while the contact slides.
    """
    return (active_Nm - screw.viscous_Nm_s_per_rad * speed_rad_s - share * friction_Nm) / inertia_kgm2


@compiled
def leaves_rest(active_Nm: float, static_Nm: float, end: int) -> int:
    """Direction in which a resting shaft breaks away, or 0; an end of travel (`end` -1 or 1) holds against torques outward."""
    if active_Nm > static_Nm and end != 1:
        return 1
    if active_Nm < -static_Nm and end != -1:
        return -1
    return 0


@compiled
def hits_end(screw: Any, motor_mm: float, direction: int) -> bool:
    """Whether a shaft that slides in `direction` has passed the end of travel."""
    return motor_mm * direction > screw.travel_mm


@compiled
def play_contact(screw: Any, motor_mm: float, play_mm: float, direction: int) -> bool:
    """Whether the motor, sliding in `direction`, has come to push the output of the play; without play it always does."""
    return screw.blk_mm == 0.0 or (motor_mm - play_mm) * direction > 0.5 * screw.blk_mm


@compiled
def play_output_mm(screw: Any, motor_mm: float, play_mm: float, side: int) -> float:
    """Output of the play: at its distance behind the motor in contact (`side` -1 or 1), else where it was."""
    if screw.blk_mm == 0.0:
        return motor_mm
    if side == 0:
        return play_mm
    return motor_mm - side * 0.5 * screw.blk_mm
