"""The demo, from the shipped recordings to its page."""

from __future__ import annotations

import io
import json
from pathlib import Path

import pytest
from rich.console import Console

from ema_tools import demo
from ema_tools.benchmarks.accuracy import TRUTH_LIMIT_PERCENT
from ema_tools.cases import CASES
from ema_tools.errors import InputError


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """Folder of one demo and what it printed."""
    folder = tmp_path_factory.mktemp("demo")
    printed = io.StringIO()
    demo.run(Console(file=printed, width=120, soft_wrap=True), folder)
    return folder, printed.getvalue()


def test_says_what_the_record_carries(made: tuple[Path, str]) -> None:
    folder, printed = made
    first = printed.splitlines()[0]
    result = json.loads((folder / "case_a.json").read_text(encoding="utf-8"))
    assert first.startswith("This recorded chirp of the reference actuator carries CSJ +117.4 % and BLK +25.0 %.")
    assert f"with {result['evaluations']} model runs" in first and "position error 0.675 → " in first
    assert printed.rstrip().endswith(str(folder / "report.html"))


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
    assert 4_000_000 < len(page) < 8_000_000
    assert page.count(b'data-model="before"') == page.count(b'data-model="after"') == 4


def test_again_overwrites(made: tuple[Path, str]) -> None:
    page = demo.run(Console(file=io.StringIO()), made[0])
    assert page == made[0] / "report.html"


def test_absent_recording_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(demo, "recordings_folder", lambda: tmp_path)
    with pytest.raises(InputError, match=r"case_a\.csv: not in .*: run the demo from a checkout"):
        demo.run(Console(file=io.StringIO()), tmp_path / "out")
    assert not (tmp_path / "out" / "report.html").exists()
