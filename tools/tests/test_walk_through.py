"""docs/WALK_THROUGH.md tells the truth: its commands, their output, its pictures."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from demo_run import demo_run
from ema_tools.base.errors import InputError
from ema_tools.words.page.pictures import write_pictures
from shown_output import WALK_THROUGH as DOCUMENT
from shown_output import missing_from, renewed, shown_by_walk
from support import complaint, run_ema


@pytest.mark.slow
def test_output_is_what_the_commands_print() -> None:
    assert [missing_from(block, real) for block, real in shown_by_walk()] == [""] * 13


def test_words_and_numbers_are_held_against_the_output() -> None:
    real = "missing is stribeck_friction (rise 0.2993 [95 %: 0.2956 .. 0.3030]); floor 0.864\nfound in 0.05 s at 1.3e-15"
    assert missing_from("missing is\nstribeck_friction (rise 0.2994 … floor 0.863 found in 0.07 s", real) == ""
    assert missing_from("1.3e-15", real) == ""
    assert missing_from("BLK +1.0 %", "BLK +0.8 %") != ""
    assert missing_from("2 of 3", "1 of 3") != ""
    assert missing_from("BLK +0.2 %", "BLK +0.1 %") == ""
    assert missing_from("BLK +0.3 %", "BLK +0.1 %") != ""
    assert missing_from("BLK +0.20 %", "BLK +0.10 %") != ""
    for shown in (
        "missing is presliding",
        "(rise 0.3993",
        "[95 %: 0.2556",
        "floor 0.864 … stribeck_friction",
        "floor 0.864 in",
        "at 1.3e-12",
    ):
        assert missing_from(shown, real) != "", shown


def test_numbers_are_renewed_and_words_are_not() -> None:
    shown_before, real = "found\n  0.864 in 0.07 s … BLK  +1.0 %", "found 0.91 in 0.05 s of all that is there BLK +2.0 %"
    assert renewed(shown_before, real) == "found\n  0.91 in 0.07 s … BLK  +2.0 %"
    with pytest.raises(ValueError, match="really 'is'"):
        renewed("found 0.864 … that was", real)


@pytest.mark.slow
def test_pictures_are_those_of_the_demo(tmp_path: Path) -> None:
    """Words alike, every drawn number within a pixel or two."""
    made = write_pictures(demo_run()[0] / "diagnose.json", tmp_path, "walk")
    assert {path.name for path in made} == set(re.findall(r"\((walk_\w+\.svg)\)", DOCUMENT.read_text(encoding="utf-8")))
    for path in made:
        new, shipped = (file.read_text(encoding="utf-8") for file in (path, DOCUMENT.with_name(path.name)))
        say = f"{path.name}: run build/venv/bin/python -m ema_tools.words.page.pictures build/demo/diagnose.json docs walk"
        number = r"-?\d+\.?\d*"
        assert re.sub(number, "#", new) == re.sub(number, "#", shipped), say
        for one, other in zip(re.findall(number, new), re.findall(number, shipped), strict=True):
            assert float(one) == pytest.approx(float(other), rel=0.02, abs=2.0), say


@pytest.mark.slow
def test_a_result_that_cannot_be_drawn_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"case_a\.json: no diagnosis with curves before and after"):
        write_pictures(demo_run()[0] / "case_a.json", tmp_path, "x")
    assert list(tmp_path.iterdir()) == []


def test_links_and_truth_stand_in_the_document() -> None:
    text = DOCUMENT.read_text(encoding="utf-8")
    for link in re.findall(r"\]\(([^)#]+)[^)]*\)", text):
        assert (DOCUMENT.parent / link).is_file(), link


@pytest.mark.slow
def test_report_writes_the_pictures_beside_the_page(tmp_path: Path) -> None:
    result = demo_run()[0] / "diagnose.json"
    asked = ("report", result, "-o", tmp_path / "p.html", "--pictures", tmp_path / "pictures")
    assert run_ema(*asked).code == 0
    kinds = ("signals", "where", "candidates", "ladder", "friction")
    assert {path.name for path in (tmp_path / "pictures").iterdir()} == {
        f"diagnose_{kind}.{ending}" for kind in kinds for ending in ("svg", "png")
    }
    (tmp_path / "p.html").unlink()
    assert "diagnose_signals.svg: exists already" in complaint(run_ema(*asked))
    assert not (tmp_path / "p.html").exists()
