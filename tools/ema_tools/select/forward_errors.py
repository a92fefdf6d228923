"""The error of the forward solution, and of the drive foretold from the motion, of two models on the records that were fitted and held out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ema_tools.balances.forward import forward_percent
from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import AnyRecord
from ema_tools.fit.division import Division
from ema_tools.select.foretold_drive import reads_drive


@dataclass(frozen=True)
class Forward:
    """Errors before and after in %: of the motion of the records fitted, of those held out, and of the drive; NaN where one cannot be had. `reads`: effects of the last model that read the drive."""

    motion: tuple[float, float]
    holdout: tuple[float, float]
    drive: tuple[float, float]
    reads: tuple[str, ...]


def forward_of(
    given: Actuator,
    last: Actuator,
    records: Sequence[AnyRecord],
    holdout: Sequence[AnyRecord],
    division: Division,
    drive: tuple[float, float],
) -> Forward:
    """Of the actuator as given and of the last model; without a hold-out of the user's, the records of the part that was held out last are apart."""
    fitted, apart = list(records), list(holdout)
    if not apart and division.by == "record":
        held = [int(np.max(part)) == division.folds - 1 for part in division.fold]
        fitted = [record for record, out in zip(records, held, strict=True) if not out]
        apart = [record for record, out in zip(records, held, strict=True) if out]
    motion = (forward_percent(given, fitted), forward_percent(last, fitted))
    there = (forward_percent(given, apart), forward_percent(last, apart)) if apart else (math.nan, math.nan)
    return Forward(motion, there, drive, tuple(name for name in last.active_effects if reads_drive(last, name)))
