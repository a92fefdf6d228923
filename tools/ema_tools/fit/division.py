"""How one record or several are divided into parts that are fitted and parts that are held out: by record where there are several, else by lap, else by equal parts of the time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ema_tools.data.motion_records import AnyRecord, mean_speed
from ema_tools.fit.laps import FOLDS, Laps, laps_of

By = Literal["lap", "block", "record"]
# What is fitted and held out, one and several, in words.
PART: dict[By, str] = {"lap": "lap", "block": "stretch", "record": "record"}
PARTS: dict[By, str] = {"lap": "laps", "block": "stretches", "record": "records"}

# So many records are each held out in turn; of more, every so-manieth by speed is held out at once, so that each part has all speeds [effort]
_EACH_RECORD = 8


@dataclass(frozen=True)
class Division:
    """The part of every row of each record. The last part is the one that `training` leaves out; `apart`: nothing is ever fitted to it.

    `count`: laps, blocks or records; `laps`: of each record, in which it may repeat itself.
    """

    by: By
    count: int
    folds: int
    fold: tuple[NDArray[np.int64], ...]
    laps: tuple[Laps, ...]
    apart: bool = False


def divided(records: Sequence[AnyRecord], holdout: Sequence[AnyRecord] = ()) -> Division:
    """The division of records, to which is added what the user held out."""
    laps = tuple(laps_of(record) for record in (*records, *holdout))
    by: By = "record" if len(records) > 1 else "lap" if laps[0].period_rows else "block"
    if len(records) == 1:
        count, folds = laps[0].count, laps[0].folds
        parts = [laps[0].fold]
    else:
        count = len(records)
        folds = count if count <= _EACH_RECORD else FOLDS
        parts = [np.full(record.rows, number) for record, number in zip(records, _numbers(records, folds), strict=True)]
    if not holdout:
        return Division(by, count, folds, tuple(parts), laps)
    return Division(by, count, folds + 1, (*parts, *(np.full(record.rows, folds) for record in holdout)), laps, True)


def _numbers(records: Sequence[AnyRecord], folds: int) -> list[int]:
    """The part of each record: its own, or by turns in the order of their speeds."""
    if len(records) <= folds:
        return list(range(len(records)))
    order = np.argsort([mean_speed(record) for record in records], kind="stable")
    numbers = np.empty(len(records), dtype=int)
    numbers[order] = np.arange(len(records)) % folds
    return [int(number) for number in numbers]
