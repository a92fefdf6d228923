"""The demo, from the shipped recordings to its page: the story of a missing effect, then the paper's cases."""

from __future__ import annotations

import io
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from benchmarks.accuracy import TRUTH_LIMIT_PERCENT
from benchmarks.truth import recordings, scattered
from demo_run import demo_run
from ema_tools.base.errors import InputError
from ema_tools.cli import cli, demo
from ema_tools.data import own_unit, story
from ema_tools.data.actuator import read_actuator
from ema_tools.data.cases import CASES
from ema_tools.data.records import read_record
from ema_tools.tasks.export import header_text

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def made() -> tuple[Path, str]:
    """Folder of one demo and what it printed."""
    return demo_run()


def _result(made: tuple[Path, str], name: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((made[0] / name).read_text(encoding="utf-8"))
    return found


def test_the_effect_is_found_where_it_is_with_its_size(made: tuple[Path, str]) -> None:
    found = _result(made, "diagnose.json")
    assert found["verdict"] == "missing"
    accepted = [one for one in found["effects"] if one["accepted"]]
    assert [one["name"] for one in accepted] == [story.EFFECT] and accepted[0]["class"] == [story.EFFECT]
    true = story.EFFECT_VALUES["stribeck_friction.rise"]
    assert abs(accepted[0]["parameters"]["rise"] - true) < 3.0 * accepted[0]["std"]["rise"] < 0.05 * true
    assert set(found["faults"]) == {"csj", "blk"}
    assert "mechanical balance" in found["where"]["sentence"]


def test_the_error_falls_to_the_floor_and_on_the_record_held_out(made: tuple[Path, str]) -> None:
    for name in ("diagnose.json", "add.json"):
        error = _result(made, name)["error"]
        assert error["before"] > 20.0 and error["after"] < 1.05 * error["floor"]
        assert error["holdout_before"] > 20.0 and error["holdout_after"] < 1.2 * error["floor"]


def test_faults_are_right_with_the_effect_and_not_reported_without(made: tuple[Path, str]) -> None:
    before, after = (_result(made, f"identify_{when}.json") for when in ("before", "after"))
    assert before["verdict"] == "undecided" and before["adequate"] is False and before["reasons"]
    assert (
        abs(before["csj_Nm"]["shift_percent"] - story.CSJ_SHIFT_PERCENT) > 5.0
        and abs(before["blk_mm"]["shift_percent"] - story.BLK_SHIFT_PERCENT) > 20.0
    )
    assert after["verdict"] == "fault" and after["adequate"] is True and after["reasons"] == []
    # the mean of five healthy runs, and today's, scatter by 0.4 %
    assert after["csj_Nm"]["shift_percent"] == pytest.approx(story.CSJ_SHIFT_PERCENT, abs=1.5)
    assert after["blk_mm"]["shift_percent"] == pytest.approx(story.BLK_SHIFT_PERCENT, abs=3.0)


def test_the_machine_written_is_the_healthy_one_with_the_effect(made: tuple[Path, str]) -> None:
    machine = read_actuator(made[0] / "machine.toml")
    assert machine.active_effects == (story.EFFECT, *(name for name in machine.active_effects if name != story.EFFECT))
    assert machine["screw.csj_Nm"] == pytest.approx(story.UNIT["screw.csj_Nm"], rel=0.01)
    assert machine["screw.blk_mm"] == pytest.approx(story.UNIT["screw.blk_mm"], rel=0.03)


def test_the_flight_code_judges_the_other_unit_by_its_own_model(made: tuple[Path, str]) -> None:
    unit = read_actuator(made[0] / "unit.toml")
    assert set(_result(made, "calibrate.json")["own_machine"]["standing"]) == set(unit.active_effects) == {"pitch_ripple", "presliding"}
    assert unit["screw.csj_Nm"] == pytest.approx(own_unit.UNIT["screw.csj_Nm"], rel=0.02)
    assert unit["screw.blk_mm"] == pytest.approx(own_unit.UNIT["screw.blk_mm"], rel=0.02)
    answers = {day.name: _result(made, f"identify_{day.name}.json") for day in own_unit.LATER}
    assert [one["verdict"] for one in answers.values()] == ["healthy", "fault", "undecided"]
    assert answers["worn"]["csj_Nm"]["shift_percent"] == pytest.approx(own_unit.CSJ_SHIFT_PERCENT, abs=3.0)
    assert answers["worn"]["blk_mm"]["shift_percent"] == pytest.approx(own_unit.BLK_SHIFT_PERCENT, abs=3.0)
    # without its reasons the last would be a fault that is not there
    assert answers["hidden"]["csj_Nm"]["shift_percent"] > unit["verdict.csj_min_shift_percent"] and answers["hidden"]["reasons"]
    assert header_text(unit) == (made[0] / "ema_actuator_data.h").read_text(encoding="utf-8")


def test_every_step_shows_its_command(made: tuple[Path, str]) -> None:
    steps = [line.split()[:3] for line in made[1].splitlines() if re.match(r"\d+  ema ", line)]
    assert steps == [
        ["1", "ema", "compare"],
        ["2", "ema", "identify"],
        ["3", "ema", "diagnose"],
        ["4", "ema", "add"],
        ["5", "ema", "identify"],
        ["6", "ema", "calibrate"],
        ["7", "ema", "export"],
        ["8", "ema", "identify"],
        ["9", "ema", "identify"],
        ["10", "ema", "identify"],
    ]
    assert {step[2] for step in steps} <= set(cli.commands)
    assert made[1].rstrip().endswith("build/demo/report.html")


def test_story_recordings_are_reproduced_and_tell_nothing_else(tmp_path: Path) -> None:
    shipped = demo.recordings_folder() / "story"
    for path in recordings.write_story(tmp_path):
        assert path.read_bytes() == (shipped / path.name).read_bytes(), f"{path.name}: run python -m benchmarks.truth.recordings recordings"
        head = "".join(line for line in path.read_text(encoding="utf-8").splitlines() if line.startswith("#"))
        assert story.EFFECT not in head and "stiction" not in head.lower() and "CSJ" not in head
    assert {path.name for path in shipped.iterdir()} == {path.name for path in tmp_path.iterdir()}
    assert sum(path.stat().st_size for path in shipped.iterdir()) < 4 << 20


def test_story_recordings_are_of_one_command_and_one_unit() -> None:
    folder = demo.recordings_folder() / "story"
    today, held_out = (read_record(folder / f"{name}.csv") for name in (story.TODAY, story.HELD_OUT))
    healthy = [read_record(folder / f"{story.healthy_name(run)}.csv") for run in range(1, story.HEALTHY_RUNS + 1)]
    assert all(np.array_equal(one.command_mm, today.command_mm) for one in healthy)
    assert np.abs(held_out.command_mm - today.command_mm).max() > 1.0
    between = np.std(np.array([one.position_mm for one in healthy]), axis=0, ddof=1).mean()
    assert 0.0015 < between < 0.004 < 0.05 < np.sqrt(np.mean((today.position_mm - healthy[0].position_mm) ** 2))
    days = [scattered(run.values, story.SCATTER, run.seed)["screw.csj_Nm"] / run.values["screw.csj_Nm"] for run in recordings.story_runs()]
    assert len(set(days)) == len(days) and max(abs(day - 1.0) for day in days) < 0.01


def test_table_holds_every_case_beside_the_paper(made: tuple[Path, str]) -> None:
    rows = [line.split() for line in made[1].splitlines()]
    for case in CASES:
        row = next(row for row in rows if row[:2] == [case.letter, "CSJ"])
        assert str(case.paper_iterations) in row and f"{case.paper_wall_s:.0f}" in row


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.letter)
def test_results_are_right_and_keep_the_contract(made: tuple[Path, str], case: object) -> None:
    result = json.loads((made[0] / f"case_{case.letter.lower()}.json").read_text(encoding="utf-8"))
    for name, limit in zip(("csj_Nm", "blk_mm"), TRUTH_LIMIT_PERCENT, strict=True):
        assert set(result[name]) >= {"estimate", "std", "shift_percent"}
        assert abs(result[name]["shift_percent"] - case.shift_percent(name)) <= limit
    assert result["objective_after_mm2s"] < 1e-6 * result["objective_before_mm2s"]
    assert result["verdict"] == ("healthy" if case.letter == "C" else "fault")
    assert result["adequate"] is True and result["reasons"] == []
    assert len(result["search"]["cost_mm2s"]) <= result["evaluations"] <= 400


def test_noise_widens_the_stated_error_only(made: tuple[Path, str]) -> None:
    clean, noisy = (json.loads((made[0] / f"{name}.json").read_text(encoding="utf-8")) for name in ("case_a", "case_a_noisy"))
    for name in ("csj_Nm", "blk_mm"):
        assert noisy[name]["std"] > 100.0 * clean[name]["std"]
        assert abs(noisy[name]["estimate"] - clean[name]["estimate"]) < 4.0 * noisy[name]["std"]


def test_page_is_one_file_of_modest_size(made: tuple[Path, str]) -> None:
    page = (made[0] / "report.html").read_bytes()
    assert 1_000_000 < len(page) < 4_500_000
    # four of the story, three of the unit that the flight code judges, four of the cases
    assert page.count(b'data-model="before"') == page.count(b'data-model="after"') == 11
    places = [
        page.index(text)
        for text in (
            b"Which effect is missing?",
            b"Stribeck friction (stribeck_friction) added",
            b"the data sheet&#x27;s model",
            b'<section id="paper"',
        )
    ]
    assert places[0] < places[3] and places[2] < places[3]
    # what follows each result can be typed as it stands
    commands = re.findall(r'<code id="[^"]*" tabindex="0">(.*?)</code>', page.decode("utf-8"))
    assert len(commands) == 11 and not [one for one in commands if "ACTUATOR" in one or "RECORD" in one]


def test_absent_recording_is_named_before_any_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(demo, "recordings_folder", lambda: tmp_path / "recordings")
    (tmp_path / "actuators").mkdir()
    with pytest.raises(InputError, match=r"story/today\.csv: not in .*: run the demo from a checkout"):
        demo.run(Console(file=io.StringIO()), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_again_overwrites(made: tuple[Path, str], monkeypatch: pytest.MonkeyPatch) -> None:
    """Every file that the demo would write may be there already."""
    assert all(path.is_file() for path in demo.written(made[0]))
    before = (made[0] / "case_c.json").stat().st_mtime_ns
    monkeypatch.setattr(demo, "_tell_story", lambda *_: None)
    monkeypatch.setattr(demo, "_tell_flight", lambda *_: None)
    demo.run(Console(file=io.StringIO()), made[0])
    assert (made[0] / "case_c.json").stat().st_mtime_ns > before
