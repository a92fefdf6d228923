"""The benchmark of the annealer's settings, with few of them; the whole writes docs/ROBUSTNESS.md."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from benchmarks.robustness.__main__ import main
from benchmarks.robustness.design import FACTORS, drawn, one_at_a_time
from benchmarks.robustness.document import written
from benchmarks.robustness.trials import perform, warnings_of
from ema_tools.data.actuator import reference_actuator
from ema_tools.tasks.onboard_search import search_warnings
from support import RECORDINGS, REFERENCE, run_ema

pytestmark = pytest.mark.release


def test_a_few_settings_are_searched_and_written(tmp_path: Path) -> None:
    arguments = ["--settings", "2", "--records", "0", "--effects", "none", "--workers", "0", "-o", str(tmp_path / "rows")]
    ran = CliRunner().invoke(main, [*arguments, "--document", str(tmp_path / "page.md")])
    assert ran.exit_code == 0, ran.output
    rows = [json.loads(line) for part in (tmp_path / "rows" / "parts").iterdir() for line in part.read_text().splitlines()]
    assert {(row["design"], len(row["found"])) for row in rows} == {("sensible", 4), ("any", 2)}
    for row in rows:
        # a machine that the model knows and no hidden effect: the lowest point is the truth, but for the noise
        assert row["cost"] == pytest.approx(10_000 * 0.001 * row["noise_mm"] ** 2, rel=0.05, abs=1e-9)
        if row["design"] == "sensible":
            assert all(one["reached"] and one["runs"] <= 600 for one in row["found"])
    text = (tmp_path / "page.md").read_text(encoding="utf-8")
    assert "within 600 model runs: **met**, 100.00 % of 8 searches" in text
    # a run that goes on searches nothing anew
    parts = {part: part.read_bytes() for part in (tmp_path / "rows" / "parts").iterdir()}
    assert CliRunner().invoke(main, arguments).exit_code == 0
    assert parts == {part: part.read_bytes() for part in parts}


def test_a_setting_that_cannot_work_fails_is_warned_of_and_is_listed() -> None:
    good = drawn("sensible", 1, 2, ("none",))[0]
    bad = replace(good, cooling=0.995, evaluation_budget=120)
    row = {**perform(bad), "warnings": warnings_of(bad)}
    assert warnings_of(good) == []
    assert not any(one["reached"] for one in row["found"])
    assert [text.partition(":")[0] for text in row["warnings"]] == ["the evaluations are used up before the search is cold"]
    text = written([row], "")
    assert "within 600 model runs: **not met**, 0.00 % of 2 searches" in text
    assert "**met**, 0 failed without a warning" in text
    silent = written([{**row, "warnings": [], "found": [{**one, "said": False} for one in row["found"]]}], "")
    assert "**not met**, 2 failed without a warning" in silent
    assert silent.count(f"| {row['effect']}, {row['fault']} | inside |") == 2


def test_designs_fill_their_ranges_and_move_one_setting_at_a_time() -> None:
    for design in ("sensible", "any"):
        settings = drawn(design, 64, 1)
        assert len({setting.key for setting in settings}) == 64
        for name, factor in FACTORS.items():
            ends = factor.sensible if design == "sensible" else factor.all
            values = [1.0 - setting.cooling if name == "hotter" else getattr(setting, name) for setting in settings]
            inside = [value for value in values if 0.49 * ends[0] <= value <= 1.01 * ends[1]]
            assert len(inside) == len(values) or name == "noise_mm"
            if ends[0] < ends[1]:
                middle = (ends[0] * ends[1]) ** 0.5
                assert 0.4 <= sum(value < middle for value in values) / 64 <= 0.6 or name == "noise_mm"
    shipped, *moved = one_at_a_time(1, 1)
    actuator = reference_actuator()
    assert all(actuator[name] == value for name, value in shipped.changes.items())
    for setting in moved:
        assert sum(setting.changes[name] != value for name, value in shipped.changes.items()) == 1, setting.moved


def test_shipped_settings_have_no_warning_and_others_are_said_in_one_line(tmp_path: Path) -> None:
    actuator = reference_actuator()
    assert search_warnings(actuator) == ()
    assert search_warnings(actuator.changed({"search.day_values": 1})) == ()
    hot = tmp_path / "hot.toml"
    actuator.changed({"search.cooling": 0.99, "search.reanneal_interval": 3}).write(hot)
    asked = ("identify", hot, RECORDINGS / "case_a.csv", "--no-guard", "--json", tmp_path / "i.json")
    for ran in (run_ema(*asked), run_ema("export", hot, "-o", tmp_path / "a.h", "--json", tmp_path / "e.json")):
        assert ran.code == 0, ran.err
        (line,) = ran.err.splitlines()
        assert line.startswith(f"ema: {hot}: [search]: the evaluations are used up before the search is cold: raise evaluation_budget")
        assert "; reanneal_interval is so short" in line
    for name in ("i", "e"):
        assert len(json.loads((tmp_path / f"{name}.json").read_text(encoding="utf-8"))["warnings"]) == 2
    quiet = run_ema("export", REFERENCE, "-o", tmp_path / "b.h", "--json", tmp_path / "b.json")
    assert quiet.err == "" and "warnings" not in json.loads((tmp_path / "b.json").read_text(encoding="utf-8"))
