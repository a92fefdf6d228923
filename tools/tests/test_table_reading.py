"""Text of any layout is read as it was written, and broken files and maps are read or refused in one line."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
import tomlkit
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ema_tools.base.errors import InputError
from ema_tools.data.tables.convert import convert
from ema_tools.data.tables.draft import draft_map
from ema_tools.data.tables.read import read_table
from ema_tools.data.tables.table_map import read_map
from ema_tools.data.tables.text import DELIMITERS, Stated, read_text_table
from ema_tools.data.tables.units import SUFFIXES, Units
from foreign_files import MAP, text

UNITS = Units()
_PREAMBLE = st.lists(
    st.sampled_from(["Device: X7", "Date;2020-07-08 21:28:28", "Samples,500", "Scale:;0;True;2.000;6.000", "", "# remark", "Filter\t3\t4"]),
    max_size=30,
)


@settings(max_examples=150)
@given(
    delimiter=st.sampled_from(list(DELIMITERS)),
    decimal=st.sampled_from(".,"),
    preamble=_PREAMBLE,
    two_rows=st.booleans(),
    end=st.sampled_from(["\n", "\r\n", "\r"]),
    encoding=st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "cp1252"]),
    numbers=st.lists(st.tuples(*[st.floats(-1e6, 1e6).map(lambda one: round(one, 6))] * 3), min_size=10, max_size=40),
    digits=st.sampled_from(["f", "g", "e"]),
)
def test_every_layout_is_read_as_it_was_written(
    delimiter: str,
    decimal: str,
    preamble: list[str],
    two_rows: bool,
    end: str,
    encoding: str,
    numbers: list[tuple[float, ...]],
    digits: str,
) -> None:
    mark = DELIMITERS[delimiter]
    if mark == decimal:
        decimal = "."
    # a file whose numbers all are whole may be read either way, and one of spaces has no names with a space
    numbers = [(0.5, 0.25, 0.125), *numbers]
    names, units = ("time", "speed", "torque"), ("ms", "rpm", "%")
    rows = [mark.join(names), mark.join(units)] if two_rows else [mark.join(names)]
    shape = {"f": ".6f", "g": ".15g", "e": ".12e"}[digits]
    rows += [mark.join(f"{one:{shape}}".replace(".", decimal) for one in row) for row in numbers]
    content = end.join([*preamble, *rows, ""])
    table = read_text_table(content.encode(encoding), "a.txt", Stated(), UNITS)
    assert table.layout.delimiter == delimiter
    assert table.names == names
    assert tuple(column.unit for column in table.columns) == (units if two_rows else ("", "", ""))
    np.testing.assert_allclose(np.column_stack([column.values for column in table.columns]), numbers, rtol=1e-11, atol=1e-6)
    assert table.rows[0] == len(preamble) + len(rows) - len(numbers) + 1


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(edits=st.lists(st.tuples(st.integers(0, 12000), st.binary(max_size=6)), min_size=1, max_size=5))
def test_broken_bytes_are_read_or_refused_in_one_line(tmp_path: Path, edits: list[tuple[int, bytes]]) -> None:
    content = bytearray(text(";", ",", preamble="Made by X\n").encode())
    for place, put in edits:
        content[place : place + len(put)] = put
    (tmp_path / "a.csv").write_bytes(content)
    (tmp_path / "map.toml").write_text(MAP, encoding="utf-8")
    for work in (
        lambda: convert(tmp_path / "a.csv", read_map(tmp_path / "map.toml")),
        lambda: draft_map(read_table(tmp_path / "a.csv"), UNITS),
    ):
        try:
            work()
        except InputError as error:
            assert "\n" not in str(error)
            assert str(error).startswith("a.csv")


_VALUES = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-3, 70000),
    st.floats(allow_nan=True),
    st.sampled_from(["", "?", "rpm", "9.84 mNm", "2 mm", "-1 kg", "auto", "x"]),
)
_KEYS = st.sampled_from(
    [
        "from",
        "unit",
        "sign",
        "scale",
        "offset",
        "period",
        "sure",
        "lead",
        "ratio",
        "inertia",
        "mass",
        "counts_per_turn",
        "encoding",
        "first_row",
        "name",
    ]
)
_PLACES = st.sampled_from(["columns.time_s", "columns.torque_Nm", "columns.motor_speed_rad_s", "machine", "file", "columns"])


@settings(max_examples=200, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(edits=st.lists(st.tuples(_PLACES, _KEYS, _VALUES), min_size=1, max_size=3))
def test_a_broken_map_is_refused_in_one_line(tmp_path: Path, edits: list[tuple[str, str, object]]) -> None:
    content = tomllib.loads(MAP)
    for place, key, value in edits:
        table = content
        for name in place.split("."):
            table = table.setdefault(name, {})
        if value is None:
            table.pop(key, None)
        else:
            table[key] = value
    (tmp_path / "a.csv").write_text(text(), encoding="utf-8")
    (tmp_path / "map.toml").write_text(tomlkit.dumps(content), encoding="utf-8")
    try:
        convert(tmp_path / "a.csv", read_map(tmp_path / "map.toml"))
    except InputError as error:
        assert "\n" not in str(error)
        assert "map.toml" in str(error) or str(error).startswith("a.csv")


@pytest.mark.parametrize("suffix", SUFFIXES)
@settings(max_examples=30)
@given(unit=st.text(max_size=8))
def test_any_text_is_a_unit_or_refused(suffix: str, unit: str) -> None:
    try:
        found = UNITS.converted(np.ones(3), unit, f"x_{suffix}", "map.toml: ")
    except InputError as error:
        assert str(error).startswith("map.toml: unit = ")
    else:
        assert found.shape == (3,)
