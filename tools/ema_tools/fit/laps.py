"""Laps of a record: where its command repeats, and the division into laps that are fitted and laps that are held out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ema_tools.base.arrays import Reals
from ema_tools.base.filters import correlated
from ema_tools.data.motion_records import AnyRecord, motion_signal

# Two stretches of a command are the same when their mean squared difference is below this share of twice its variance [judgement]
SAME = 0.002
# A repetition is looked for only after the command has become this different from itself: neighbouring rows are always alike [judgement]
_DIFFERENT = 0.2
_SHORT = 0.5  # a last lap that is shorter than this share of the others counts with the one before [judgement]
FOLDS = 4  # parts of which one is held out in turn: each is fitted to three quarters [judgement]


@dataclass(frozen=True)
class Laps:
    """The lap of every row, [rows]; `period_rows` is 0 for a command that does not repeat: its laps are then equal parts of the time."""

    number: NDArray[np.int64]
    count: int
    period_rows: int

    @property
    def folds(self) -> int:
        """Number of parts of which each is held out once."""
        return min(FOLDS, self.count)

    @property
    def fold(self) -> NDArray[np.int64]:
        """The part of every row, [rows]: neighbouring laps together where there are many; the last part is the one held out."""
        return np.asarray(self.number * self.folds // self.count)

    def complete(self, values: Reals) -> Reals:
        """Values [rows] of the complete laps, [laps, period]; empty for a command that does not repeat."""
        period = self.period_rows
        whole = values.size // period if period else 0
        return values[: whole * period].reshape(whole, period) if whole else np.zeros((0, 0))


def difference(values: Reals) -> Reals:
    """Mean squared difference of a signal [rows] and itself some rows later over twice its variance, by that lag, [rows / 2]."""
    centred = values - values.mean()
    rows = centred.size
    half = rows // 2 + 1
    power = np.concatenate(([0.0], np.cumsum(centred**2)))
    products = correlated(centred, centred)[rows - 1 :][:half]
    lags = np.arange(half)
    squares = (power[rows] - power[lags]) + power[rows - lags] - 2.0 * products
    variance = power[rows] / rows
    return np.asarray(squares / (2.0 * variance * (rows - lags))) if variance > 0.0 else np.zeros(half)


def period_of(command_mm: Reals) -> int:
    """Rows after which a command [rows] repeats; 0 when it does not within half of the record."""
    unlike = difference(command_mm)
    begun = np.flatnonzero(unlike > _DIFFERENT)
    if not begun.size:
        return 0
    after = np.flatnonzero(unlike[begun[0] :] < SAME) + begun[0]
    if not after.size:
        return 0
    # the bottom of the first valley
    last = after[0] + int(np.argmax(np.append(np.diff(after), 2) > 1))
    return int(after[0] + np.argmin(unlike[after[0] : last + 1]))


def laps_of(record: AnyRecord) -> Laps:
    """The laps of a record by its command, or by its motion where no command is recorded; equal parts of the time for one that does not repeat."""
    period = period_of(motion_signal(record) if record.command_mm is None else record.command_mm)
    rows = np.arange(record.rows)
    if not period:
        return Laps(np.asarray(rows * FOLDS // record.rows), FOLDS, 0)
    number = rows // period
    if record.rows - number[-1] * period < _SHORT * period:
        number = np.minimum(number, number[-1] - 1)
    return Laps(np.asarray(number), int(number[-1]) + 1, period)
