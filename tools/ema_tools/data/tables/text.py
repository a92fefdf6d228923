"""Text of any layout as columns: encoding, delimiter, decimal mark, preamble, names and units are found by looking for the rows of numbers; each can be stated instead."""

from __future__ import annotations

import codecs
import csv
import io
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.data.tables.raw import Layout, RawColumn, RawTable
from ema_tools.data.tables.units import Units

# Names of what may separate fields, in the order in which they are tried where several would do.
DELIMITERS = {"semicolon": ";", "tab": "\t", "bar": "|", "comma": ",", "spaces": " "}
DECIMALS = {"point": ".", "comma": ","}
EMPTY = frozenset({"", "nan", "na", "n/a", "null", "none", "-", "--", "---", "#n/a", "1.#qnan", "-1.#ind", "inf", "-inf", "+inf"})
_NUMBER = {
    ".": re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?"),
    ",": re.compile(r"[+-]?(\d+(,\d+)?|,\d+)([eE][+-]?\d+)?"),
}
_MOMENT = re.compile(r"(\d{1,4}[-./]\d{1,2}[-./]\d{1,4}[ T]?)?\d{1,2}:\d{2}(:\d{2}([.,]\d+)?)?Z?|\d{4}-\d{2}-\d{2}")
# Letters behind an underscore that are a phase or an axis, and no years, days, hours or speeds of light; degrees only of what is called a temperature.
_NO_UNITS = frozenset("acdh")
# Symbols of what is in metres or seconds: behind any other, m is of the motor and s of the screw.
_SYMBOLS_OF = {"m": "xyzsld", "s": "t"}
_DEGREES, _WARM = frozenset("CF"), re.compile(r"(?:\b|_)t|temp", re.IGNORECASE)
_SAMPLE_ROWS = 1000  # rows of a long file by which its layout is told: more would tell no more [effort]
_HEADERS_MAX = 3  # rows right above the numbers that may hold names and units: names, units, and a remark of the maker [judgement]


@dataclass(frozen=True)
class Stated:
    """What is stated of a file's layout; empty or 0 for what is to be found out."""

    encoding: str = ""
    delimiter: str = ""
    decimal: str = ""
    names_row: int = 0
    units_row: int = 0
    first_row: int = 0


def read_text_table(content: bytes, file: str, stated: Stated, units: Units) -> RawTable:
    """The columns of a text file. Raises InputError that names file, row and column and says what to write."""
    text, encoding = _decoded(content, file, stated.encoding)
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    delimiter, decimal, count = _dialect(lines, file, stated)
    first = stated.first_row - 1 if stated.first_row else _first_row(lines, delimiter, decimal, count)
    if first >= len(lines):
        raise InputError(f"{file}: has {len(lines)} rows: correct first_row in [file]")
    names, in_units, header_rows = _headers(lines, first, delimiter, count, stated, units)
    kept, cut_row, footer = _body(lines, first, delimiter, count, decimal, file)
    columns = _columns(kept, lines, delimiter, decimal, names, in_units, file)
    named = next(key for key, mark in DELIMITERS.items() if mark == delimiter)
    layout = Layout("text", encoding, named, next(key for key, mark in DECIMALS.items() if mark == decimal), header_rows, first + 1)
    return RawTable(file, columns, np.asarray(kept, dtype=np.int64) + 1, layout, {}, cut_row, footer)


def _decoded(content: bytes, file: str, stated: str) -> tuple[str, str]:
    """The text and its encoding: as stated, by its byte order mark, UTF-16 by its zero bytes, UTF-8, else Windows' Western European."""
    for mark, name in ((codecs.BOM_UTF8, "utf-8-sig"), (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16")):
        if not stated and content.startswith(mark):
            stated = name
    head = content[:2000]
    if not stated and head.count(0) > len(head) // 4:
        stated = "utf-16-le" if head[1::2].count(0) > head[::2].count(0) else "utf-16-be"
    try:
        if stated:
            return content.decode(stated).removeprefix("\ufeff"), stated
        try:
            return content.decode("utf-8"), "utf-8"
        except UnicodeDecodeError:
            return content.decode("cp1252", errors="replace"), "cp1252"
    except LookupError:
        raise InputError(
            f'{file}: encoding = "{stated}" in [file]: no encoding that is known: use for example "utf-8", "utf-16", "cp1252"'
        ) from None
    except UnicodeDecodeError as error:
        raise InputError(
            f"{file}: byte {error.start} is not {stated}: state another encoding in the map's [file], or leave it out; a maker's file becomes a record by ema import table"
        ) from None


def cells_of(line: str, delimiter: str) -> list[str]:
    """The fields of a row, without quotes and spaces around."""
    if delimiter == " ":
        return line.split()
    if '"' in line:
        try:
            return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))]
        except (csv.Error, StopIteration):
            pass
    return [cell.strip() for cell in line.split(delimiter)]


def _says_number(cell: str, decimal: str) -> bool:
    return _NUMBER[decimal].fullmatch(cell) is not None or _MOMENT.fullmatch(cell) is not None


def _shares(lines: Sequence[str], delimiter: str, decimal: str) -> tuple[float, int]:
    """How well a dialect explains rows as rows of numbers, and the number of columns it finds."""
    found: Counter[int] = Counter()
    for line in lines:
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        cells = cells_of(line, delimiter)
        full = [cell for cell in cells if cell.lower() not in EMPTY]
        numbers = sum(_says_number(cell, decimal) for cell in full)
        if full and 2 * numbers >= len(full) and len(cells) > 1:
            found[len(cells)] += numbers * numbers / len(full)  # type: ignore[assignment]
    if not found:
        return 0.0, 0
    count = max(found, key=lambda one: found[one])
    return float(found[count]), count


def _dialect(lines: Sequence[str], file: str, stated: Stated) -> tuple[str, str, int]:
    """Delimiter, decimal mark and number of columns. Raises InputError."""
    for key, known, entry in ((stated.delimiter, DELIMITERS, "delimiter"), (stated.decimal, DECIMALS, "decimal")):
        if key and key not in known:
            raise InputError(f'{file}: {entry} = "{key}" in [file]: not known: use one of {", ".join(known)}')
    start = max(stated.first_row - 1, 0)
    sample = lines[start:]
    if len(sample) > 2 * _SAMPLE_ROWS:
        sample = sample[len(sample) // 2 :][:_SAMPLE_ROWS]
    best, answer = 0.0, ("", "", 0)
    for name, delimiter in DELIMITERS.items():
        for said, decimal in DECIMALS.items():
            if (stated.delimiter and name != stated.delimiter) or (stated.decimal and said != stated.decimal):
                continue
            score, count = _shares(sample, delimiter, decimal)
            if score > 1.001 * best:
                best, answer = score, (delimiter, decimal, count)
    if not answer[2]:
        how = " with the delimiter and decimal mark of [file]" if stated.delimiter or stated.decimal else ""
        raise InputError(
            f"{file}: no rows with two or more numbers are found{how}: check that it is a table, and state delimiter and decimal in [file] if it is"
        )
    return answer


def _first_row(lines: Sequence[str], delimiter: str, decimal: str, count: int) -> int:
    """Place of the first row of numbers: the columns that hold numbers in most rows hold them in it."""
    rows = {place: cells_of(line, delimiter) for place, line in _spread(lines)}
    rows = {place: cells for place, cells in rows.items() if len(cells) == count}
    numeric = [
        column
        for column in range(count)
        if 2 * sum(_says_number(cells[column], decimal) for cells in rows.values())
        > sum(cells[column].lower() not in EMPTY for cells in rows.values())
    ]
    for place, line in enumerate(lines):
        cells = cells_of(line, delimiter)
        if len(cells) != count or line.lstrip().startswith("#"):
            continue
        kinds = [_says_number(cells[column], decimal) for column in numeric]
        if any(kinds) and all(kind or cells[column].lower() in EMPTY for kind, column in zip(kinds, numeric, strict=True)):
            return place
    return 0


def _spread(lines: Sequence[str]) -> list[tuple[int, str]]:
    """Rows all over the file, with their places; all of a short one."""
    every = max(1, len(lines) // _SAMPLE_ROWS)
    return [(place, lines[place]) for place in range(0, len(lines), every)]


def _headers(
    lines: Sequence[str], first: int, delimiter: str, count: int, stated: Stated, units: Units
) -> tuple[list[str], list[str], tuple[int, ...]]:
    """Names [count], units [count] (empty where there are none), and the numbers of the rows that hold them."""
    if stated.names_row:
        names = _padded(_header_cells(lines[stated.names_row - 1], delimiter, count) or [], count)
        given = _padded(_header_cells(lines[stated.units_row - 1], delimiter, count) or [], count) if stated.units_row else [""] * count
        return names, _with_units_in_names(names, given, units), tuple(filter(None, (stated.names_row, stated.units_row)))
    above: list[tuple[int, list[str]]] = []
    for place in range(first - 1, max(first - 1 - _HEADERS_MAX, -1), -1):
        cells = _header_cells(lines[place], delimiter, count)
        if cells is None:
            break
        above.append((place, _padded(cells, count)))
    if not above:
        return [""] * count, [""] * count, ()
    units_at = next((k for k, (_, cells) in enumerate(above[:-1]) if _are_units(cells, units)), None)
    names_at = 0 if units_at is None else units_at + 1
    names = above[names_at][1]
    given = above[units_at][1] if units_at is not None else [""] * count
    rows = [above[names_at][0] + 1] + ([above[units_at][0] + 1] if units_at is not None else [])
    return names, _with_units_in_names(names, [cell.strip("[](){} ") for cell in given], units), tuple(rows)


def _header_cells(line: str, delimiter: str, count: int) -> list[str] | None:
    """The fields of a row above the numbers, None when it has not as many as they have."""
    text = line.lstrip()
    cells = cells_of(text.lstrip("#%").lstrip() if text[:1] in ("#", "%") and delimiter == " " else line, delimiter)
    if delimiter == " " and len(cells) != count:
        cells = [cell for cell in re.split(r"\s{2,}|\t", text.lstrip("#").strip()) if cell]
    if not any(cells) or not count - 1 <= len(cells) <= count or count < 2:
        return None
    cells[0] = cells[0].lstrip("#").strip()
    return cells


def _padded(cells: list[str], count: int) -> list[str]:
    return (cells + [""] * count)[:count]


def _are_units(cells: Sequence[str], units: Units) -> bool:
    """Whether most of a row's fields are units; those that are numbers alone or nothing count for neither."""
    full = [cell for cell in cells if cell.strip("[](){} -")]
    return bool(full) and 2 * sum(units.is_unit(cell) for cell in full) > len(full)


def _with_units_in_names(names: Sequence[str], given: Sequence[str], units: Units) -> list[str]:
    """The units, from the names where no row states them: "Speed [rpm]", "Speed (rpm)", "Speed / rpm", "speed/rpm", "speed_rpm"."""
    return [unit or unit_in_name(name, units) for name, unit in zip(names, given, strict=True)]


def unit_in_name(name: str, units: Units) -> str:
    """The unit at the end of a name, empty where there is none."""
    return split_unit(name, units)[1]


def split_unit(name: str, units: Units) -> tuple[str, str]:
    """A name without its unit, and the unit; the whole name and nothing where it has none."""
    for pattern in (
        r"[\[({]\s*([^\[\](){}]+?)\s*[\])}]\s*$",
        r"\s+in\s+(\S+)\s*$",
        r"\s[/,]\s*(\S+)\s*$",
        r"_([^_\s]+_s)$",
        r"_([^_\s]+)$",
    ):
        matched = re.search(pattern, name)
        if not matched:
            continue
        for text in (matched[1], matched[1].replace("_", "/")):
            if units.is_unit(text) and not (pattern.startswith("_") and _is_index(name[: matched.start()], text)):
                return name[: matched.start()].strip(), text
        if pattern.startswith(r"[\["):
            return name, ""
    # quantity / unit, as standards have it: "speed/rad/s"; a name that is a unit as a whole is none of a quantity
    slashes = [place for place, letter in enumerate(name) if letter == "/"] if not units.is_unit(name) else []
    found = next((place for place in slashes if name[:place].strip() and units.is_unit(name[place + 1 :])), None)
    return (name, "") if found is None else (name[:found].strip(), name[found + 1 :].strip())


def _is_index(front: str, letter: str) -> bool:
    """Whether a letter behind an underscore tells symbols apart, n_m from n_s, and is no unit."""
    if letter in _SYMBOLS_OF and re.search(r"(?:\b|_)[^\W_]{1,2}$", front):
        return re.search(rf"(?:\b|_)[{_SYMBOLS_OF[letter]}][^\W_]?$", front, re.IGNORECASE) is None
    return letter in _NO_UNITS or (letter in _DEGREES and not _WARM.search(front))


def _body(lines: Sequence[str], first: int, delimiter: str, count: int, decimal: str, file: str) -> tuple[list[int], int | None, int]:
    """Places of the rows of numbers, the number of a last row that was cut, and how many rows of text stand below. Raises InputError that names a row with too many or too few fields."""
    kept = [place for place in range(first, len(lines)) if lines[place].strip() and not lines[place].lstrip().startswith("#")]
    footer = 0
    while kept and not any(_says_number(cell, decimal) for cell in _all_fields(lines[kept[-1]], delimiter, count)):
        kept.pop()
        footer += 1
    cut_row = None
    for place in kept:
        found = len(cells_of(lines[place], delimiter)) if '"' in lines[place] or delimiter == " " else lines[place].count(delimiter) + 1
        if found == count:
            continue
        if place == kept[-1] and found < count:
            cut_row = place + 1
            continue
        raise InputError(
            f"{file}, row {place + 1}: {found} fields where other rows have {count}: correct or delete that row, or state delimiter and decimal in [file]"
        )
    return (kept[:-1] if cut_row else kept), cut_row, footer


def _all_fields(line: str, delimiter: str, count: int) -> list[str]:
    """The fields of a row of numbers, none for a row of text, which has another number of fields."""
    cells = cells_of(line, delimiter)
    return cells if len(cells) >= max(2, count - 1) else []


def _columns(
    kept: Sequence[int], lines: Sequence[str], delimiter: str, decimal: str, names: Sequence[str], in_units: Sequence[str], file: str
) -> tuple[RawColumn, ...]:
    """The columns of the rows at `kept`; those without name and numbers are left out."""
    import pandas

    body = io.StringIO("\n".join(lines[place] for place in kept) + "\n")
    try:
        frame = pandas.read_csv(
            body,
            sep=r"\s+" if delimiter == " " else delimiter,
            decimal=decimal,
            header=None,
            names=list(range(len(names))),
            index_col=False,
            na_values=sorted({*EMPTY, *(text.upper() for text in EMPTY)}),
            skipinitialspace=True,
            low_memory=False,
        )
    except (pandas.errors.ParserError, pandas.errors.EmptyDataError, ValueError):
        raise InputError(
            f"{file}: is no table from row {kept[0] + 1 if kept else 1} on: state first_row, delimiter and decimal in [file]"
        ) from None
    seen: Counter[str] = Counter()
    found = []
    for place in range(len(names)):
        values, texts = _numbers(frame[place])
        name = names[place] or f"column {place + 1}"
        if not names[place] and not texts and np.isnan(values).all():
            continue
        seen[name] += 1
        found.append(RawColumn(name if seen[name] == 1 else f"{name} ({seen[name]})", in_units[place], values, place + 1, texts))
    return tuple(found)


def _numbers(column: object) -> tuple[Reals, dict[int, str]]:
    """A column of pandas as numbers [rows], and the cells that are none."""
    import pandas

    numbers = pandas.to_numeric(column, errors="coerce").to_numpy(dtype=np.float64)
    values = np.where(np.isfinite(numbers), numbers, np.nan)
    cells = column.to_numpy(dtype=object)  # type: ignore[attr-defined]
    odd = np.flatnonzero(np.isnan(values) & ~np.asarray(pandas.isna(cells)))
    return values, {int(place): str(cells[place]).strip() for place in odd}
