"""A recording in memory: one row per record period."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Recording:
    """Channels of equal length [rows]. Positions in mm as the sensors read them; voltage applied from the row on."""

    time_s: np.ndarray
    command_mm: np.ndarray
    position_mm: np.ndarray
    motor_position_mm: np.ndarray
    current_A: np.ndarray
    voltage_V: np.ndarray
    speed_mm_s: np.ndarray

    def e_int_mm2s(self, other: Recording) -> float:
        """Integral of the squared difference of the rod positions, mm^2 s."""
        period = self.time_s[1] - self.time_s[0]
        return float(np.sum((self.position_mm - other.position_mm) ** 2) * period)
