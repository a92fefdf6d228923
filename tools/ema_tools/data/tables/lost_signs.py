"""A speed whose sign was lost: it is never negative, while what drives the machine, or the way that it goes, turns round whenever it stands still."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.data.motion_records import DRIVES, MOTIONS, VOLTAGES, MotionRecord
from ema_tools.data.tables.table_map import TableMap

_SPEEDS = ("motor_speed_rad_s", "speed_mm_s")
_WAYS = (*(name for name in MOTIONS if name not in _SPEEDS), "command_mm")
_ONE_WAY = 0.02  # of the largest speed: what lies below is noise around standstill [judgement]
_MOVES = 0.05  # of the largest speed: between slower rows lies a stretch of motion [judgement]
_ROWS_LEAST = 5  # of a stretch: fewer are noise [judgement]
_ONE_SIGN = 0.3  # share of what another signal does along a stretch, and not against it, before the stretch has its sign [judgement]
_STRETCHES = 0.2  # of all rows that move that stretches of either sign must hold: a push back now and then is no way back [judgement]


def check_signs(records: Sequence[MotionRecord], mapped: TableMap) -> None:
    """Raises InputError for a speed that never changes its sign where another signal says that the machine goes both ways."""
    for name in _SPEEDS:
        holding = [one for one in records if name in one.present]
        if not holding or mapped.columns[name].sure or not _one_way([one.recorded(name) for one in holding]):
            continue
        for other in (*_WAYS, *VOLTAGES, *DRIVES):
            both = [one for one in holding if other in one.present]
            if both and not mapped.columns[other].sure and _both_ways(both, name, other):
                made = f", or leave out [columns.{name}] of {mapped.file}: it is then made of {other}" if other in MOTIONS else ""
                raise InputError(
                    f"{both[0].file}{f' and {len(both) - 1} more' if len(both) > 1 else ''}: {name} never changes its sign while {other} turns round from motion to motion:"
                    f" its sign was lost: record the signed speed, or give it the sign of {'the way of ' if other in _WAYS else ''}{other} in the file{made},"
                    f" or write sure = true in [columns.{name}] where the machine goes one way only"
                )


def _one_way(speeds: Sequence[Reals]) -> bool:
    least, most = min(float(one.min()) for one in speeds), max(float(one.max()) for one in speeds)
    return min(-least, most) <= _ONE_WAY * max(-least, most)


def _both_ways(records: Sequence[MotionRecord], name: str, other: str) -> bool:
    """Whether another signal has one sign in some motions from standstill to standstill, and the other one in others."""
    held = {1.0: 0, -1.0: 0}
    rows = 0
    for record in records:
        speed = record.recorded(name)
        values = np.gradient(record.recorded(other), record.period_s) if other in _WAYS else record.recorded(other)
        for part in _stretches(np.abs(speed) > _MOVES * float(np.max(np.abs(speed), initial=0.0))):
            done = values[part] * speed[part]
            size = float(np.sum(np.abs(done)))
            rows += done.size
            if size > 0.0 and abs(float(np.sum(done))) > _ONE_SIGN * size:
                held[float(np.sign(np.sum(done)))] += done.size
    return rows > 0 and min(held.values()) > _STRETCHES * rows


def _stretches(moves: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> Iterator[slice]:
    """Motions that begin and end within the record: of one that is cut nobody knows what it took."""
    edges = np.flatnonzero(np.diff(moves.astype(np.int8))) + 1
    for first, last in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        if moves[first] and last - first >= _ROWS_LEAST:
            yield slice(first, last)
