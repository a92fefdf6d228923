"""The rod as a mass on spring and damper behind the play: m x'' = k (y - x) + c (y' - x'), k = m (2 pi / period)^2.

Source: two-mass drive train, e.g. G. Ellis, Control System Design Guide (2012), ch. 19.

State in `memory[at]`, `memory[at + 1]`: rod position in mm and rod speed in mm/s. `play_mm`, `play_mm_s`: position and
speed of the play's output. `lead_m_per_rad`: rod travel per motor angle.
"""

import math
from typing import Any

import numpy as np

from ema_tools.base.compiled import compiled
from reference_model.elementary import TWO_PI

EXAMPLE = {"period_s": 0.025, "mass_kg": 8.0, "damping_ratio": 0.08}


@compiled
def _force_N(effect: Any, memory: np.ndarray, at: int, play_mm: float, play_mm_s: float) -> float:
    pulsation = TWO_PI / effect.period_s
    stiffness = effect.mass_kg * pulsation * pulsation
    damping = 2.0 * effect.damping_ratio * effect.mass_kg * pulsation
    return 1e-3 * (stiffness * (play_mm - memory[at]) + damping * (play_mm_s - memory[at + 1]))


@compiled
def shaft_inertia_kgm2(effect: Any, inertia_kgm2: float, lead_m_per_rad: float) -> float:
    """What is left at the shaft of the total inertia."""
    return inertia_kgm2 - effect.mass_kg * lead_m_per_rad * lead_m_per_rad


@compiled
def rest(effect: Any, memory: np.ndarray, at: int, start_mm: float) -> None:
    """Put the rod at rest at `start_mm`."""
    memory[at] = start_mm
    memory[at + 1] = 0.0


@compiled
def reaction_Nm(effect: Any, memory: np.ndarray, at: int, play_mm: float, play_mm_s: float, lead_m_per_rad: float) -> float:
    """Torque of the spring and the damper on the shaft."""
    return -lead_m_per_rad * _force_N(effect, memory, at, play_mm, play_mm_s)


@compiled
def rates(effect: Any, memory: np.ndarray, at: int, play_mm: float, play_mm_s: float, out: np.ndarray) -> None:
    """Rates of the state, written at the same places of `out`."""
    out[at] = memory[at + 1]
    out[at + 1] = 1e3 * _force_N(effect, memory, at, play_mm, play_mm_s) / effect.mass_kg


@compiled
def rod(effect: Any, memory: np.ndarray, at: int) -> tuple[float, float]:
    """Rod position in mm and rod speed in mm/s."""
    return memory[at], memory[at + 1]


@compiled
def fastest_rate_per_s(effect: Any, shaft_inertia: float, lead_m_per_rad: float) -> float:
    """Largest rate of change, for the choice of the integration step."""
    pulsation = TWO_PI / effect.period_s
    apparent = effect.mass_kg * lead_m_per_rad * lead_m_per_rad
    return pulsation * math.sqrt(1.0 + apparent / shaft_inertia) * (1.0 + 2.0 * effect.damping_ratio)
