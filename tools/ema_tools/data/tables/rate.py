"""A constant rate for every piece of a record: rounded stamps are put right, uneven time is resampled, gaps and restarts of the clock cut the record; all of it is told."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from ema_tools.base.arrays import Flags, Reals
from ema_tools.data.motion_records import ROWS_MIN
from ema_tools.data.tables.raw import Rows

RemarkKind = Literal[
    "rounded",
    "repeated",
    "filled",
    "empty",
    "resampled",
    "rates",
    "gap",
    "restart",
    "short",
    "unwrapped",
    "cut_row",
    "footer",
    "rms",
    "one_way",
    "copy",
    "agree",
    "apart",
    "travel",
    "inertia",
    "assumed",
    "held",
    "frictionless",
    "setpoint",
    "others",
]
GAP_STEPS = 3.5  # a step longer than so many usual ones is a gap that straight lines may not cross: three lost rows are still few of the motion [judgement]
_EVEN_SHARE = 0.01  # of a step: rows that are off an even rate by less are on it, the error is below a percent of the speed [precision]
_STAMP_SHARE = 0.51  # of the last digit of the stamps: rounding moves them by half of it [precision]
_ODD_STEPS = 4  # of another length than the usual one, before a clock is said to round: fewer are lost rows [judgement]
_DIGITS = 9  # most digits behind the point of a time in seconds: clocks of recorders resolve no more [physics]


@dataclass(frozen=True)
class TableRemark:
    """One thing that was done to a file or is odd about it: its row where it has one, its numbers by name, its column, and the other one that it is held against."""

    kind: RemarkKind
    row: int | None = None
    numbers: Mapping[str, float] | None = None
    column: str = ""
    other: str = ""


@dataclass(frozen=True)
class EvenPiece:
    """Rows of one constant rate; every array of shape [rows]."""

    period_s: float
    first_time_s: float
    columns: Mapping[str, Reals]


def even(time_s: Reals) -> tuple[float, float] | None:
    """First time and step of an even rate, None when the times are not even; stamps that are rounded may be off by their rounding."""
    rows = time_s.size
    if rows < 2:
        return None
    place = np.arange(rows) - 0.5 * (rows - 1)
    middle = float(np.mean(time_s))
    period = float(place @ (time_s - middle) / (place @ place))
    if period <= 0.0:
        return None
    steps = np.diff(time_s)
    # a lost row or two make one or two odd steps, rounding makes them all along
    odd = int(np.sum(np.abs(steps - np.median(steps)) > _EVEN_SHARE * period))
    allowed = max(_EVEN_SHARE * period, _STAMP_SHARE * _stamp_s(time_s) if odd >= _ODD_STEPS else 0.0)
    if float(np.max(np.abs(time_s - middle - period * place))) > allowed:
        return None
    period = _nice(period, 2.0 * allowed / rows)
    first = middle - 0.5 * period * (rows - 1)
    return (float(time_s[0]) if abs(first - time_s[0]) <= allowed else first), period


def _stamp_s(time_s: Reals) -> float:
    """The last digit that the stamps have, s."""
    for digits in range(_DIGITS + 1):
        scaled = time_s * 10.0**digits
        if float(np.max(np.abs(scaled - np.round(scaled)))) < 1e-9 * max(1.0, float(np.max(np.abs(scaled)))):
            return float(10.0**-digits)
    return 0.0


def _nice(period_s: float, allowed_s: float) -> float:
    """The number of fewest digits that is not farther off."""
    for digits in range(1, 16):
        short = float(f"{period_s:.{digits}g}")
        if abs(short - period_s) <= allowed_s:
            return short
    return period_s


def pieces_of(
    time_s: Reals, columns: Mapping[str, Reals], rows: Rows, slow: Sequence[str] = ()
) -> tuple[list[EvenPiece], list[TableRemark]]:
    """The pieces of a record with a constant rate each, and what was done.

    `columns` [rows] may hold NaN where there is no number; `rows`: their numbers in the file; `slow`: columns that are not cut but filled by straight lines.
    """
    kept = np.isfinite(time_s)
    time_s, rows, columns = time_s[kept], rows[kept], {name: values[kept] for name, values in columns.items()}
    found: list[EvenPiece] = []
    told: list[TableRemark] = []
    starts = [0, *(np.flatnonzero(np.diff(time_s) < 0.0) + 1).tolist(), time_s.size]
    for first, last in pairwise(starts):
        if first:
            told.append(TableRemark("restart", int(rows[first])))
        part = slice(first, last)
        if last > first:
            pieces, remarks = _one_clock(time_s[part], {name: values[part] for name, values in columns.items()}, rows[part], slow)
            found += pieces
            told += remarks
    return found, told


def _one_clock(time_s: Reals, columns: dict[str, Reals], rows: Rows, slow: Sequence[str]) -> tuple[list[EvenPiece], list[TableRemark]]:
    """Pieces of rows whose time never falls."""
    fast = [name for name in columns if name not in slow]
    there = {name: np.isfinite(columns[name]) for name in columns}
    full = all(there[name].all() for name in fast)
    rate = even(time_s)
    if full and rate is not None:
        told = [TableRemark("rounded", None, {"period_s": rate[1]})] if np.any(np.diff(time_s) <= 0.0) else []
        filled = {name: values if name in fast else _line(time_s, time_s, values, there[name]) for name, values in columns.items()}
        return _long_enough([EvenPiece(rate[1], rate[0], filled)], rows, told)
    told = []
    rising = np.concatenate(([True], np.diff(time_s) > 0.0))
    if not rising.all():
        told.append(TableRemark("repeated", int(rows[np.flatnonzero(~rising)[0]]), {"count": float(np.sum(~rising))}))
        time_s, rows = time_s[rising], rows[rising]
        columns, there = {name: values[rising] for name, values in columns.items()}, {name: flags[rising] for name, flags in there.items()}
    if all(np.array_equal(there[name], there[fast[0]]) for name in fast):
        pieces, remarks = _same_rows(time_s, columns, there, there[fast[0]], rows, fast)
    else:
        pieces, remarks = _own_rows(time_s, columns, there, rows, fast)
    return _long_enough(pieces, rows, told + remarks)


def _same_rows(
    time_s: Reals, columns: Mapping[str, Reals], there: Mapping[str, Flags], seen: Flags, rows: Rows, fast: Sequence[str]
) -> tuple[list[EvenPiece], list[TableRemark]]:
    """Pieces where all signals are there in the same rows."""
    whole, told = time_s, []
    time_s, rows = time_s[seen], rows[seen]
    if time_s.size < 2:
        return [], []
    usual = float(np.median(np.diff(time_s)))
    cuts = np.flatnonzero(np.diff(time_s) > GAP_STEPS * usual) + 1
    found = []
    for first, last in zip((0, *cuts.tolist()), (*cuts.tolist(), time_s.size), strict=True):
        if first:
            told.append(TableRemark("gap", int(rows[first]), {"length_s": float(time_s[first] - time_s[first - 1])}))
        times = time_s[first:last]
        if times.size < ROWS_MIN:
            told.append(TableRemark("short", int(rows[first]), {"count": float(times.size)}))
            continue
        rate = even(times)
        if rate is not None:
            grid = rate[0] + rate[1] * np.arange(times.size, dtype=np.float64)
            own = {name: columns[name][seen][first:last] for name in fast}
            period_s = rate[1]
        else:
            grid, period_s, remark = _regular(times)
            told.append(remark)
            own = {name: np.interp(grid, times, columns[name][seen][first:last]) for name in fast}
        others = {
            name: _line(np.asarray(grid, dtype=np.float64), whole, columns[name], there[name]) for name in columns if name not in fast
        }
        found.append(EvenPiece(period_s, float(grid[0]), {**own, **others}))
    return found, told


def _regular(times: Reals) -> tuple[Reals, float, TableRemark]:
    """A grid of the usual step over uneven times, and what it makes of them: lost rows filled, or all resampled."""
    steps = np.diff(times)
    usual = float(np.median(steps))
    counts = np.maximum(np.round(steps / usual), 1.0)
    if float(np.max(np.abs(steps - counts * usual))) <= max(_EVEN_SHARE * usual, 2.0 * _STAMP_SHARE * _stamp_s(times)):
        total = int(np.sum(counts))
        period_s = _nice(float((times[-1] - times[0]) / total), _EVEN_SHARE * usual / total)
        # stamps of whole milliseconds that stray by one lose no row
        told = (
            TableRemark("filled", None, {"count": float(total - steps.size)})
            if total > steps.size
            else TableRemark("rounded", None, {"period_s": period_s})
        )
        return times[0] + period_s * np.arange(total + 1), period_s, told
    period_s = _nice(usual, _EVEN_SHARE * usual)
    grid = times[0] + period_s * np.arange(math.floor((times[-1] - times[0]) / period_s + 1e-9) + 1)
    return (
        grid,
        period_s,
        TableRemark("resampled", None, {"shortest_s": float(np.min(steps)), "longest_s": float(np.max(steps)), "period_s": period_s}),
    )


def _own_rows(
    time_s: Reals, columns: Mapping[str, Reals], there: Mapping[str, Flags], rows: Rows, fast: Sequence[str]
) -> tuple[list[EvenPiece], list[TableRemark]]:
    """Pieces where signals are there in rows of their own: all come to the rate of the slowest, where each has numbers near."""
    usual, spans = {}, []
    for name in fast:
        times = time_s[there[name]]
        if times.size < 2:
            return [], []
        steps = np.diff(times)
        usual[name] = float(np.median(steps))
        cuts = np.flatnonzero(steps > GAP_STEPS * usual[name])
        spans.append(list(zip((times[0], *times[cuts + 1]), (*times[cuts], times[-1]), strict=True)))
    slowest = max(usual, key=lambda name: usual[name])
    period_s = _nice(usual[slowest], _EVEN_SHARE * usual[slowest])
    told = [TableRemark("rates", None, {"period_s": period_s}, slowest)]
    if max(usual.values()) - min(usual.values()) <= _EVEN_SHARE * usual[slowest]:
        # one rate, and cells that are empty here and there
        holes = {name: np.flatnonzero(~there[name]) for name in fast if not there[name].all()}
        told = [TableRemark("empty", int(rows[places[0]]), {"count": float(places.size)}, name) for name, places in holes.items()]
    common = spans[0]
    for other in spans[1:]:
        common = [(max(a, c), min(b, d)) for a, b in common for c, d in other if min(b, d) > max(a, c)]
    found: list[EvenPiece] = []
    last_end: float | None = None
    for start, end in sorted(common):
        if last_end is not None:
            place = int(np.searchsorted(time_s, start))
            told.append(TableRemark("gap", int(rows[min(place, rows.size - 1)]), {"length_s": float(start - last_end)}))
        last_end = end
        grid = start + period_s * np.arange(math.floor((end - start) / period_s + 1e-9) + 1)
        if grid.size < ROWS_MIN:
            told.append(TableRemark("short", int(rows[np.searchsorted(time_s, start)]), {"count": float(grid.size)}))
            continue
        found.append(EvenPiece(period_s, float(start), {name: _line(grid, time_s, columns[name], there[name]) for name in columns}))
    return found, told


def _line(grid: Reals, time_s: Reals, values: Reals, there: Flags) -> Reals:
    """Values at other times by straight lines between those that are there; NaN when none is."""
    if there.all() and grid is time_s:
        return values
    return np.interp(grid, time_s[there], values[there]) if there.any() else np.full(grid.size, np.nan)


def _long_enough(pieces: list[EvenPiece], rows: Rows, told: list[TableRemark]) -> tuple[list[EvenPiece], list[TableRemark]]:
    """Without pieces that are too short to show a motion."""
    kept = []
    for piece in pieces:
        size = next(iter(piece.columns.values())).size
        if size < ROWS_MIN:
            told.append(TableRemark("short", int(rows[0]), {"count": float(size)}))
        else:
            kept.append(piece)
    return kept, told
