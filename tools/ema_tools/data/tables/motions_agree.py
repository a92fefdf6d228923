"""Signals of one motion held against each other: position against speed, motor against rod, by lead and ratio; and the factor that lies between them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.data.motion_records import MOTIONS, MotionRecord
from ema_tools.data.motion_signals import Train, integrated
from ema_tools.data.tables.plausible_units import looks_like
from ema_tools.data.tables.rate import TableRemark
from ema_tools.data.tables.table_map import TableMap

_FOLLOWS = 0.8  # correlation above which two signals are taken for the same motion [judgement]
_SAME = (0.8, 1.25)  # between these one signal is as large as the other, with room for a gear that is not known well [judgement]
# What is so much like another motion, and so much smaller or larger, is no poor sensor of it but another column: a torque goes with the speed, too [judgement]
_LIKE, _FAR = 0.4, (1.0 / 3.0, 3.0)
_STEPS = 50  # of a record over which both are said to move: a drift of one is small there, and so is the noise of the other [judgement]
_LEAST_PERCENT = 0.01  # to which two signals are said to agree at best [layout]
_AS_ONE = 0.02  # factors nearer to one than this are told as agreement: encoders and leads are better, records seldom [judgement]


class _Pair(NamedTuple):
    """How far two signals move in one record: the factor from the second to the first, and how alike they go."""

    first: str
    second: str
    times: float
    alike: float


def check_motions(records: Sequence[MotionRecord], mapped: TableMap) -> tuple[TableRemark, ...]:
    """Every pair of motion signals in every record. Raises InputError where they contradict each other; answers by which factor they agree."""
    train = Train(mapped.mm_per_rad)
    pairs: list[_Pair] = []
    for record in records:
        ways = _ways(record, mapped, train)
        for first, second in itertools.combinations(ways, 2):
            if _comparable(first, second, train):
                _agree(record, first, second, ways[first], ways[second], mapped)
            pairs.append(_pair(first, second, ways[first], ways[second]))
    return tuple(
        remark
        for names in dict.fromkeys((one.first, one.second) for one in pairs)
        for remark in _told([one for one in pairs if (one.first, one.second) == names and one.alike > _FOLLOWS], train)
    )


def _ways(record: MotionRecord, mapped: TableMap, train: Train) -> dict[str, Reals]:
    """Every motion signal as a way: of the shaft in rad where lead and ratio are known, else as it is recorded."""
    to_angle = 1.0 / train.mm_per_rad if train.mm_per_rad else 1.0
    ways: dict[str, Reals] = {}
    for name in MOTIONS:
        values = record.channel(name)
        if values is not None and not mapped.columns[name].sure:
            travel = integrated(values, record.period_s) if "speed" in name else values
            ways[name] = travel * (1.0 if _at_shaft(name) else to_angle)
    return ways


def _at_shaft(name: str) -> bool:
    return name in ("motor_angle_rad", "motor_speed_rad_s")


def _comparable(first: str, second: str, train: Train) -> bool:
    """Whether two signals are in one unit; a bare motor has no lead between shaft and rod."""
    return bool(train.mm_per_rad) or _at_shaft(first) == _at_shaft(second)


def _agree(record: MotionRecord, first: str, second: str, one: Reals, other: Reals, mapped: TableMap) -> None:
    one, other = one - np.mean(one), other - np.mean(other)
    size = float(np.linalg.norm(one) * np.linalg.norm(other))
    if size == 0.0:
        return
    alike = float(one @ other) / size
    if alike < -_FOLLOWS:
        raise InputError(
            f"{record.file}: {first} and {second} run against each other: change sign in [columns.{first}] or [columns.{second}] of {mapped.file},"
            " whichever is against the machine's positive direction"
        )
    times = float(np.linalg.norm(one) / np.linalg.norm(other))
    if (alike > _FOLLOWS and not _SAME[0] <= times <= _SAME[1]) or (alike > _LIKE and not _FAR[0] <= times <= _FAR[1]):
        across = first.startswith("motor_") != second.startswith("motor_") or ("_mm" in first) != ("_mm" in second)
        more = ", lead or ratio in [machine]" if across else ""
        like = looks_like(times)
        raise InputError(
            f"{record.file}: {first} moves {times:.3g} times as far as {second} says{f', as {like} taken for each other would make it' if like else ''}: correct from, unit or scale in"
            f" [columns.{first}] or [columns.{second}]{more} of {mapped.file}"
        )


def _pair(first: str, second: str, one: Reals, other: Reals) -> _Pair:
    """How far two signals move from step to step of the record."""
    every = max(1, one.size // _STEPS)
    here, there = np.diff(one[::every]), np.diff(other[::every])
    product = float(np.linalg.norm(here) * np.linalg.norm(there))
    if product == 0.0:
        return _Pair(first, second, math.nan, 0.0)
    return _Pair(first, second, float(np.linalg.norm(here) / np.linalg.norm(there)), float(here @ there) / product)


def _told(pairs: Sequence[_Pair], train: Train) -> list[TableRemark]:
    """What is said of one pair of signals over all records that show both moving."""
    if not pairs:
        return []
    first, second, times = pairs[0].first, pairs[0].second, float(np.median([one.times for one in pairs]))
    if not _comparable(first, second, train):
        rod, shaft = (second, first) if _at_shaft(first) else (first, second)
        mm_per_turn = 2.0 * math.pi * (times if rod == first else 1.0 / times)
        return [TableRemark("travel", None, {"lead_mm": mm_per_turn}, rod, shaft)]
    if abs(times - 1.0) <= _AS_ONE:
        return [TableRemark("agree", None, {"percent": max(100.0 * abs(times - 1.0), _LEAST_PERCENT)}, first, second)]
    return [TableRemark("apart", None, {"times": times}, first, second)]
