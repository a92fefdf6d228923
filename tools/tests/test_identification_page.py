"""The page of one identification: its sentence and five answers, both sizes against what is called a fault, that every fact of the result stands on it,
and that the file is whole and the same each time."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from ema_tools.words.page import identification_page, uplot, write_report
from ema_tools.words.page.gauges import gauge_of
from ema_tools.words.page.identification_screen import first_screen_of, shift_words
from ema_tools.words.page.results import ShownEstimate, ShownIdentification, parse_result
from ema_tools.words.page.sheet import FirstScreen
from report_results import JUDGED, identified, judged
from support import RECORDINGS, REFERENCE, complaint, run_ema
from test_report_page import _structure, _without_scripts

FAULTY, HEALTHY, MISSING, RIVAL = JUDGED


def said(data: dict[str, Any]) -> FirstScreen:
    found = parse_result(data, "today.json", "today")
    assert isinstance(found, ShownIdentification)
    return first_screen_of(found)


def page_of(folder: Path, data: dict[str, Any]) -> str:
    (folder / "i.json").write_text(json.dumps(data), encoding="utf-8")
    write_report([folder / "i.json"], folder / "page.html", "ema report i.json", force=True)
    return (folder / "page.html").read_text(encoding="utf-8")


def text_of(html: str) -> str:
    return " ".join("".join(_structure(_without_scripts(html)).texts).replace("\u00a0", " ").split())


@pytest.mark.parametrize(
    ("kind", "sentence", "short"),
    [
        (
            FAULTY,
            "The machine has a fault: friction (CSJ) +117.4 % and backlash (BLK) +24.8 %.",
            ("Yes", "Friction and backlash", "Nothing", "140 → 1.00 µm", "Repair, and follow it"),
        ),
        (
            HEALTHY,
            "The machine is healthy: friction (CSJ) +1.1 % and backlash (BLK) +1.2 %.",
            ("Yes", "Nowhere", "Nothing", "140 → 1.00 µm", "Nothing; follow it"),
        ),
        (
            MISSING,
            "No verdict: Stribeck friction is missing from the model.",
            ("No", "Cannot be told", "Stribeck friction", "140 → 1.00 µm", "Put it into the model"),
        ),
        (
            RIVAL,
            "No verdict: Stribeck friction explains the record as well as a fault does.",
            ("Yes", "Cannot be told", "Perhaps Stribeck friction", "140 → 1.00 µm", "Record what tells them apart"),
        ),
    ],
)
def test_first_screen_answers(kind: str, sentence: str, short: tuple[str, ...]) -> None:
    found = said(judged(kind))
    assert found.sentence == sentence
    assert tuple(one.short for one in found.replies) == short


def test_one_fault_of_two_is_said_to_be_one() -> None:
    data = judged(FAULTY)
    data["blk_mm"] |= {"estimate": 0.0335, "shift_percent": 1.5, "interval95": [0.033, 0.034]}
    found = said(data)
    assert found.sentence == "The machine has a fault: friction (CSJ) +117.4 %; backlash (BLK) is within its threshold."
    assert found.replies[1].short == "Friction" and found.replies[1].more == "CSJ beyond +5 %"
    # beyond, but not surely
    data["blk_mm"] |= {"estimate": 0.0367, "shift_percent": 11.2, "interval95": [0.036, 0.0374]}
    assert said(data).sentence == "The machine has a fault: friction (CSJ) +117.4 %; backlash (BLK) may be beyond its threshold."
    # within, with an interval that is not
    data["blk_mm"] |= {"estimate": 0.0335, "shift_percent": 1.5, "interval95": [0.028, 0.039]}
    assert said(data).sentence == "The machine has a fault: friction (CSJ) +117.4 %; backlash (BLK) may be beyond its threshold."


def test_a_healthy_answer_says_what_it_may_hide() -> None:
    data = {**judged(FAULTY), "verdict": "healthy"}
    data["csj_Nm"] |= {"estimate": 0.139, "shift_percent": 0.7, "interval95": [0.12, 0.158]}
    data["blk_mm"] |= {"estimate": 0.0335, "shift_percent": 1.5, "interval95": [0.033, 0.034]}
    assert "today's may be CSJ +14 %" in said(data).replies[1].more
    data["csj_Nm"] |= {"interval95": [0.137, 0.141]}
    assert "may be" not in said(data).replies[1].more


NEAR = "a shift cannot be told from its threshold with the stated confidence"


@pytest.mark.parametrize(
    ("kind", "changes", "command"),
    [
        (FAULTY, {}, "ema report i.json -o unit.html"),
        (FAULTY, {"guard": None}, "ema identify mine.toml today.csv --healthy 'runs/healthy *.csv'"),
        (MISSING, {}, "ema add mine.toml stribeck_friction --fit today.csv --known -o with_stribeck_friction.toml"),
        (RIVAL, {}, "ema next mine.toml --between csj stribeck_friction"),
        (MISSING, {"missing_effect": None, "reasons": ["an effect is missing from the model"], "guard": None}, "ema diagnose mine.toml today.csv --healthy 'runs/healthy *.csv'"),
        (MISSING, {"missing_effect": None, "adequate": True, "reasons": [NEAR], "guard": None}, "ema identify mine.toml NEXT.csv --healthy 'runs/healthy *.csv'"),
    ],
)  # fmt: skip
def test_next_command_has_the_paths_that_were_given(kind: str, changes: dict[str, Any], command: str) -> None:
    assert said({**judged(kind), **changes}).replies[-1].command == command


@pytest.mark.parametrize(
    ("objection", "why", "short"),
    [
        ("unknown", "the library of effects does not know", "Ask what is missing"),
        ("signals", "the other signals say otherwise", "Check the sensors and record again"),
        ("open", "differs from day to day", "Record more healthy runs"),
        ("healthy", "may not all be of a healthy machine", "Record more healthy runs"),
    ],
)
def test_every_objection_has_its_words(objection: str, why: str, short: str) -> None:
    data = judged(FAULTY)
    data |= {"verdict": "undecided", "reasons": ["why"], "guard": {**data["guard"], "objection": objection}}
    found = said(data)
    assert why in found.sentence and found.replies[-1].short == short and found.replies[-1].command
    assert found.replies[-1].command.endswith(" MORE.csv") == (short == "Record more healthy runs")


def test_an_effect_beside_a_fault_that_stands_is_shown_with_the_size_that_it_leaves() -> None:
    data, missing = judged(FAULTY), judged(MISSING)
    add = "ema add mine.toml stribeck_friction --fit today.csv --healthy h.csv -o NEW.toml"
    data |= {
        "missing_effect": missing["missing_effect"],
        "sentence": f"Fault: CSJ +117 %. Besides, Stribeck friction is missing from the model: {add} puts it in.",
        "guard": {**data["guard"], "verdict": "missing", "objection": None, "shift_percent": {"csj_Nm": 112.0}},
    }
    found = said(data)
    holds, where, lacks, _, then = found.replies
    assert found.sentence.startswith("The machine has a fault: ") and where.short == "Friction and backlash"
    assert (holds.short, lacks.short) == ("By the rod position", "Stribeck friction")
    assert "beside it CSJ +112.0 %" in lacks.more
    assert then.command == add.replace("NEW.toml", "with_stribeck_friction.toml")


def test_a_record_that_cannot_tell_is_recorded_again() -> None:
    data = judged(MISSING)
    data |= {"missing_effect": None, "reasons": ["nothing can be told from this record: the rod hardly moves"]}
    found = said(data)
    assert found.sentence == "No verdict: nothing can be told from this record." and "hardly moves" in found.replies[-1].more


def test_a_sensor_that_errs_is_named() -> None:
    data = judged(MISSING)
    # told by the field, whatever the reason says
    sensor = {
        "channel": "current_A",
        "share": 0.95,
        "cost": 1.0,
        "factor": 1.1,
        "offset": 0.0,
        "late_s": 0.0,
        "sentence": "it reads 1.1 times",
        "next": "check it",
    }
    data |= {
        "missing_effect": None,
        "reasons": ["why"],
        "sensor": sensor,
        "guard": {**data["guard"], "verdict": "unknown", "objection": "unknown"},
    }
    found = said(data)
    assert found.sentence == "No verdict: it looks as if the sensor of the motor current is at fault."
    assert (found.replies[2].short, found.replies[-1].short) == ("Nothing in the machine", "Check the sensor")
    data |= {"sensor": None, "reasons": ["what is there looks like the sensor of the current (current_A), not like the machine"]}
    assert said(data).replies[-1].short != "Check the sensor"


def test_a_size_stands_where_it_belongs() -> None:
    line = gauge_of(ShownEstimate(0.1598, (0.1581, 0.1615), 22.2, 0.1307, 5.0))
    assert line.low == pytest.approx(-6.75) and line.interval is not None
    assert 0.0 < line.at(-5.0) < line.at(0.0) < line.at(5.0) < line.at(line.interval[0]) < line.at(22.2) < line.at(line.interval[1]) < 1.0
    # an interval as wide as the search leaves the threshold visible, and nothing is less than nothing
    wide = gauge_of(ShownEstimate(0.04, (-30.0, 30.0), 20.0, 0.033, 10.0))
    assert wide.interval == (-100.0, 140.0) and wide.at(10.0) - wide.at(-10.0) > 0.05
    bare = gauge_of(ShownEstimate(0.138, None, 0.0, 0.138))
    assert bare.low < 0.0 < bare.high and bare.interval is None


def test_no_more_digits_than_the_interval_leaves() -> None:
    assert shift_words(ShownEstimate(0.1598, (0.1581, 0.1615), 22.246, 0.1307)) == ("+22.2 %", "+20.9 … +23.5 %")
    assert shift_words(ShownEstimate(0.0816, (0.0212, 0.142), 147.37, 0.033)) == ("+147 %", "−36 … +330 %")
    assert shift_words(ShownEstimate(0.3, (0.29999, 0.30001), 117.3913, 0.138)) == ("+117.39 %", "+117.38 … +117.40 %")
    assert shift_words(ShownEstimate(0.3, None, 117.3913, 0.138)) == ("+117.4 %", "")


@pytest.mark.parametrize("kind", JUDGED)
def test_page_is_whole_small_and_loads_nothing(kind: str, tmp_path: Path) -> None:
    html = page_of(tmp_path, judged(kind))
    found = _structure(_without_scripts(html))
    assert found.problems == [] and found.open == []
    assert len(found.identities) == len(set(found.identities)) and set(found.references) <= set(found.identities)
    assert found.loads == ["data:,"] and "default-src 'none'" in html and len(html.encode()) < 400_000
    assert html == page_of(tmp_path, judged(kind))


def test_every_fact_stands_on_it(tmp_path: Path) -> None:
    data = judged(MISSING)
    data |= {
        "undetermined": {"blk_mm": "This record does not determine BLK: why."},
        "baseline": {"values": {"screw.csj_Nm": 0.138}, "std": {"screw.csj_Nm": 1e-4}, "records": 3, "interval95": {"screw.csj_Nm": [0.1378, 0.1382]}},
        "seeds": [{"objective_after_mm2s": 2.5e-4, "evaluations": 9, "csj_Nm": 0.2051, "blk_mm": 0.0816}],
        "warnings": ["the budget is small"],
        "values": {"motor.resistance_ohm": {"estimate": 0.9, "interval95": [0.89, 0.91], "determined": "together", "alike": "screw.csj_Nm", "before": 0.99}},
        "values_search": {"noise": {"position_mm": 0.005}, "misfit_before": 3.0, "misfit_after": 1.0, "adequate": True, "runs": 25, "starts": 1, "outcome": "tolerance"},
        "accepted": 90, "accepted_uphill": 30, "model_steps": 2_000_000, "sentence": "What the terminal says.",
        "shape": {"csj_Nm": {"value": [0.1, 0.205, 0.3], "objective_mm2s": [0.1, 2.5e-4, 0.1], "limit_mm2s": 3e-4},
                  "map": {"csj_Nm": [0.1, 0.2], "blk_mm": [0.03, 0.09], "objective_mm2s": [[0.1, 0.2], [0.3, 0.4]]}},
    }  # fmt: skip
    text = text_of(page_of(tmp_path, data))
    for fact in (
        "Stribeck friction (stribeck_friction; rise 0.30) is missing from the model", "ema add mine.toml stribeck_friction", "rise 0.300 ± 0.010", "CSJ 0.1928 Nm (+39.7 %)",
        "held against rod position, motor position at the rod, motor current and motor voltage", "This record does not determine BLK: why.",
        "0.2050 Nm", "healthy 0.1380 Nm", "± 0.19 %", "Healthy values from 3 healthy records: CSJ 0.1380 Nm (0.13780 … 0.13820)", "over 2 seeds",
        "2.30 µm rms of the rod position are left", "motor.resistance_ohm", "only together with screw.csj_Nm", "7 model runs in 0.070 s", "2.00×10⁶ model steps",
        "90 candidates were taken, 30 of them worse", "ended by tolerance", "The budget is small.", "0.674 → 2.50×10⁻⁴ mm² s (−99.962 %)", "What the terminal says.",
        "The error along each parameter", "The error over both, and the way of the search", "Run by run", "ema export calibrated.toml", "ema report i.json", "--json i.json",
        "not determined by this record", "◇ all signals beside Stribeck friction +39.7 %",
    ):  # fmt: skip
        assert fact in text, fact


def test_names_cannot_break_the_page(tmp_path: Path) -> None:
    hostile = "</script><script>alert(1)</script>\"'&"
    data = {
        **judged(MISSING),
        "name": hostile,
        "reasons": [hostile],
        "sentence": hostile,
        "provenance": {"command": hostile, hostile: hostile},
    }
    html = page_of(tmp_path, data)
    assert "alert(1)</script>" not in html
    assert hostile in "".join(_structure(_without_scripts(html)).texts)


def test_an_older_file_without_thresholds_has_its_page(tmp_path: Path) -> None:
    html = page_of(tmp_path, identified())
    assert html.count('class="gauge bad"') == 2 and "fault from" not in html
    assert _structure(_without_scripts(html)).problems == []


def test_weighted_errors_have_no_unit() -> None:
    data = judged(FAULTY)
    data["provenance"] = {"command": "ema identify mine.toml today.csv --weight position_mm=1,current_A=1"}
    assert "2.50×10⁻⁴ weighted" in said(data).replies[3].more


def test_without_the_library_the_page_says_so_and_keeps_the_rest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(identification_page, "library", uplot.ChartLibrary)
    html = page_of(tmp_path, judged(FAULTY))
    assert uplot.ABSENT in html and 'class="plot main"' not in html and 'class="gauge bad"' in html
    assert _structure(_without_scripts(html)).problems == []


def test_identify_writes_its_page(tmp_path: Path) -> None:
    ran = run_ema("identify", REFERENCE, RECORDINGS / "case_b.csv", "--no-guard", "--report", tmp_path / "i.html")
    assert ran.code == 0 and f"{tmp_path / 'i.html'} written" in ran.out
    html = (tmp_path / "i.html").read_text(encoding="utf-8")
    assert "<h1>The machine has a fault: " in html and '<section id="workbench"' in html
    assert "ema identify" in html.split('class="origin"')[1]
    again = run_ema("identify", REFERENCE, RECORDINGS / "case_b.csv", "--no-guard", "--report", tmp_path / "i.html")
    assert complaint(again) and "--force" in again.err
