"""Whether records that are given as healthy runs can be such, before anything is fitted to them: each once, signals of one size, none far from all others."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ema_tools.base.errors import InputError
from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import AnyRecord, same_samples
from ema_tools.data.records import Record
from ema_tools.plant.native import CHANNELS
from ema_tools.select.baseline import check_none_odd, same_command

_SIZES = 10.0  # signals of two runs of one command that differ more than this in size are of different units [physics]
_MOTION = ("position_mm", "motor_position_mm")
_ENOUGH = 3  # of two runs that lie apart nobody knows which is the odd one [chance]


def check_alike(actuator: Actuator, records: Sequence[Record]) -> None:
    """Raises InputError, naming the file, among runs of one command for one with a signal of another size than the others', or far from them all."""
    left = list(records)
    while left:
        same = [same_command(left[0], one) for one in left]
        runs = [one for one, is_same in zip(left, same, strict=True) if is_same]
        left = [one for one, is_same in zip(left, same, strict=True) if not is_same]
        _check_sizes(runs)
        if len(runs) >= _ENOUGH:
            check_none_odd(actuator, runs)


def _check_sizes(runs: Sequence[Record]) -> None:
    """What most of them have is right: each is held against the one in the middle."""
    for name in CHANNELS:
        measured = [one for one in runs if one.channel(name) is not None]
        if len(measured) > 1:
            by_size = sorted(measured, key=lambda one: float(np.std(one.recorded(name))))
            middle = by_size[len(by_size) // 2]
            for other in measured:
                if other is not middle:
                    check_size(middle, other, (name,))


def check_apart(record: AnyRecord, healthy: Sequence[AnyRecord]) -> None:
    """Raises InputError when a healthy record is the record itself or is given twice: identical samples tell nothing of how the machine repeats."""
    for other in healthy:
        if same_samples(record, other):
            raise InputError(f"{other.file}: healthy is the record itself, against which nothing has changed: leave it out of --healthy")
    check_once(healthy)


def check_once(records: Sequence[AnyRecord], kind: str = "healthy run") -> None:
    """Raises InputError when a record is given twice: what it shows would confirm itself."""
    for place, other in enumerate(records):
        for earlier in records[:place]:
            if same_samples(earlier, other):
                raise InputError(
                    f"{other.file}: {'given twice' if other.file == earlier.file else f'holds the same samples as {earlier.file}'}: give every {kind} once"
                )


def check_against_all(record: Record, others: Sequence[Record]) -> None:
    """Raises InputError, naming the record, where a signal of it is of another size than in all of several others of its command, which are of one size: then it is not they that are wrong."""
    for name in (name for name in CHANNELS if record.channel(name) is not None):
        sizes = [float(np.std(one.recorded(name))) for one in others if one.channel(name) is not None]
        size = float(np.std(record.recorded(name)))
        alike = len(sizes) > 1 and 0.0 < max(sizes) < _SIZES * min(sizes)
        if alike and size > 0.0 and not min(sizes) / _SIZES < size < max(sizes) * _SIZES:
            times = size / float(np.median(sizes))
            what = f"{record.file}: {name} is {times:.3g} times that of the {len(sizes)} healthy records"
            if name in _MOTION and times < 1.0:
                raise InputError(
                    f"{what} under the same command: the machine does not follow, or the unit is another one: look whether it is stuck or without power, else give all in the same unit"
                )
            raise InputError(f"{what}: give all in the same unit")


def check_size(record: Record, other: Record, names: Sequence[str] = CHANNELS) -> None:
    """Raises InputError, naming `other`, where a signal of it is not of the size of the record's: repeats of one command have signals of one size."""
    for name in (name for name in names if record.channel(name) is not None and other.channel(name) is not None):
        size, its = float(np.std(record.recorded(name))), float(np.std(other.recorded(name)))
        if size > 0.0 and not its > 0.0:
            raise InputError(
                f"{other.file}: {name} does not change, while that of {record.file} does: check that the sensor was connected, or leave the file out"
            )
        if size > 0.0 and not 1.0 / _SIZES < its / size < _SIZES:
            raise InputError(f"{other.file}: {name} is {its / size:.3g} times that of {record.file}: give both in the same unit")
