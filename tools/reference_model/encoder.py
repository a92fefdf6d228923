"""Block 6, encoder network: positions to the feedback of the position loop.

Equations: docs/DESIGN.md, "6. Encoder network".
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ema_tools.base.compiled import compiled


@compiled
def rod_sensor_mm(encoder: Any, rod_mm: float) -> float:
    """What the rod sensor reads."""
    return rod_mm * (1.0 + encoder.rod_gain_error) + encoder.rod_offset_mm


@compiled
def feedback_mm(encoder: Any, step_s: float, history_mm: np.ndarray, step: int) -> float:
    """Feedback at step `step`: delayed, then rounded.

    `history_mm`: readings of the chosen side, [k] at step k, filled up to `step`.
    """
    age = encoder.delay_s / step_s
    whole = math.floor(age)
    part = age - whole
    newest = step - int(whole)
    value = history_mm[max(newest, 0)]
    if part > 0.0:
        older = history_mm[max(newest - 1, 0)]
        oldest = history_mm[max(newest - 2, 0)]
        value = 0.5 * (1.0 - part) * (2.0 - part) * value + part * (2.0 - part) * older - 0.5 * part * (1.0 - part) * oldest
    if encoder.resolution_mm > 0.0:
        value = encoder.resolution_mm * math.floor(value / encoder.resolution_mm + 0.5)
    return value
