"""The page of one diagnosis: its sentence and five answers, the maps, the ladder, and that the file is whole, small and the same each time."""

from __future__ import annotations

import base64
import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from diagnosis_results import BINS, COMMAND, KINDS, diagnosis, diagnosis_page
from ema_tools.data.actuator import reference_actuator
from ema_tools.data.records import read_record
from ema_tools.results.diagnosis import DiagnosisResult
from ema_tools.results.reading import result_of
from ema_tools.tasks.workbench import bench
from ema_tools.words.advice import read_sizes, with_next
from ema_tools.words.command_line import CommandLine, line_of
from ema_tools.words.page import charts, comparison_page, first_screen, heat, names, sheet, signals, uplot
from ema_tools.words.page import diagnosis_page as page_of
from ema_tools.words.page import text as words
from ema_tools.words.page.diagnosis_results import Diagnosed
from ema_tools.words.page.results import ShownComparison, parse_result
from ema_tools.words.page.workbench import why_not
from report_results import compared_whole
from support import RECORDINGS
from test_report_page import _structure, _without_scripts


def parsed(data: dict[str, Any]) -> Diagnosed:
    found = parse_result(data, "today.json", "today")
    assert isinstance(found, Diagnosed)
    return found


def said(data: dict[str, Any]) -> sheet.FirstScreen:
    return first_screen.first_screen(parsed(data))


@pytest.mark.parametrize(
    ("kind", "sentence", "short"),
    [
        (
            "missing",
            "The model does not hold. Stribeck friction is missing; friction (CSJ) +45 %.",
            ("No", "Mechanics", "Stribeck friction", "48.0 → 0.860", "Put it into the model"),
        ),
        (
            "healthy",
            "The model holds. Nothing is missing, and nothing has changed.",
            ("Yes", "Nowhere", "Nothing", "0.880 → 0.870", "Read CSJ and BLK"),
        ),
        (
            "fault",
            "No effect is missing, but the machine has changed: friction (CSJ) +45 %.",
            ("Yes, worn", "Mechanics", "Nothing", "48.0 → 0.860", "Read CSJ and BLK"),
        ),
        (
            "unknown",
            "The model does not hold. No effect of the library explains it: none lowers the error, which is 9.2 times the noise.",
            ("No", "Mechanics", "Not in the library", "48.0, not explained", "Look at the pictures"),
        ),
    ],
)
def test_first_screen_answers(kind: str, sentence: str, short: tuple[str, ...]) -> None:
    found = said(diagnosis(kind))
    assert found.sentence == sentence
    assert tuple(one.short for one in found.replies) == short


@pytest.mark.parametrize("kind", ["missing", "fault"])
def test_what_another_form_leaves_stands_beside_what_was_found(kind: str) -> None:
    data = diagnosis(kind)
    assert "unexplained" not in said(data).replies[2].more
    more = {**data, "unexplained": 0.16, "error": {**data["error"], "after": 1.1 * data["error"]["floor"]}}
    assert "; 16 % of the excess stays unexplained" in said(more).replies[2].more
    # at the floor only chance is left
    assert "unexplained" not in said({**data, "unexplained": 0.16}).replies[2].more


def test_next_command_has_the_paths_that_were_given() -> None:
    last = said(diagnosis("missing")).replies[-1]
    assert (
        last.command
        == "ema add mine.toml stribeck_friction --fit today.csv --healthy 'runs/healthy *.csv' --holdout other.csv -o with_stribeck_friction.toml"
    )
    assert said(diagnosis("healthy")).replies[-1].command == "ema identify mine.toml today.csv --healthy 'runs/healthy *.csv'"
    line = line_of(COMMAND)
    assert line is not None and line.options["--json"] == ("d.json",)
    # as the shell expands a pattern
    many = line_of("ema diagnose a.toml today.csv --healthy h1.csv h2.csv h3.csv --force --json d.json")
    assert many is not None and many.records == ("today.csv",) and many.options["--healthy"] == ("h1.csv", "h2.csv", "h3.csv")
    assert many.again("--healthy", "--json") == ["--healthy", "h1.csv", "h2.csv", "h3.csv", "--json", "d.json"]
    behind = line_of("ema identify a.toml --healthy h1.csv h2.csv today.csv")
    assert behind is not None and (behind.actuator, behind.records, behind.options["--healthy"]) == (
        "a.toml",
        ("today.csv",),
        ("h1.csv", "h2.csv"),
    )
    before = line_of("ema diagnose --healthy h1.csv h2.csv a.toml today.csv")
    assert before is not None and (before.actuator, before.records, before.options["--healthy"]) == (
        "a.toml",
        ("today.csv",),
        ("h1.csv", "h2.csv"),
    )
    assert line_of("ema report x.json -o y.html") is None and line_of("ema 'unclosed") is None


def test_where_nothing_is_named_the_nearest_effects_are_and_how_far_off_they_are() -> None:
    data = diagnosis("unknown")
    (rival,) = data["effects"]
    data["effects"] = [rival, {**rival, "name": "supply_sag", "class": ["supply_sag"], "score": 0.5 * rival["score"]}]
    told = said(data).replies[2]
    tried = sorted((one.left, one.entry.name) for one in first_screen.candidates(parsed(data)) if one.left is not None)
    assert len(tried) >= 2 and data["error"]["floor"] > 0.0
    (left, name), (worse, other) = tried[:2]
    assert (
        f"nearest is {names.within(name)}, which leaves {words.number(left / data['error']['floor'], 2)} times the noise level" in told.more
    )
    far = f"{words.number(worse / left, 2)} times its error" if worse >= 1.05 * left else "hardly worse"
    assert f"next best {names.within(other)}, {far}" in told.more
    bare = said({**data, "effects": []}).replies[2]
    assert bare.more.endswith("no effect that was tried takes anything off")


def test_what_follows_a_model_that_holds_is_told_alike_on_every_page() -> None:
    read = said(diagnosis("healthy")).replies[-1]
    other = read_sizes("mine.toml", CommandLine("mine.toml", ("today.csv",), {}))
    assert (read.short, read.more) == (other.short, other.more)
    data = compared_whole()
    explained = {name: {**one, "excess_percent": 0.0} for name, one in data["balances"].items()}
    whole = parse_result({**data, "balances": explained}, "c.json", "c")
    assert isinstance(whole, ShownComparison)
    followed = comparison_page.first_screen(whole).replies[-1]
    assert (followed.question, followed.short, followed.more) == (read.question, read.short, read.more)


def test_a_rung_that_cannot_be_simulated_says_why() -> None:
    data = diagnosis("missing")
    data = {key: one for key, one in data.items() if key != "workbench"}
    page = page_of.render(parsed(data), "ema report")
    ladder = page[page.index('<section id="ladder"') :]
    ladder = ladder[: ladder.index("</section>")]
    rungs = len(data["steps"]) + (data["steps"][0]["added"] != "as given")
    assert "data-load" not in ladder and ladder.count('<small class="why">not simulated on this page</small>') == rungs
    assert "No rung can be loaded" in ladder
    assert why_not(None, {}, True) == "balance only, not simulated"


def test_a_record_that_cannot_answer_is_no_verdict() -> None:
    gate = {
        "answerable": False,
        "sentence": "This record cannot answer.",
        "remarks": [{"topic": "signals", "severity": "blocks", "text": "none", "next": "record the current"}],
    }
    found = said(diagnosis("missing", gate=gate))
    assert found.sentence == "This record cannot say whether the model holds."
    assert found.replies[0].short == "Cannot be told" and found.replies[-1].more == "record the current"


def test_effects_that_look_alike_are_to_be_told_apart_first() -> None:
    data = diagnosis("missing", rivals=["spring_load"])
    replies = said(data).replies
    assert replies[-1].command == "ema next mine.toml --between stribeck_friction spring_load"
    assert replies[2].more.endswith("; spring load equally well")
    found = result_of(data, "x")
    assert isinstance(found, DiagnosisResult)
    advised = with_next(found)
    # one advice: in the verdict, in what is printed and in both keys of JSON
    assert advised.next == (tuple(replies[-1].command.split()),)
    assert advised.next_experiment == f"Next: record what separates them: {replies[-1].command}"


def test_rivals_that_no_command_separates_leave_the_effect_to_be_added() -> None:
    effects = [
        {**one, "name": "constant_load", "class": ["constant_load", "coulomb_asymmetry"]} for one in diagnosis("missing")["effects"][:1]
    ]
    replies = said(diagnosis("missing", effects=effects, rivals=["coulomb_asymmetry"])).replies
    assert replies[-1].command.startswith("ema add mine.toml constant_load ")


def test_what_is_not_accepted_is_no_fall_of_the_error(tmp_path: Path) -> None:
    data = diagnosis("unknown")
    steps = [*data["steps"], {"effects": ["spring_load"], "added": "spring_load", "error_training": 6.0, "error_holdout": 19.0}]
    data |= {"steps": steps, "error": {**data["error"], "before": 13.4, "after": 6.0, "holdout_before": 9.0, "holdout_after": 19.0}}
    found = said(data)
    assert found.replies[3].short == "13.4, not explained" and found.replies[3].tone == "bad"
    assert "the best candidate, not accepted, leaves 6.00, 6.9 times the noise level" in found.replies[3].more
    assert [name for name, _, _ in first_screen.rungs(parsed(data))][-1] == "spring_load (not accepted)"
    assert "+ spring load (not accepted)" in diagnosis_page(tmp_path, data).read_text(encoding="utf-8")
    alone = said({**data, "error": {**data["error"], "holdout_before": None, "holdout_after": None}})
    assert "No effect of the library explains it: the best candidate, spring load, leaves 6.9 times the noise." in alone.sentence


def test_a_validation_record_that_refutes_is_said() -> None:
    error = {"before": 48.0, "after": 0.9, "floor": 0.87, "holdout_before": 4.0, "holdout_after": 9.0}
    assert "does not hold on the validation record" in said(diagnosis("unknown", error=error)).sentence


def test_error_left_is_what_the_ladder_has_and_what_the_score_takes_off() -> None:
    found = {one.entry.name: one.left for one in first_screen.candidates(parsed(diagnosis("missing")))}
    assert found["stribeck_friction"] == pytest.approx(4.0) and found["spring_load"] == pytest.approx(6.0)
    assert "leaves 1.5 times its error" in said(diagnosis("missing")).replies[2].more


def test_heat_map_counts_in_noise_and_is_empty_when_healthy(tmp_path: Path) -> None:
    result = parsed(diagnosis("missing"))
    time = next(one for one in heat.maps(result, signals.traces(result.curves, result.found.curves)) if one.by == "time")
    mechanical = next(row for row in time.rows if row.name == "mechanical")
    assert mechanical.multiples.size == BINS
    # the mean square over the record is that of the equation: 30 times the noise
    assert float(np.sqrt(np.mean(mechanical.multiples**2))) == pytest.approx(30.0, rel=1e-6)
    html = diagnosis_page(tmp_path, diagnosis("healthy")).read_text(encoding="utf-8")
    assert not re.search(r'class="cell h[1-9]', html) and 'class="cell h0"' in html
    html = diagnosis_page(tmp_path, diagnosis("missing")).read_text(encoding="utf-8")
    assert re.search(r'class="cell h[3-6]"[^>]*data-by="time"', html)


def test_a_cell_knows_its_moments() -> None:
    result = parsed(diagnosis("missing"))
    found = signals.traces(result.curves, result.found.curves)
    assert found is not None
    bins = heat.bins_of_rows(result, found)
    assert set(bins) == {"time", "speed", "position"}
    rows = found.curves.rows
    assert np.array_equal(bins["time"], np.minimum(np.arange(rows) * BINS // (rows - 1), BINS - 1))
    motor = found.curves.measured["motor_position_mm"]
    assert float(np.max(np.abs(motor[bins["position"] == BINS // 2] - 1.9 / BINS))) <= 1.9 / BINS + 1e-9


@pytest.mark.parametrize("kind", KINDS)
def test_page_is_whole_small_and_loads_nothing(kind: str, tmp_path: Path) -> None:
    html = diagnosis_page(tmp_path, diagnosis(kind)).read_text(encoding="utf-8")
    found = _structure(_without_scripts(html))
    assert found.problems == [] and found.open == []
    assert len(found.identities) == len(set(found.identities)) and set(found.references) <= set(found.identities)
    assert found.loads == ["data:,"] and "default-src 'none'" in html
    assert len(html.encode()) < 1_500_000
    assert html == diagnosis_page(tmp_path, diagnosis(kind)).read_text(encoding="utf-8")
    assert not re.search(r"[\x00-\x08\x0b\x0e-\x1f\x7f]", html)


def test_names_cannot_break_the_page(tmp_path: Path) -> None:
    hostile = "</script><script>alert(1)</script>\"'&"
    data = diagnosis("missing", name=hostile, sentence=hostile, next_experiment=hostile, provenance={"command": hostile, hostile: hostile})
    html = diagnosis_page(tmp_path, data).read_text(encoding="utf-8")
    assert "alert(1)</script>" not in html
    assert hostile in "".join(_structure(_without_scripts(html)).texts)


def test_signals_are_all_there_with_their_digits(tmp_path: Path) -> None:
    data = diagnosis("missing")
    html = diagnosis_page(tmp_path, data).read_text(encoding="utf-8")
    packed = json.loads(html.split('<script id="page-data" type="application/json">')[1].split("</script>")[0])
    assert [one["name"] for one in packed["channels"]] == ["position_mm", "current_A", "motor_position_mm", "voltage_V", "speed_mm_s"]
    for channel in packed["channels"][:4]:
        here, model = (np.array(data["curves"][key][channel["name"]]) for key in ("measured", "after"))
        values = np.frombuffer(base64.b64decode(channel["measured"]["int16"]), dtype="<i2") * channel["measured"]["scale"]
        assert float(np.max(np.abs(values - here))) <= 0.51 * channel["measured"]["scale"]
        one = channel["residual"]["after"]
        residual = np.frombuffer(base64.b64decode(one["int16"]), dtype="<i2") * one["scale"]
        assert float(np.max(np.abs(residual - channel["residual_scale"] * (here - model)))) <= 0.51 * one["scale"]


def test_without_the_library_the_page_says_so_and_keeps_the_rest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(page_of, "library", uplot.ChartLibrary)
    html = diagnosis_page(tmp_path, diagnosis("missing")).read_text(encoding="utf-8")
    assert uplot.ABSENT in html and 'class="plot main"' not in html and 'class="heat"' in html and "Stribeck friction" in html
    assert _structure(_without_scripts(html)).problems == []


def test_bare_result_and_addition_have_a_page(tmp_path: Path) -> None:
    bare = {"command": "diagnose", "verdict": "adequate", "error": {"before": 1.0, "floor": 1.0, "after": None}}
    html = diagnosis_page(tmp_path, bare).read_text(encoding="utf-8")
    assert "<h1>The model holds: nothing is missing.</h1>" in html and "The result holds no curves" in html
    added = {
        "command": "add", "effect": "jam_spot", "actuator": "new.toml", "name": "today.csv", "error": {"before": 3.2, "after": 1.05, "floor": 1.0},
        "parameters": {"effects.jam_spot.width_mm": {"value": 2.0, "std": 0.01, "at_bound": True}}, "recommended": False, "reason": "width_mm lies on its bound",
    }  # fmt: skip
    html = diagnosis_page(tmp_path, added).read_text(encoding="utf-8")
    assert "<h1>Jam spot is in the model: the error falls from 3.20 to 1.05.</h1>" in html
    assert "2.00 ± 0.02 mm (at its bound)" in html and "width_mm lies on its bound" in html


def test_a_workbench_has_its_place_and_what_it_needs(tmp_path: Path) -> None:
    result = parsed(diagnosis("missing"))
    html = page_of.render(
        replace(result, workbench=bench(reference_actuator(), read_record(RECORDINGS / "story" / "today.csv"))), "ema report"
    )
    assert html.index('id="rest"') < html.index('<section id="workbench"') < html.index('id="records"')
    assert "wasm-unsafe-eval" in html and "wasm-unsafe-eval" not in page_of.render(result, "ema report")


def test_words() -> None:
    assert names.display("stribeck_friction") == "Stribeck friction" and names.within("directional_stribeck") == "directional Stribeck"
    assert names.sized(0.29939, 0.0019, "Nm") == "0.299 ± 0.004 Nm" and names.sized(137.2, 138.0) == "137 ± 270"
    assert names.changed(39.74, 0.24) == "+40 %" and names.changed(-2.44, 0.3) == "−2 %"
    assert names.listed(["a", "b", "c"]) == "a, b and c"


def test_axes_have_round_ends() -> None:
    assert charts.steps(0.8, 48.0) == (0.5, 50.0) and charts.steps(1.0, 1.0) == (1.0, 10.0)
    assert charts.ticks(-1.9, 1.9, 5) == [-1.0, 0.0, 1.0]
    assert charts.tracks("x", "a", "b", [], None) == ""


def test_the_balance_of_forces_speaks_of_forces() -> None:
    parts = {"training_percent": 2.0, "holdout_percent": 2.1, "each_held_out_percent": []}
    found = said(
        {
            "command": "diagnose", "method": "balance", "mode": "several records", "verdict": "missing", "error_unit": "% of the drive's force",
            "effects": [{"name": "constant_load", "parameters": {"torque_Nm": 0.006}, "std": {"torque_Nm": 1e-5}, "score": 400.0, "limit": 0.0, "accepted": True}],
            "error": {"before": 25.0, "after": 0.2, "floor": 0.2, "holdout_before": 22.0, "holdout_after": 0.3},
            "forces": {"error": {"given": parts, "refitted": parts, "floor_percent": 0.2}, "steps": [], "refused": [], "values": {},
                       "laps": {"count": 3, "period_s": None, "parts": 3, "held_out_part": 0}, "curves": {}},
        }
    )  # fmt: skip
    assert [one.short for one in found.replies[1:4]] == ["Mechanics", "Constant load", "25.0 → 0.200"]
    assert found.replies[3].more == "% of the drive's force; held out 22.0 → 0.300"
