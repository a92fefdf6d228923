"""The objective round an answer: profiles and map are the module's own objective, the path is the search's, and a record that does not determine a value is said to."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest

from ema_tools.data.actuator import reference_actuator
from ema_tools.data.records import write_record
from ema_tools.plant.native import library
from ema_tools.tasks.identify import Identified, identify
from ema_tools.tasks.objective_shape import Shape, shape_of
from ema_tools.words.answers.identification import identification
from ema_tools.words.page import figures
from ema_tools.words.page.figure_svg import figure_svg
from ema_tools.words.page.results import identified
from ema_tools.words.sentences.identification import undetermined_words
from shared_results import shared_result
from support import REFERENCE, chirp_record, run_ema

WORN = {"screw.csj_Nm": 0.2, "screw.blk_mm": 0.05}


@shared_result
def answered(noise_mm: float, day: bool = False) -> tuple[Identified, Shape]:
    actuator = reference_actuator().changed({"search.day_values": float(day), "search.evaluation_budget": 800.0})
    record = chirp_record(actuator.changed(WORN)).with_noise({"position_mm": noise_mm}, 3)
    found = identify(actuator, record, guarding=False)
    return found, shape_of(found)


@pytest.mark.parametrize("day", [False, True])
def test_a_profile_is_lowest_at_the_estimate_and_lies_on_no_cut(day: bool) -> None:
    found, shape = answered(0.005, day)
    for one, profile in zip(found.answer.identified, shape.profiles, strict=True):
        place = int(np.argmin(profile.objective))
        assert abs(profile.values[place] - one.estimate) <= 2.0 * one.std
        assert np.min(profile.objective) == pytest.approx(found.answer.objective_after, rel=0.01)
        assert np.min(profile.objective) < profile.limit < profile.objective[0]
        assert len(profile.values) <= 25
        others = {other.name: other.estimate for other in (*found.answer.identified, *found.answer.day)}
        for value, objective in list(zip(profile.values, profile.objective, strict=True))[::4]:
            machine = found.healthy.changed({**others, one.name: float(value)})
            cut = library(found.precision).objective(*machine.arrays(), found.seen.command_mm, found.seen.table())
            assert objective <= cut * (1.0 + 1e-9)
    # sensor noise alone: the profile crosses its limit where 1.96 standard errors of the search lie
    csj = shape.profiles[0]
    inside = csj.values[csj.objective <= csj.limit]
    assert float(np.ptp(inside)) <= 2.5 * 1.96 * 2.0 * found.answer.identified[0].std


def test_the_map_holds_both_and_the_path_is_the_searchs() -> None:
    found, shape = answered(0.005)
    surface = shape.surface
    assert surface is not None
    down, across = np.unravel_index(int(np.argmin(surface.objective)), surface.objective.shape)
    assert surface.values[0][across] == pytest.approx(found.answer.identified[0].estimate, rel=1e-6)
    assert surface.values[1][down] == pytest.approx(found.answer.identified[1].estimate, rel=1e-6)
    for values, one in zip(surface.values, found.answer.identified, strict=True):
        assert values[0] < found.healthy[one.name] < values[-1] and values[0] < one.estimate < values[-1]
    # the least squares show one point for three model runs
    assert 3 * len(shape.cost) >= 0.95 * found.answer.evaluations
    best = int(np.argmin(shape.cost))
    for one in found.answer.identified:
        tried = shape.tried[one.name]
        assert tried[0] == pytest.approx(found.healthy[one.name], rel=1e-5)
        assert tried[best] == pytest.approx(one.estimate, rel=1e-5)
    assert shape.undetermined == ()


def test_the_page_draws_them() -> None:
    found, shape = answered(0.005)
    shown = identified(identification(found, "today.csv", {}, None, shape), "today.json", "today")
    assert list(shown.profiles) == ["csj_Nm", "blk_mm"] and shown.map is not None
    for place, drawn in enumerate((figures.profiles(shown), figures.surface(shown))):
        svg = figure_svg(drawn, f"figure-{place}")
        assert "nan" not in svg and ElementTree.fromstring(svg).attrib["aria-label"] == drawn["label"]
    contour = figures.surface(shown)["data"][0]
    assert np.shape(contour["z"]) == (len(contour["y"]), len(contour["x"]))
    low, high = shown.faults["csj_Nm"].interval or (0.0, 0.0)
    assert low < shown.faults["csj_Nm"].estimate < high


def test_a_record_that_does_not_determine_a_value_is_said_to(tmp_path: Path) -> None:
    write_record(tmp_path / "rough.csv", chirp_record(reference_actuator().changed(WORN)).with_noise({"position_mm": 1.5}, 3))
    ran = run_ema("identify", REFERENCE, tmp_path / "rough.csv", "--no-guard", "--json", tmp_path / "i.json")
    assert ran.code == 0, ran.err
    written = json.loads((tmp_path / "i.json").read_text(encoding="utf-8"))
    assert list(written["undetermined"]) == ["blk_mm"]
    told = written["undetermined"]["blk_mm"]
    assert told.startswith("This record does not determine BLK: ") and told in ran.out
    assert run_ema("report", tmp_path / "i.json", "-o", tmp_path / "i.html").code == 0
    page = (tmp_path / "i.html").read_text(encoding="utf-8")
    assert "This record does not determine BLK" in page and "The error along each parameter" in page and "the way of the search" in page


def test_where_nothing_moves_nothing_is_determined() -> None:
    """A command inside the dead zone of friction: the objective is the same for all that was searched."""
    actuator = reference_actuator()
    record = chirp_record(actuator, "chirp:amplitude_mm=0.002,start_hz=0.1,end_hz=1").with_noise({"position_mm": 0.005}, 3)
    found = identify(actuator, record, guarding=False)
    shape = shape_of(found)
    assert found.verdict == "undecided"
    assert {one.name for one in shape.undetermined} == {"screw.csj_Nm", "screw.blk_mm"}
    assert {undetermined_words(one)[:33] for one in shape.undetermined} == {
        "This record does not determine CS",
        "This record does not determine BL",
    }


def test_a_map_is_made_when_it_is_wanted() -> None:
    found, _ = answered(0.005)
    assert shape_of(found, mapped=False).surface is None
