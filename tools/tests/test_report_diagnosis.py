"""A diagnosis beside other results on one page: everything that the result holds stands there, in the order of the questions, and what it lacks is left out. Its own page: test_diagnosis_page."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import pytest

from ema_tools.base.errors import InputError
from ema_tools.compare.localisation import where
from ema_tools.compare.unexplained import learned, left_over
from ema_tools.compare.validity import judge
from ema_tools.data.actuator import reference_actuator
from ema_tools.data.records import simulated
from ema_tools.results.codec import to_json
from ema_tools.results.diagnosis import DiagnosisResult
from ema_tools.results.parts import EffectEntry, StepEntry, WeightedErrors
from ema_tools.results.provenance import curves
from ema_tools.words.answers.localisation import localisation
from ema_tools.words.answers.unexplained import unexplained
from ema_tools.words.answers.validity import validity
from ema_tools.words.page import diagnosis, diagnosis_figures, write_report
from ema_tools.words.page.diagnosis_results import Diagnosed
from ema_tools.words.page.figure_svg import figure_svg
from ema_tools.words.page.results import parse_result
from repeated_runs import WIDE, measured, repeats
from report_results import identified
from shared_results import shared_result
from test_report_page import _structure, _without_scripts

HIDDEN = {"effects.jam_spot.amplitude_Nm": 0.1, "effects.jam_spot.place_mm": 2.0, "effects.jam_spot.width_mm": 1.5}


@shared_result
def _made() -> str:
    """A whole result as text: gate, where and unknown of a record, with a ranking and steps as the search gives them."""
    model, record = reference_actuator(), measured(HIDDEN, 99, WIDE)
    place = where(model, record, repeats(WIDE))
    unknowns = left_over(model, record, place)
    jam = EffectEntry(
        name="jam_spot",
        alike=("jam_spot",),
        parameters={"amplitude_Nm": 0.1},
        std={"amplitude_Nm": 0.002},
        score=5000.0,
        limit=60.0,
        accepted=True,
    )
    ripple = EffectEntry(
        name="pitch_ripple",
        alike=("pitch_ripple", "spring_load"),
        parameters={"ratio": 0.2},
        score=900.0,
        limit=60.0,
        accepted=False,
        reason="explains less",
    )
    load = EffectEntry(name="constant_load", score=0.0, limit=60.0, accepted=False)
    found = DiagnosisResult(
        name="today.csv",
        verdict="missing",
        sentence="jam_spot explains what the record shows beyond the repeats.",
        effects=(jam, ripple, load),
        error=WeightedErrors(3.2, 1.05, 1.0, 3.4, 1.1),
        next_experiment="A slow triangle over two leads separates jam_spot from pitch_ripple.",
        gate=validity(judge(model, record, repeats(WIDE))),
        where=localisation(place),
        unknown=unexplained(unknowns, learned(unknowns[0])),
        steps=(StepEntry(("constant_load",), "constant_load", 2.9, 3.6), StepEntry(("constant_load", "jam_spot"), "jam_spot", 1.05, 1.1)),
        curves=curves(record, before=simulated(model, record), after=simulated(model.changed(HIDDEN), record)),
        provenance={"command": "ema diagnose mine.toml today.csv"},
    )
    return json.dumps(to_json(found), allow_nan=False)


def made(**changes: Any) -> dict[str, Any]:
    """The whole result; `changes` replace keys, Ellipsis removes one."""
    data = {**json.loads(_made()), **changes}
    return {key: value for key, value in data.items() if value is not ...}


def parsed(data: dict[str, Any]) -> Diagnosed:
    found = parse_result(data, "today.json", "today")
    assert isinstance(found, Diagnosed)
    return found


def page(folder: Path, *results: dict[str, Any]) -> str:
    files = []
    for place, data in enumerate(results):
        files.append(folder / f"result_{place}.json")
        files[-1].write_text(json.dumps(data), encoding="utf-8")
    write_report(files, folder / "page.html", "ema report", force=True)
    return (folder / "page.html").read_text(encoding="utf-8")


def words(html: str) -> str:
    return " ".join("".join(_structure(_without_scripts(html)).texts).replace("\u00a0", " ").split())


def test_page_answers_in_the_order_of_the_questions(tmp_path: Path) -> None:
    text = words(page(tmp_path, made(), identified()))
    asked = [
        "2 results: a fault in 1 and an effect missing in 1.",
        "The model does not hold. Jam spot is missing.",
        "Can this record answer?",
        "Where does the model fail?",
        "Which effect is missing?",
        "Does the error fall?",
        "What to measure next",
    ]
    places = [text.index(question) for question in asked]
    assert places == sorted(places)
    for said in (
        "jam_spot explains what the record shows beyond the repeats.",
        "lies in the mechanical balance",
        "jam_spot.amplitude_Nm = 0.1000 Nm [95 %: 0.0961 … 0.1039]",
        "explains less",
        "separates jam_spot from pitch_ripple",
        "Pitch ripple pitch_ripple",
        "ema diagnose mine.toml today.csv",
    ):
        assert said in text, said
    assert text.count("jam_spot explains what the record shows beyond the repeats.") == 1
    assert "What is it that the library does not hold?" not in text


def test_page_is_well_formed_beside_other_results(tmp_path: Path) -> None:
    html = page(
        tmp_path, made(), identified(), made(name="</script><b>", verdict="unknown"), made(verdict="adequate", effects=[], steps=[])
    )
    found = _structure(_without_scripts(html))
    assert found.problems == [] and found.open == []
    assert len(found.identities) == len(set(found.identities))
    assert set(found.references) <= set(found.identities)
    assert html.count("<script") == 3
    assert html.count('<svg class="picture"') > 20
    assert len(html.encode()) < 1_500_000


def test_unknown_is_drawn_with_what_can_be_flown(tmp_path: Path) -> None:
    text = words(page(tmp_path, made(verdict="unknown", effects=[], steps=[]), identified()))
    assert "No effect of the library explains it: " in text
    assert "The unknown torque on the shaft repeats with position, against the motion" in text
    assert "Over position, against the motion:" in text and "learned friction (learned_friction), a table over position" in text


def test_adequate_and_bare_results_are_shown(tmp_path: Path) -> None:
    bare = {"command": "diagnose", "verdict": "adequate", "error": {"before": 1.0, "floor": 1.0, "after": None}}
    html = page(tmp_path, bare, bare)
    assert (
        "2 results: nothing missing in 2." in words(html)
        and words(html).count("The model holds: nothing is missing.") == 2
        and 'class="curves"' not in _without_scripts(html)
    )
    assert "Which effect is missing?" not in words(html)


def test_addition_is_shown_with_its_fall(tmp_path: Path) -> None:
    added = {
        "command": "add", "effect": "jam_spot", "actuator": "new.toml", "name": "today.csv", "error": {"before": 3.2, "after": 1.05, "floor": 1.0, "holdout_before": 3.0, "holdout_after": 3.3},
        "parameters": {"effects.jam_spot.width_mm": {"value": 2.0, "std": 0.01, "at_bound": True}}, "recommended": False, "reason": "width_mm lies on its bound",
    }  # fmt: skip
    text = words(page(tmp_path, added, identified()))
    assert "Jam spot is in the model: the error falls from 3.20 to 1.05." in text
    assert (
        "jam_spot.width_mm = 2.000 mm [95 %: 1.980 … 2.020] (at its bound)" in text
        and "not recommended: width_mm lies on its bound" in text
    )


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"verdict": "perhaps"}, "field verdict is none of adequate, missing, unknown"),
        ({"error": ...}, "field error is missing"),
        ({"effects": [{"name": "x", "score": 1.0}]}, "field effects[0].limit is missing"),
        ({"effects": "none"}, "field effects is not a list of objects"),
        ({"steps": [{"effects": ["x"], "added": "x"}]}, "field steps[0].error_training is missing"),
        ({"gate": {"remarks": [{"severity": "bad"}]}}, "field gate.remarks[0].severity is none of blocks, weakens, fine"),
        (
            {"where": {"pictures": {"bins": [{"center": [1.0], "mean": ["a"]}]}}},
            "field where.pictures.bins[0].mean is not a list of numbers",
        ),
    ],
)
def test_bad_field_is_named(change: dict[str, Any], expected: str) -> None:
    with pytest.raises(InputError) as caught:
        parsed(made(**change))
    assert str(caught.value).startswith(f"today.json: {expected}")


def test_figures_are_drawn_with_roles() -> None:
    found = parsed(made())
    drawn = [
        diagnosis_figures.ranking(found),
        diagnosis_figures.waterfall(found),
        *map(diagnosis_figures.picture, (*found.pictures, *found.unknown_pictures)),
    ]
    assert len(drawn) > 20
    for figure in drawn:
        svg = figure_svg(figure, "f")
        assert "nan" not in svg and ElementTree.fromstring(svg).attrib["aria-label"] == figure["label"]
        assert figure["label"] and all("role" in trace["meta"] for trace in figure["data"])


def test_waterfall_falls_to_the_floor_with_its_twin() -> None:
    traces = {trace["name"]: trace for trace in diagnosis_figures.waterfall(parsed(made()))["data"]}
    assert traces["left"]["y"] == [3.2, 2.9, 1.05]
    assert traces["taken off"]["y"] == pytest.approx([0.3, 1.85]) and traces["taken off"]["base"] == [2.9, 1.05]
    assert traces["held-out record"]["y"] == [3.4, 3.6, 1.1]
    assert set(traces["floor"]["y"]) == {1.0}


def test_values_of_the_last_model_are_stated_once_with_their_errors(tmp_path: Path) -> None:
    """As `ema diagnose` writes them: numbers, and std and bounds beside; the model as given is the first model and no step."""
    jam = {
        "name": "jam_spot",
        "class": [],
        "parameters": {"amplitude_Nm": 0.1, "width_mm": 2.0},
        "std": {"amplitude_Nm": 0.002, "width_mm": 0.01},
        "at_bound": ["width_mm"],
    }
    worn = {
        "name": "csj",
        "class": [],
        "parameters": {"csj_Nm": 0.2},
        "std": {"csj_Nm": 0.0003},
        "at_bound": [],
        "score": 80.0,
        "limit": 60.0,
        "accepted": True,
    }
    steps = (([], "as given", 3.2), ([], "what scatters", 2.0), (["csj", "jam_spot"], "jam_spot", 1.05))
    given, moved, last = (
        {"effects": names, "added": added, "error_training": error, "error_holdout": None} for names, added, error in steps
    )
    data = made(effects=[{**jam, "score": 5000.0, "limit": 60.0, "accepted": True}], faults={"csj": worn}, steps=[given, moved, last])
    found = parsed(data)
    assert [step.added for step in found.steps] == ["what scatters", "jam_spot"] and found.steps[0].values == ()
    text = words(page(tmp_path, data, identified()))
    assert (
        text.count("jam_spot.amplitude_Nm = 0.1000 Nm [95 %: 0.0961 … 0.1039]") == 1
        and text.count("amplitude_Nm = 0.1000 Nm [95 %: 0.0961 … 0.1039]") == 2
        and text.count("width_mm = 2.000 mm [95 %: 1.980 … 2.020] (at its bound)") == 2
    )
    assert text.count("screw.csj_Nm = 0.2000 Nm [95 %: 0.1994 … 0.2006]") == 1
    assert "recommended" not in text.split("Does the error fall?")[1].split("From the first model")[0]
    assert diagnosis_figures.waterfall(found)["data"][0]["x"] == [
        "first model<br><b>3.20</b>",
        "+ what scatters<br><b>2.00</b>",
        "+ jam_spot<br><b>1.05</b>",
    ]


def test_ranking_shows_scores_over_their_limit() -> None:
    traces = {trace.get("name"): trace for trace in diagnosis_figures.ranking(parsed(made()))["data"]}
    assert traces["accepted"]["x"] == pytest.approx([5000.0 / 60.0], rel=1e-4) and traces["accepted"]["y"] == ["jam_spot"]
    assert traces["not accepted"]["x"] == pytest.approx([15.0, 0.01])


def test_every_picture_of_where_reaches_the_page() -> None:
    found = parsed(made())
    sources = {one.source for one in found.pictures}
    assert {
        "mechanical",
        "electrical",
        "kinematic",
        "controller",
        "torque without inertia",
        "play loop",
        "torque loop",
        "mechanical order",
    } <= sources
    worst = [one for one in found.pictures if one.source == "mechanical"]
    assert {one.by for one in worst} == {
        "speed",
        "position",
        "place in the lead",
        "motor angle",
        "current",
        "acceleration",
        "time since reversal",
        "time",
    }
    assert max(worst, key=diagnosis._unevenness).by in ("position", "time", "time since reversal")


@pytest.mark.slow
def test_long_names_and_missing_parts_do_not_break_the_page(tmp_path: Path) -> None:
    for key in ("gate", "where", "unknown", "steps", "curves", "provenance", "next_experiment", "sentence", "name", "effects"):
        for html in (page(tmp_path, made(**{key: ...}), identified()), page(tmp_path, made(**{key: ...}))):
            assert _structure(_without_scripts(html)).problems == []
