"""Drives of one machine held against each other: a torque, a force and a current that drive the same motion go alike, and are as large by torque constant, lead and ratio."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.data.motion_records import DRIVES, MotionRecord
from ema_tools.data.tables.table_map import TableMap

_FOLLOWS = 0.8  # correlation above which two signals are taken for the same drive [judgement]
# Correlation below which they are two things, in all records and in one alone: what friction or a mass between two sensors of a drive takes leaves more [judgement]
_UNLIKE, _UNLIKE_ALONE = 0.6, 0.4
_FAR = (1.0 / 3.0, 3.0)  # between these one drive is as large as the other, whatever a gear loses [judgement]
_MEAN_S = 0.02  # over which both are averaged: shorter than what moves a machine with its load [judgement]
_APART_S = 0.05  # two clocks, or a filter, put drives apart by up to so much [judgement]
_SHIFTS = 10  # each way that are tried [effort]
_VARIES = 0.3  # of its size: a drive that varies by less is held, as at constant speed, and tells nothing [judgement]
_ABOVE_NOISE = 2.0  # times what noise leaves of a mean: below it nothing is recorded [judgement]
# What an external sensor's signal is where it is no drive.
_LOADS = {"force_N": "disturbance_N", "torque_Nm": "disturbance_Nm"}


def check_drives(records: Sequence[MotionRecord], mapped: TableMap) -> None:
    """Every pair of drives over all records that hold both. Raises InputError where they contradict each other."""
    for first, second in itertools.combinations(DRIVES, 2):
        both = [one for one in records if first in one.present and second in one.present]
        if not both or mapped.columns[first].sure or mapped.columns[second].sure:
            continue
        for record in both:
            _same_way(record, first, second, mapped)
        # a single record of another motion shows what the largest of all would hide
        for group, least in (*(([record], _UNLIKE_ALONE) for record in both), (both, _UNLIKE)):
            alike, times = _alike(group, first, second)
            if (_tells(group, first) or _tells(group, second)) and alike < least:
                raise InputError(
                    f"{_files(group)}: {first} and {second} have little in common (correlation {alike:.2f}), and both are said to be the drive: one of them is none:"
                    f" {_instead(first, second)}; else leave one of the two out of {mapped.file}, or write sure = true in one of them"
                )
        scale = _scale(first, mapped) / _scale(second, mapped)
        if alike > _FOLLOWS and math.isfinite(scale) and not _FAR[0] <= times * scale <= _FAR[1]:
            raise InputError(
                f"{_files(both)}: {first} is {times * scale:.3g} times as large as {second} makes it: correct unit or scale in [columns.{first}] or [columns.{second}],"
                f" or {_between(first, second)} in [machine] of {mapped.file}, or {_instead(first, second)}"
            )


def _files(records: Sequence[MotionRecord]) -> str:
    """Several records by the first of them."""
    return records[0].file + (f" and {len(records) - 1} more" if len(records) > 1 else "")


def _same_way(record: MotionRecord, first: str, second: str, mapped: TableMap) -> None:
    """Raises InputError for two drives of the opposite sign."""
    one, other = record.recorded(first), record.recorded(second)
    if np.std(one) > 0.0 and np.std(other) > 0.0 and float(np.corrcoef(one, other)[0, 1]) < -_FOLLOWS:
        raise InputError(
            f"{record.file}: {first} and {second} run against each other: change sign in [columns.{first}] or [columns.{second}] of {mapped.file}"
        )


def _width(record: MotionRecord) -> int:
    return min(max(1, round(_MEAN_S / record.period_s)), max(1, record.rows // 8))


def _meant(record: MotionRecord, name: str) -> Reals:
    """A drive, averaged, [rows]."""
    return np.convolve(record.recorded(name), np.full(_width(record), 1.0 / _width(record)), mode="valid")


def _tells(records: Sequence[MotionRecord], name: str) -> bool:
    """Whether a drive varies over all records by more than its noise and than what holds a constant speed."""
    every = np.concatenate([_meant(one, name) for one in records])
    noise = max(float(np.std(np.diff(one.recorded(name)))) / math.sqrt(2.0 * _width(one)) for one in records)
    return float(np.std(every)) > max(_VARIES * float(np.sqrt(np.mean(every**2))), _ABOVE_NOISE * noise)


def _alike(records: Sequence[MotionRecord], first: str, second: str) -> tuple[float, float]:
    """The largest correlation of two drives over the shifts that clocks make, and how many times as large the first is."""
    pairs = [(_meant(record, first), _meant(record, second)) for record in records]
    best, times = 0.0, math.nan
    for share in np.linspace(-1.0, 1.0, 2 * _SHIFTS + 1):
        parts = [
            _shifted(one, other, round(share * _APART_S / record.period_s)) for (one, other), record in zip(pairs, records, strict=True)
        ]
        one, other = (np.concatenate([part[k] for part in parts]) for k in range(2))
        if one.size < 2 or np.std(one) == 0.0 or np.std(other) == 0.0:
            continue
        correlation = float(np.corrcoef(one, other)[0, 1])
        if correlation > best:
            best, times = correlation, float(np.std(one) / np.std(other))
    return best, times


def _shifted(one: Reals, other: Reals, rows: int) -> tuple[Reals, Reals]:
    """The rows that two signals share when the second is so many rows later."""
    if abs(rows) >= one.size // 2:
        return one, other
    return (one[: one.size - rows], other[rows:]) if rows >= 0 else (one[-rows:], other[:rows])


def _scale(name: str, mapped: TableMap) -> float:
    """From a drive's own unit to Nm at the motor shaft; NaN where it is not known."""
    if name == "torque_Nm":
        return 1.0
    if name == "force_N":
        return 1e-3 * mapped.mm_per_rad if mapped.mm_per_rad else math.nan
    return mapped.machine.get("torque_constant", math.nan)


def _instead(first: str, second: str) -> str:
    """What another sensor's force or torque is."""
    return "what a sensor between machine and load measures is " + " or ".join(
        f"[columns.{_LOADS[name]}] in place of [columns.{name}]" for name in (first, second) if name in _LOADS
    )


def _between(first: str, second: str) -> str:
    """The entries of the machine that lie between two drives."""
    entries = {"force_N": "lead or ratio", "current_A": "torque_constant"}
    return ", ".join(entries[name] for name in (first, second) if name in entries)
