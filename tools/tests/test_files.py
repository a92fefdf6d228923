"""Files are written whole, where they were asked for, and in the place of nothing else."""

from __future__ import annotations

import json
import os
import stat
import sys
from pathlib import Path

import pytest

from ema_tools.base.errors import InputError
from ema_tools.base.files import keep_apart, may_write, plain, write_json, write_text


def test_link_stays_a_link_and_its_file_is_written(tmp_path: Path) -> None:
    (tmp_path / "real.txt").write_text("old", encoding="utf-8")
    link = tmp_path / "link.txt"
    link.symlink_to("real.txt")
    with pytest.raises(InputError, match=r"link\.txt: exists already"):
        write_text(link, "new")
    write_text(link, "new", force=True)
    assert link.is_symlink()
    assert (tmp_path / "real.txt").read_text(encoding="utf-8") == "new"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["link.txt", "real.txt"]


def test_link_to_nothing_makes_what_it_names(tmp_path: Path) -> None:
    link = tmp_path / "link.txt"
    link.symlink_to("new.txt")
    write_text(link, "new")
    assert link.is_symlink()
    assert (tmp_path / "new.txt").read_text(encoding="utf-8") == "new"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes")
@pytest.mark.parametrize("force", [False, True])
@pytest.mark.parametrize("name", ["pipe", "link"])
def test_what_is_no_file_is_refused_and_stays(tmp_path: Path, force: bool, name: str) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to("pipe")
    with pytest.raises(InputError, match=rf"{name}: is a device or pipe, not a file: name a file"):
        write_text(tmp_path / name, "new", force)
    assert stat.S_ISFIFO((tmp_path / "pipe").stat().st_mode)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["link", "pipe"]


def test_place_that_cannot_be_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    (tmp_path / "round").symlink_to("round")
    for path in (tmp_path / "file" / "inside", tmp_path / "round", tmp_path / ("x" * 300)):
        with pytest.raises(InputError, match="choose another place"):
            may_write(path, force=True)


@pytest.mark.skipif(sys.platform == "win32", reason="needs hard links and links")
def test_one_file_under_two_names_is_noticed(tmp_path: Path) -> None:
    first = tmp_path / "first"
    first.write_text("", encoding="utf-8")
    (tmp_path / "hard").hardlink_to(first)
    (tmp_path / "soft").symlink_to("first")
    for name in ("first", "hard", "soft", "../" + tmp_path.name + "/first"):
        with pytest.raises(InputError, match="is read by this command"):
            keep_apart([tmp_path / name], [first])
        with pytest.raises(InputError, match="named for two outputs"):
            keep_apart([first, tmp_path / name])
    keep_apart([tmp_path / "a", tmp_path / "b"], [first])


def test_a_result_is_written_as_the_standard_indents_it(tmp_path: Path) -> None:
    result = {
        "curve": [0.1, -0.0, 1e300, 3, float("nan")],
        "none": {},
        "empty": [],
        "ä, b": "x, \n",
        "mixed": [1.5, "a, b", True, None, [[1, 2], []], {"deep": [{"k": 0.25}]}],
    }
    write_json(tmp_path / "result.json", result)
    assert (tmp_path / "result.json").read_text(encoding="utf-8") == json.dumps(plain(result), indent=1, allow_nan=False) + "\n"
