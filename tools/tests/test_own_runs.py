"""A unit's file names its healthy runs, and a record of today is judged beside them."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from ema_tools.base.errors import InputError
from ema_tools.data.actuator import read_actuator
from ema_tools.data.records import read_record
from ema_tools.tasks.own_runs import own_runs, why_not_used
from support import RECORDINGS, complaint, run_ema

UNIT = RECORDINGS / "unit"
RUNS = ("healthy_1.csv", "healthy_2.csv", "healthy_3.csv")


def copied(folder: Path, *names: str) -> Path:
    """The unit's file and some of its records in a folder of their own."""
    folder.mkdir()
    for name in ("unit.toml", *names):
        shutil.copy(UNIT / name, folder)
    return folder / "unit.toml"


def test_the_runs_that_are_there_serve_but_for_the_record_itself(tmp_path: Path) -> None:
    model = read_actuator(copied(tmp_path / "all", *RUNS, "worn.csv"))
    worn = read_record(tmp_path / "all" / "worn.csv", model)
    assert [one.file for one in own_runs(model, worn)] == list(RUNS)
    assert [one.file for one in own_runs(model, read_record(UNIT / RUNS[1], model))] == [RUNS[0], RUNS[2]]
    assert own_runs(read_actuator(copied(tmp_path / "one", RUNS[0])), worn) == ()


def test_another_command_is_not_judged_beside_them(tmp_path: Path) -> None:
    model = read_actuator(UNIT / "unit.toml")
    slow = tmp_path / "slow.csv"
    assert run_ema("simulate", UNIT / "unit.toml", "--command", "triangle:amplitude_mm=2,start_hz=0.2,duration_s=10", "-o", slow).code == 0
    record = read_record(slow, model)
    assert own_runs(model, record) == ()
    assert "another command than the 3 healthy runs on which unit.toml was calibrated" in why_not_used(model, record)
    assert "--healthy" in why_not_used(model, record)
    assert not why_not_used(model, read_record(UNIT / "worn.csv", model))
    ran = run_ema("identify", UNIT / "unit.toml", slow)
    assert "slow.csv: it runs another command" in " ".join(ran.err.split())


def test_the_file_names_them_from_its_own_folder_and_forgets_them_where_it_changes(tmp_path: Path) -> None:
    model = read_actuator(UNIT / "unit.toml")
    assert model.healthy == tuple(str(UNIT / name) for name in RUNS)
    model.write(tmp_path / "again.toml")
    again = read_actuator(tmp_path / "again.toml")
    assert [Path(one).resolve() for one in again.healthy] == [(UNIT / name).resolve() for name in RUNS]
    changed = model.changed({"screw.csj_Nm": 0.14})
    changed.write(tmp_path / "changed.toml")
    assert not read_actuator(tmp_path / "changed.toml").healthy
    assert "[calibration]" not in (tmp_path / "changed.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize("row", ["healthy = 3", 'healthy = [""]', "other = 1", 'healthy = ["a.csv", 2]'])
def test_a_wrong_list_is_named(tmp_path: Path, row: str) -> None:
    path = tmp_path / "wrong.toml"
    text = (UNIT / "unit.toml").read_text(encoding="utf-8")
    path.write_text(text[: text.index("[calibration]")] + f"[calibration]\n{row}\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"wrong.toml: \[calibration\]: it holds healthy"):
        read_actuator(path)


def test_a_run_that_is_no_record_any_more_is_named(tmp_path: Path) -> None:
    unit = copied(tmp_path / "unit", *RUNS, "worn.csv")
    (tmp_path / "unit" / RUNS[0]).write_text("time_s\n0\n", encoding="utf-8")
    assert RUNS[0] in complaint(run_ema("identify", unit, tmp_path / "unit" / "worn.csv"))


@pytest.mark.slow
def test_identify_decides_beside_them_without_being_asked(tmp_path: Path) -> None:
    """By the file alone the sound unit's standing residual is an unknown effect."""
    unit = copied(tmp_path / "unit", *RUNS, "sound.csv")
    beside = run_ema("identify", unit, UNIT / "sound.csv", "--json", tmp_path / "beside.json")
    assert "held against healthy_1.csv, healthy_2.csv, healthy_3.csv, on which unit.toml was calibrated" in beside.out
    said = json.loads((tmp_path / "beside.json").read_text(encoding="utf-8"))
    assert said["verdict"] == "healthy"
    assert said["provenance"]["healthy"] == ", ".join(RUNS)
    for name in RUNS:
        (tmp_path / "unit" / name).unlink()
    alone = run_ema("identify", unit, UNIT / "sound.csv", "--json", tmp_path / "alone.json")
    assert "held against" not in alone.out
    assert json.loads((tmp_path / "alone.json").read_text(encoding="utf-8"))["verdict"] == "undecided"
