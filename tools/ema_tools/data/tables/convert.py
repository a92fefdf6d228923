"""A file and its map as records: columns found, cells checked, units and signs applied, the rate made constant."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.data.motion_records import COLUMNS, PERIOD_MAX_S, PERIOD_MIN_S, MotionRecord
from ema_tools.data.tables.plausible_units import check_step, check_turn, is_named
from ema_tools.data.tables.rate import TableRemark, pieces_of
from ema_tools.data.tables.raw import RawColumn, RawTable
from ema_tools.data.tables.read import read_table
from ema_tools.data.tables.table_map import ColumnMap, TableMap
from ema_tools.data.tables.units import RMS, SHARES, Units, suffix_of

MOMENTS = "datetime"
_EPOCH_S = 1e7  # no recorder counts a third of a year from its own start [judgement]
_SLOW = ("temperature_C",)
_COUNTER_ROWS = 50  # so many rows that rise by exactly one are a counter and no signal [judgement]
_WRAPS = (65536.0, 4294967296.0)  # counters of 16 and of 32 bits start again at these [layout]
_LIKELY_S = (1e-5, 0.2)  # steps that recorders usually have, for the unit that is proposed [judgement]


@dataclass(frozen=True)
class Converted:
    """The records of one file, in order, and what was done to it. `path` as it was given; `unnamed`: the file's names of the columns whose unit it does not name, by the record's."""

    path: Path
    records: tuple[MotionRecord, ...]
    remarks: tuple[TableRemark, ...]
    unnamed: Mapping[str, str]


def convert(path: Path, mapped: TableMap, units: Units | None = None) -> Converted:
    """Read a file by its map. Raises InputError in one line that names file, row and column and says what to write where."""
    known = units or mapped.units
    table = read_table(path, mapped.stated, known)
    _once(mapped)
    raw = {name: found_column(table, name, column, mapped.file) for name, column in mapped.columns.items() if column.source is not None}
    remarks: list[TableRemark] = []
    if table.cut_row is not None:
        remarks.append(TableRemark("cut_row", table.cut_row))
    if table.footer_rows:
        remarks.append(TableRemark("footer", None, {"count": float(table.footer_rows)}))
    time_s = _time(table, raw.get("time_s"), mapped, known)
    columns: dict[str, Reals] = {}
    for name, column in mapped.columns.items():
        if name == "time_s":
            continue
        values, told = _signal(table, raw[name], name, column, mapped, known)
        columns[name] = values
        remarks += told
    finite = time_s[np.isfinite(time_s)]
    if finite.size > 1 and np.all(np.diff(finite) < 0.0):
        raise InputError(f"{table.file}: time falls from row to row: write the rows in the order of time, the first one first")
    pieces, told = pieces_of(time_s, columns, table.rows, _SLOW)
    remarks += told
    if not pieces:
        raise InputError(
            f"{table.file}: no rows in which time and all columns hold numbers: name other columns in {mapped.file}, or leave out a column that is empty"
        )
    unnamed = {name: column.name for name, column in raw.items() if not is_named(column, known)}
    for piece in pieces:
        _check_period(piece.period_s, table, mapped)
        if "time_s" in unnamed:
            rows = next(iter(piece.columns.values())).size
            check_step(piece.period_s, rows, raw["time_s"], mapped.columns["time_s"], table.file, mapped.file)
    stem = path.name[: -len(path.suffix)] if path.suffix else path.name
    ends = [""] if len(pieces) == 1 else [f"_{number}" for number in range(1, len(pieces) + 1)]
    ordered = [name for name in COLUMNS if name in columns]
    records = tuple(
        _at_one_time(
            MotionRecord(piece.period_s, f"{stem}{end}.csv", piece.first_time_s).with_columns(
                {name: piece.columns[name] for name in ordered if not np.isnan(piece.columns[name]).any()}
            ),
            mapped,
        )
        for piece, end in zip(pieces, ends, strict=True)
    )
    return Converted(
        path, records, tuple(remarks), {name: column for name, column in unnamed.items() if mapped.columns[name].unit != MOMENTS}
    )


def _at_one_time(record: MotionRecord, mapped: TableMap) -> MotionRecord:
    """The record with each column that comes late, or early, moved to where it belongs; rows that not all columns reach then are left out. Raises InputError where none is left."""
    delays = {name: mapped.columns[name].delay_s / record.period_s for name in record.present}
    early, late = (max(math.ceil(side * delay) for delay in (0.0, *delays.values())) for side in (-1.0, 1.0))
    if not early and not late:
        return record
    if record.rows <= early + late:
        raise InputError(f"{mapped.file}: the delays of columns are longer than {record.file}: correct delay, or leave it out")
    places = np.arange(early, record.rows - late, dtype=np.float64)
    moved = {name: np.interp(places + delay, np.arange(record.rows), record.recorded(name)) for name, delay in delays.items()}
    return MotionRecord(record.period_s, record.file, record.first_time_s + early * record.period_s).with_columns(moved)


def found_column(table: RawTable, name: str, column: ColumnMap, map_file: str) -> RawColumn:
    """The column of a file that the map means. Raises InputError with the nearest name."""
    wanted = column.source
    if isinstance(wanted, int):
        numbered = next((one for one in table.columns if one.number == wanted), None)
        if numbered is not None:
            return numbered
        raise InputError(
            f"{table.file}: has no column {wanted} with numbers, but {len(table.columns)} others ({_listed(table.names)}): correct from = {wanted} in [columns.{name}] of {map_file}"
        )

    def plain(text: str) -> str:
        return " ".join(text.casefold().split())

    text = str(wanted)
    for same in (lambda one: one == text, lambda one: plain(one) == plain(text)):
        fitting = [one for one in table.columns if same(one.name)]
        if fitting:
            return fitting[0]
    uneven = next((one for one in table.uneven if plain(one) == plain(text)), None)
    if uneven is not None:
        raise InputError(
            f'{table.file}: "{uneven}" has {table.uneven[uneven]} values, where the other columns have {table.rows.size}: every signal needs one in every row: write the file again, or name'
            f" another column in [columns.{name}] of {map_file}"
        )
    near = difflib.get_close_matches(plain(text), [plain(one) for one in table.names], n=1, cutoff=0.5)
    hint = next((f' (did you mean "{one}"?)' for one in table.names if near and plain(one) == near[0]), "")
    raise InputError(
        f'{table.file}: no column "{text}"{hint}: columns are {_listed(table.names)}: correct from in [columns.{name}] of {map_file}'
    )


def _listed(names: Sequence[str]) -> str:
    return ", ".join(f'"{name}"' for name in names[:12]) + (" ..." if len(names) > 12 else "")


def _once(mapped: TableMap) -> None:
    """Raises InputError when one column of the file is given two meanings."""
    seen: dict[str | int, str] = {}
    for name, column in mapped.columns.items():
        if column.source is None or column.sure:
            continue
        if column.source in seen:
            raise InputError(
                f"{mapped.file}: columns.{seen[column.source]} and columns.{name} are from the same column of the file: correct from in one of them, or write sure = true in both"
            )
        seen[column.source] = name


def _check_cells(table: RawTable, column: RawColumn) -> None:
    """Raises InputError for the first cell that holds a text."""
    if column.texts:
        place = min(column.texts)
        raise InputError(
            f'{table.file}, row {table.rows[place]}, "{column.name}": "{column.texts[place]}" is not a number: correct it, or leave the cell empty for no number'
        )
    if np.isnan(column.values).all():
        raise InputError(f'{table.file}: "{column.name}": holds no number in any row: name another column')


def _time(table: RawTable, column: RawColumn | None, mapped: TableMap, units: Units) -> Reals:
    """Time in s, [rows]. Raises InputError."""
    entry = mapped.columns["time_s"]
    if column is None or entry.period_s is not None:
        return float(entry.period_s or 0.0) * np.arange(table.rows.size, dtype=np.float64)
    where = f"{mapped.file}: columns.time_s."
    if entry.unit == MOMENTS:
        return _moments(table, column)
    if column.texts and len(column.texts) > table.rows.size // 2:
        place = min(column.texts)
        raise InputError(
            f'{table.file}, row {table.rows[place]}, "{column.name}": "{column.texts[place]}" is not a number: if it is a date or a time of day write unit = "{MOMENTS}"'
            f" in [columns.time_s] of {mapped.file}"
        )
    _check_cells(table, column)
    _same_unit(table, column, "time_s", entry, mapped, units)
    found = np.asarray(
        entry.sign * units.converted(entry.scale * column.values + entry.offset, entry.unit, "time_s", where), dtype=np.float64
    )
    known = found[np.isfinite(found)]
    # seconds since some epoch are a date, which counts from its first row: as they are they leave no digits for the step
    return found - known[0] if known.size and abs(float(known[0])) > _EPOCH_S else found


def _moments(table: RawTable, column: RawColumn) -> Reals:
    """Dates or times of day as seconds from the first; a time of day that falls by half a day has passed midnight. Raises InputError."""
    import pandas

    texts = [column.texts.get(place, "") for place in range(table.rows.size)]
    dated = any(mark in texts[0] for mark in "-/") or texts[0].count(".") > 1
    times = [text.replace(",", ".") for text in texts]
    try:
        if dated:
            moments = pandas.to_datetime(pandas.Series(times), format="mixed", dayfirst="." in times[0].split(" ")[0], utc=True)
            found = (moments - moments.iloc[0]).dt.total_seconds().to_numpy(dtype=np.float64)
        else:
            spans = pandas.to_timedelta(pandas.Series([text if text.count(":") == 2 else f"00:{text}" for text in times]))
            found = spans.dt.total_seconds().to_numpy(dtype=np.float64)
    except (ValueError, TypeError):
        bad = next((place for place, text in enumerate(texts) if ":" not in text), 0)
        raise InputError(
            f'{table.file}, row {table.rows[bad]}, "{column.name}": "{texts[bad]}" is no date or time of day: write the unit of a number in [columns.time_s], or correct it'
        ) from None
    if not dated:  # past midnight it begins again
        days = np.concatenate(([0.0], np.cumsum(np.diff(found) < -43200.0)))
        found = found + 86400.0 * days
    return np.asarray(found - found[0], dtype=np.float64)


def _signal(
    table: RawTable, column: RawColumn, name: str, entry: ColumnMap, mapped: TableMap, units: Units
) -> tuple[Reals, list[TableRemark]]:
    """A column in the unit of the record, [rows], NaN where there is no number. Raises InputError."""
    _check_cells(table, column)
    raw, told = column.values, []
    steps = np.diff(raw)
    if not entry.sure and raw.size > _COUNTER_ROWS and np.all(steps == 1.0):
        raise InputError(
            f'{table.file}: "{column.name}": only counts the rows: name another column in [columns.{name}] of {mapped.file}, or write sure = true there'
        )
    _same_unit(table, column, name, entry, mapped, units)
    where = f"{mapped.file}: columns.{name}."
    if name in ("motor_angle_rad", "motor_position_mm", "position_mm"):
        turn = 2.0 * math.pi / float(units.converted(np.ones(1), entry.unit, name, where)[0]) / abs(entry.scale)
        raw, wrapped = _unwrapped(raw, (turn, *_WRAPS) if name == "motor_angle_rad" else _WRAPS)
        if wrapped:
            told.append(TableRemark("unwrapped", None, {"count": float(wrapped)}, name))
        elif name == "motor_angle_rad" and not is_named(column, units):
            check_turn(raw, column, entry, name, table.file, mapped.file)
    if entry.unit.strip().lower() in RMS:
        told.append(TableRemark("rms", None, None, name))
    values = units.converted(entry.scale * raw + entry.offset, entry.unit, name, where)
    return entry.sign * values, told


def _unwrapped(values: Reals, wraps: Sequence[float]) -> tuple[Reals, int]:
    """Values without the jumps of a counter that starts again, and how many there were."""
    there = np.isfinite(values)
    seen = values[there]
    steps = np.abs(np.diff(seen))
    for wrap in wraps:
        if seen.size and float(np.ptp(seen)) <= 1.0001 * wrap and np.any(steps > 0.5 * wrap):
            whole = values.copy()
            whole[there] = np.unwrap(seen, period=wrap)
            return whole, int(np.sum(steps > 0.5 * wrap))
    return values, 0


def _same_unit(table: RawTable, column: RawColumn, name: str, entry: ColumnMap, mapped: TableMap, units: Units) -> None:
    """Raises InputError when the file states another unit than the map."""
    stated, said = column.unit.strip(), entry.unit.strip()
    if not stated or entry.sure or entry.scale != 1.0 or entry.offset != 0.0 or stated == said:
        return
    if (stated.lower() in SHARES) != (said.lower() in SHARES):
        differ = units.is_unit(stated)
    elif stated.lower() in SHARES:
        differ = SHARES[stated.lower()] != SHARES[said.lower()]
    else:
        if not units.fits(said, suffix_of(name)):
            return  # the unit of the map does not fit the column, which is said where it is converted
        suffix = units.suffix(stated)
        differ = bool(suffix) and (
            suffix != suffix_of(name)
            or not math.isclose(*(float(units.converted(np.ones(1), one, name, "")[0]) for one in (stated, said)), rel_tol=1e-6)
        )
    if differ:
        raise InputError(
            f'{table.file}: "{column.name}" is in {stated} by the file, in {said} by {mapped.file}: correct unit in [columns.{name}], or write sure = true there'
        )


def _check_period(period_s: float, table: RawTable, mapped: TableMap) -> None:
    """Raises InputError for a rate that no record has."""
    if PERIOD_MIN_S * (1.0 - 1e-9) <= period_s <= PERIOD_MAX_S * (1.0 + 1e-9):
        return
    entry = mapped.columns["time_s"]
    text = ""
    if entry.period_s is None and entry.unit != MOMENTS:
        one = float(Units().converted(np.ones(1), entry.unit, "time_s", "")[0])
        scales: Mapping[str, float] = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0}
        fits = [unit for unit, scale in scales.items() if _LIKELY_S[0] <= period_s / one * scale <= _LIKELY_S[1]]
        text = f' (unit = "{fits[0]}" would give {period_s / one * scales[fits[0]]:g} s)' if fits else ""
    raise InputError(
        f"{table.file}: time: steps of {period_s:g} s: records have {PERIOD_MIN_S:g} to {PERIOD_MAX_S:g} s: correct unit in [columns.time_s] of {mapped.file}{text}"
    )
