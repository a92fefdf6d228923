"""A recording that is still written: complete rows only, and whatever happens to the file is noticed."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from ema_tools.base.errors import InputError
from ema_tools.data import growing as module
from ema_tools.data.actuator import read_actuator
from ema_tools.data.growing import Growing
from ema_tools.data.records import read_record
from support import RECORDINGS, REFERENCE

LINES = (RECORDINGS / "healthy.csv").read_bytes().splitlines(keepends=True)


def test_rows_come_as_they_are_complete(tmp_path: Path) -> None:
    path = tmp_path / "r.csv"
    actuator = read_actuator(REFERENCE)
    growing = Growing(path)
    assert not growing.read()
    path.write_bytes(b"".join(LINES[:500]))
    assert growing.read()
    whole = growing.record(actuator).rows
    with path.open("ab") as stream:
        stream.write(LINES[500][:7])
    assert not growing.read()
    assert growing.record(actuator).rows == whole
    with path.open("ab") as stream:
        stream.write(LINES[500][7:])
    assert growing.read()
    assert growing.record(actuator).rows == whole + 1
    with path.open("ab") as stream:
        stream.write(b"".join(LINES[501:]))
    assert growing.read()
    found, wanted = growing.record(actuator), read_record(RECORDINGS / "healthy.csv", actuator)
    assert np.array_equal(found.position_mm, wanted.position_mm)
    assert growing.begun == 0


@pytest.mark.parametrize("how", ["shorter", "replaced", "rewritten longer"])
def test_a_file_that_is_begun_anew_is_noticed(tmp_path: Path, how: str) -> None:
    path = tmp_path / "r.csv"
    path.write_bytes(b"".join(LINES[:500]))
    growing = Growing(path)
    assert growing.read()
    if how == "shorter":
        path.write_bytes(b"".join(LINES[:200]))
    elif how == "replaced":
        other = tmp_path / "other.csv"
        other.write_bytes(b"".join(LINES[:600]))
        os.replace(other, path)
    else:
        path.write_bytes(b"# another\n" + b"".join(LINES[:600]))
    assert growing.read()
    assert growing.begun == 1
    with_comment = Growing(path)
    with_comment.read()
    actuator = read_actuator(REFERENCE)
    assert growing.record(actuator).rows == with_comment.record(actuator).rows


def test_a_wrong_row_is_named_and_what_was_read_stays(tmp_path: Path) -> None:
    path = tmp_path / "r.csv"
    path.write_bytes(b"".join(LINES[:300]) + b"0.3,nan,oops\n")
    growing = Growing(path)
    assert growing.read()
    with pytest.raises(InputError, match=r"^r\.csv: row 301"):
        growing.record(read_actuator(REFERENCE))


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes on this system")
def test_a_pipe_gives_what_its_writer_has_written(tmp_path: Path) -> None:
    path = tmp_path / "pipe.csv"
    os.mkfifo(path)
    growing = Growing(path)
    assert not growing.read()
    with path.open("wb") as writer:
        for start in range(0, 900, 300):
            writer.write(b"".join(LINES[start : start + 300]))
            writer.flush()
            assert growing.read()
    growing.close()
    path_whole = tmp_path / "whole.csv"
    path_whole.write_bytes(b"".join(LINES[:900]))
    actuator = read_actuator(REFERENCE)
    assert np.array_equal(growing.record(actuator).position_mm, read_record(path_whole, actuator).position_mm)


def test_a_folder_and_a_file_without_end_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="a folder: give the file"):
        Growing(tmp_path).read()
    monkeypatch.setattr(module, "BYTES_MAX", 1 << 10)
    long = tmp_path / "long.csv"
    long.write_bytes(b"".join(LINES[:500]))
    with pytest.raises(InputError, match=r"^long\.csv: more than 0 MiB: begin a new file"):
        Growing(long).read()
