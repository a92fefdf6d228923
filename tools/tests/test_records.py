"""Recordings: round trips through every format, noise, and what is complained about."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ema_tools.base.errors import InputError
from ema_tools.data.actuator import reference_actuator
from ema_tools.data.records import COLUMNS, Record, read_record, start_of, write_record
from ema_tools.plant.native import CHANNELS
from support import RECORDINGS, chirp_record

ROWS = 120
numbers = arrays(np.float64, ROWS, elements=st.floats(-1e6, 1e6, allow_nan=False))


def columns_of(record: Record) -> dict[str, np.ndarray]:
    return {"time_s": record.time_s, **{name: record.channel(name) for name in record.present}}


def write_as(record: Record, ending: str, folder: Path) -> Path:
    path = folder / f"r.{ending}"
    if ending == "csv":
        write_record(path, record)
    elif ending == "mat":
        from scipy.io import savemat

        savemat(path, columns_of(record))
    else:
        import pyarrow
        import pyarrow.parquet

        pyarrow.parquet.write_table(pyarrow.table(columns_of(record)), path)
    return path


@given(command=numbers, position=numbers, current=st.none() | numbers)
def test_csv_keeps_every_bit(
    tmp_path_factory: pytest.TempPathFactory, command: np.ndarray, position: np.ndarray, current: np.ndarray | None
) -> None:
    record = Record(1e-3, command, position, current_A=current)
    again = read_record(write_as(record, "csv", tmp_path_factory.mktemp("r")))
    assert again.present == record.present
    for name in record.present:
        # -0.0 and 0.0 are the same number
        assert np.array_equal(again.channel(name), record.channel(name))
    assert again.period_s == pytest.approx(1e-3, rel=1e-12)


@pytest.mark.parametrize("ending", ["csv", "mat", "parquet"])
def test_every_format_gives_the_same_record(tmp_path: Path, ending: str) -> None:
    record = chirp_record()
    again = read_record(write_as(record, ending, tmp_path), reference_actuator())
    assert again.present == COLUMNS[1:]
    for name in record.present:
        assert np.array_equal(again.channel(name), record.channel(name))
    assert again.file == f"r.{ending}"


def test_shipped_recording() -> None:
    record = read_record(RECORDINGS / "case_a.csv", reference_actuator())
    assert record.rows == 10000
    assert record.period_s == pytest.approx(1e-3)
    assert record.speed_mm_s is None
    assert record.table().shape == (10000, len(CHANNELS))


BAD = [
    ("metres", lambda r: replace(r, position_mm=1e-3 * r.position_mm), "position_mm: travels .* looks like metres"),
    ("half the rate", lambda r: replace(r, period_s=2e-3), "time_s: a row every 0.002 s, and the actuator records one every 0.001 s"),
    ("not finite", lambda r: replace(r, position_mm=np.where(np.arange(r.rows) == 7, np.nan, r.position_mm)), "position_mm: "),
]


@pytest.mark.parametrize("ending", ["csv", "mat", "parquet"])
@pytest.mark.parametrize(("change", "message"), [case[1:] for case in BAD], ids=[case[0] for case in BAD])
def test_every_format_is_checked(tmp_path: Path, ending: str, change: object, message: str) -> None:
    path = write_as(change(chirp_record()), ending, tmp_path)  # type: ignore[operator]
    with pytest.raises(InputError, match=message) as raised:
        read_record(path, reference_actuator())
    assert f"r.{ending}" in str(raised.value)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize("ending", ["mat", "parquet"])
def test_broken_files(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"b.{ending}"
    with pytest.raises(InputError, match="no such file or directory: check the path"):
        read_record(path)
    path.write_bytes(b"this is no such file" * 20)
    with pytest.raises(InputError, match=r"not a readable \.?\w+ file"):
        read_record(path)


def test_columns_of_unequal_length_and_text(tmp_path: Path) -> None:
    from scipy.io import savemat

    path = tmp_path / "u.mat"
    content = columns_of(chirp_record())
    savemat(path, {**content, "current_A": np.zeros(5)})
    with pytest.raises(InputError, match="current_A: 5 rows where another column has 10000"):
        read_record(path)
    savemat(path, {**content, "current_A": "none"})
    with pytest.raises(InputError, match="current_A: holds something that is not a number"):
        read_record(path)


def test_noise_has_its_size_and_its_seed() -> None:
    record = chirp_record()
    noisy = record.with_noise({"position_mm": 0.005}, 3)
    assert np.std(noisy.position_mm - record.position_mm) == pytest.approx(0.005, rel=0.03)
    assert noisy.current_A is record.current_A
    assert np.array_equal(noisy.position_mm, record.with_noise({"position_mm": 0.005}, 3).position_mm)
    assert not np.array_equal(noisy.position_mm, record.with_noise({"position_mm": 0.005}, 4).position_mm)
    with pytest.raises(InputError, match="noise on current_A: the column is not there"):
        replace(record, current_A=None).with_noise({"current_A": 1.0}, 1)


def test_start_is_the_command_where_the_rod_may_rest_there() -> None:
    actuator = reference_actuator()
    zeros = np.zeros(ROWS)
    assert start_of(actuator, Record(1e-3, zeros, zeros + 0.02)) == 0.0
    assert start_of(actuator, Record(1e-3, zeros, zeros + 0.2)) == 0.2
