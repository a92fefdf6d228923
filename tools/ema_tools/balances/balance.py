"""What a balance of a record is."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ema_tools.base.arrays import Reals


@dataclass(frozen=True)
class Balance:
    """One balance on its samples: measured side and residual, both [samples] in `unit`, and their time; `resting_percent` is the share of
    the record in which the shaft rests and friction is not tested."""

    name: str
    unit: str
    time_s: Reals
    measured: Reals
    residual: Reals
    resting_percent: float = 0.0

    @property
    def rms(self) -> float:
        """Root mean square of the residual."""
        return float(np.sqrt(np.mean(self.residual**2)))

    @property
    def relative_percent(self) -> float:
        """100 * norm of the residual / norm of the measured side; NaN when nothing was measured."""
        size = float(np.linalg.norm(self.measured))
        return 100.0 * float(np.linalg.norm(self.residual)) / size if size > 0.0 else math.nan
