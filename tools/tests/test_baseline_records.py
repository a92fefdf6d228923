"""A unit's file names its healthy runs, and a record of today is judged beside them."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from ema_tools.base.errors import InputError
from ema_tools.data.actuator import read_actuator
from ema_tools.data.records import read_record
from ema_tools.tasks.baseline_records import baseline_records_of, why_not_used, with_state
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
    assert [one.file for one in baseline_records_of(model, worn)] == list(RUNS)
    assert [one.file for one in baseline_records_of(model, read_record(UNIT / RUNS[1], model))] == [RUNS[0], RUNS[2]]
    assert baseline_records_of(read_actuator(copied(tmp_path / "one", RUNS[0])), worn) == ()


def test_another_command_is_not_judged_beside_them(tmp_path: Path) -> None:
    model = read_actuator(UNIT / "unit.toml")
    slow = tmp_path / "slow.csv"
    assert run_ema("simulate", UNIT / "unit.toml", "--command", "triangle:amplitude_mm=2,start_hz=0.2,duration_s=10", "-o", slow).code == 0
    record = read_record(slow, model)
    assert baseline_records_of(model, record) == ()
    assert "another command than the 3 baseline records of unit.toml" in why_not_used(model, record)
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
    assert "[baseline]" not in (tmp_path / "changed.toml").read_text(encoding="utf-8")


def with_table(folder: Path, table: str) -> Path:
    """The unit's file with another table in the place of [baseline]."""
    path = folder / "other.toml"
    text = (UNIT / "unit.toml").read_text(encoding="utf-8")
    path.write_text(text[: text.index("[baseline]")] + table + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    "rows",
    [
        "records = 3",
        'records = [""]',
        "other = 1",
        'records = ["a.csv", 2]',
        'sha256 = ["0"]',
        'records = ["a.csv"]\nsha256 = ["0", "1"]',
        'records = ["a.csv"]\nwithout = ["no_effect"]',
        'records = ["a.csv"]\nbefore = {"screw.csj_Nm" = 0.1}',
        'records = ["a.csv"]\nbefore = {"effects.presliding.stretch_rad" = "much"}',
    ],
)
def test_a_wrong_baseline_is_named(tmp_path: Path, rows: str) -> None:
    with pytest.raises(InputError, match=r"other.toml: \[baseline\]"):
        read_actuator(with_table(tmp_path, f"[baseline]\n{rows}"))


@pytest.mark.parametrize("row", ["record = 3", 'csj_Nm = "0.2"', "csj_Nm = nan", "other = 1"])
def test_a_wrong_finding_is_named(tmp_path: Path, row: str) -> None:
    with pytest.raises(InputError, match=r"other.toml: \[\[findings\]\]"):
        read_actuator(with_table(tmp_path, f"[[findings]]\n{row}"))


def test_the_list_of_an_earlier_version_is_read(tmp_path: Path) -> None:
    old = with_table(tmp_path, '[calibration]\nhealthy = ["a.csv", "b.csv"] # as written before')
    model = read_actuator(old)
    assert model.healthy == tuple(str(tmp_path / name) for name in ("a.csv", "b.csv"))
    model.write(tmp_path / "same.toml")
    assert (tmp_path / "same.toml").read_text(encoding="utf-8") == old.read_text(encoding="utf-8")
    with pytest.raises(InputError, match=r"other.toml: \[calibration\]: it holds healthy"):
        read_actuator(with_table(tmp_path, "[calibration]\nhealthy = 3"))


def test_baseline_and_findings_are_read_as_they_were_written(tmp_path: Path) -> None:
    model = read_actuator(UNIT / "unit.toml")
    worn = read_record(UNIT / "worn.csv", model)
    records = baseline_records_of(model, worn)
    effect = model.changed({"effects.stribeck_friction.rise": 0.3})
    today = effect.changed({"screw.csj_Nm": 0.2, "screw.blk_mm": 0.07})
    machine = with_state(effect, model, records, model, ["stribeck_friction"], worn, today, "add")
    machine.write(tmp_path / "machine.toml")
    again = read_actuator(tmp_path / "machine.toml")
    assert again.baseline is not None and again.baseline.since == ("stribeck_friction",) and again.baseline.covers(records)
    assert [Path(file).resolve() for file in again.healthy] == [(UNIT / name).resolve() for name in RUNS]
    assert again.before_baseline().active_effects == model.active_effects
    (finding,) = again.findings
    assert dict(finding.values) == {"screw.csj_Nm": 0.2, "screw.blk_mm": 0.07} and finding.sha256 == worn.sha256
    # today's wear stands apart from the healthy values
    assert again["screw.csj_Nm"] == model["screw.csj_Nm"] and again["screw.blk_mm"] == model["screw.blk_mm"]
    # what is found on the same record again takes the place of the earlier finding
    assert len(with_state(effect, again, records, model, (), worn, today, "add").findings) == 1


def test_an_effect_that_grew_stands_in_the_baseline_as_it_was(tmp_path: Path) -> None:
    model = read_actuator(UNIT / "unit.toml")
    worn = read_record(UNIT / "worn.csv", model)
    records = baseline_records_of(model, worn)
    size = "effects.presliding.stretch_rad"
    healthy, grown = model.changed({size: 0.003}), model.changed({size: 0.02})
    with_state(grown, model, records, healthy, ["presliding"], worn, grown, "add").write(tmp_path / "machine.toml")
    again = read_actuator(tmp_path / "machine.toml")
    assert again["presliding.stretch_rad"] == 0.02 and again.before_baseline()["presliding.stretch_rad"] == 0.003
    # what came before another effect stays as the first command found it
    later = again.changed({"effects.stribeck_friction.rise": 0.3})
    machine = with_state(later, again, records, again, ["stribeck_friction", "presliding"], worn, later, "add")
    assert machine.baseline is not None and dict(machine.baseline.before or ()) == {
        "effects.stribeck_friction.rise": 0.0,
        size: 0.003,
    }


def test_effects_that_an_earlier_version_lists_were_not_there(tmp_path: Path) -> None:
    file = with_table(tmp_path, '[baseline]\nrecords = ["a.csv"]\nwithout = ["presliding"]')
    baseline = read_actuator(file).baseline
    assert baseline is not None and baseline.before == (("effects.presliding.stretch_rad", 0.0),)


def test_an_effect_that_is_set_by_hand_loses_nothing_of_the_file(tmp_path: Path) -> None:
    unit = copied(tmp_path / "unit", *RUNS)
    assert run_ema("add", unit, "winding_heating", "--set", "rise_degC=30", "-o", tmp_path / "hot.toml").code == 0
    hot = read_actuator(tmp_path / "hot.toml")
    assert [Path(file).resolve() for file in hot.healthy] == [(tmp_path / "unit" / name).resolve() for name in RUNS]
    assert hot.baseline is not None and hot.baseline.before is None


def test_a_baseline_record_that_has_changed_is_named(tmp_path: Path) -> None:
    unit = copied(tmp_path / "unit", *RUNS, "worn.csv")
    shutil.copy(UNIT / RUNS[0], tmp_path / "unit" / RUNS[1])
    assert f"{RUNS[1]}: its content is not that of the baseline record" in complaint(
        run_ema("compare", unit, tmp_path / "unit" / "worn.csv")
    )


def test_a_run_that_is_no_record_any_more_is_named(tmp_path: Path) -> None:
    unit = copied(tmp_path / "unit", *RUNS, "worn.csv")
    (tmp_path / "unit" / RUNS[0]).write_text("time_s\n0\n", encoding="utf-8")
    assert RUNS[0] in complaint(run_ema("identify", unit, tmp_path / "unit" / "worn.csv"))


@pytest.mark.slow
def test_identify_decides_beside_them_without_being_asked(tmp_path: Path) -> None:
    """By the file alone the sound unit's standing residual is an unknown effect."""
    unit = copied(tmp_path / "unit", *RUNS, "sound.csv")
    beside = run_ema("identify", unit, UNIT / "sound.csv", "--json", tmp_path / "beside.json")
    assert "compared with the baseline records of unit.toml: healthy_1.csv, healthy_2.csv, healthy_3.csv" in beside.out
    said = json.loads((tmp_path / "beside.json").read_text(encoding="utf-8"))
    assert said["verdict"] == "healthy"
    assert said["provenance"]["healthy"] == ", ".join(RUNS)
    for name in RUNS:
        (tmp_path / "unit" / name).unlink()
    alone = run_ema("identify", unit, UNIT / "sound.csv", "--json", tmp_path / "alone.json")
    assert "compared with the baseline records" not in alone.out
    assert json.loads((tmp_path / "alone.json").read_text(encoding="utf-8"))["verdict"] == "undecided"
