"""What stands on the first screens of a comparison, a map and several results: the sentence, the answers, and commands that can be copied."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from ema_tools.words.answers.over_dates import over_dates
from ema_tools.words.page import several_page
from ema_tools.words.page.page import render
from ema_tools.words.page.results import parse_result, shown
from ema_tools.words.page.sheet import FirstScreen
from report_results import JUDGED, compared, compared_whole, identified, judged, mapped
from support import RECORDINGS, REFERENCE, complaint, run_ema
from test_over_dates import days
from test_over_dates import identified as identified_on
from test_report_page import _structure, _without_scripts


def said(data: dict[str, Any]) -> FirstScreen:
    return several_page.own_answers(parse_result(data, "today.json", "today"))


def shorts(first: FirstScreen) -> tuple[str, ...]:
    return tuple(one.short for one in first.replies)


def test_a_comparison_says_whether_what_is_left_is_noise_and_where_it_is() -> None:
    found = said(compared_whole())
    assert found.sentence == "The model leaves 27.7 % unexplained in the mechanics; the rod position is off by 5.00 %."
    # 0.05 over the root of 0.003 and 0.004 squared; of the mechanics' places, not of the most telling one
    assert shorts(found) == ("No", "Mechanics", "At current 3.45 to 5.17 A", "Rod position 5.00 %", "Ask what is missing")
    assert found.replies[0].more == "mechanics 10 times its noise level"
    assert found.replies[-1].command == "ema diagnose 'my unit.toml' runs/today.csv"


def test_a_comparison_that_noise_explains_says_so() -> None:
    data = compared_whole()
    data["balances"]["mechanical"] |= {"rms": 0.006, "relative_percent": 3.0, "excess_percent": 0.0}
    found = said(data)
    assert found.sentence == "The model explains the record as far as noise can tell; the rod position is off by 5.00 %."
    assert shorts(found)[:3] == ("Yes", "Nowhere", "At no time in particular")
    assert found.replies[-1].command == "ema identify 'my unit.toml' runs/today.csv"


def test_a_map_says_where_the_model_is_off() -> None:
    found = said(mapped())
    assert shorts(found) == ("95.5 … 382 rpm", "0.155 Nm at least", "0.00500 Nm", "Not at 2 of 4 speeds", "Ask what is missing")
    assert found.replies[-1].command == "ema diagnose 'my unit.toml' runs --method balance"
    same = [{**one, "model_Nm": one["torque_Nm"]} for one in mapped()["points"]]
    found = said(mapped(points=same, both_ways=[]))
    assert shorts(found)[1:] == ("Not told", "Not told", "Yes", "Take the values over") and "the model agrees" in found.sentence


def test_a_unit_over_its_dates_is_answered_as_one() -> None:
    found = [
        (path, replace(one, provenance={**one.provenance, "command": "ema identify left.toml a.csv --no-guard"})) for path, one in days(12)
    ]
    (unit,) = over_dates(found)
    drawn = [shown(one, str(path), path.stem) for path, one in found]
    first = several_page._of_unit(unit, drawn)
    assert first.sentence.startswith("Left: CSJ has changed by +")
    assert [one.question for one in first.replies][:2] == ["How is it now?", "CSJ, static dry friction"]
    # the last of twelve readings: eight days of 4 % each
    assert shorts(first)[:3] == ("Fault", "+32 %", "0 %") and first.replies[0].more == "2026-05-12, 2026-05-12.csv"
    assert "since 2026-05-" in first.replies[1].more and (first.replies[1].tone, first.replies[2].tone) == ("bad", "good")
    assert first.replies[3].short.startswith("In ") and "CSJ +50 %; 90 %:" in first.replies[3].more
    assert first.replies[4].command.startswith("ema identify left.toml a.csv")
    html = render(drawn, "ema report", (unit,))
    # said once: in the heading, and not above the pictures again
    assert html.count("CSJ has changed by") == 2 and "<h1>Left: CSJ has changed by" in html


def test_a_unit_without_drift_says_that_no_limit_is_in_sight() -> None:
    found = [
        (Path(f"2026-05-{day:02}.json"), identified_on(f"2026-05-{day:02}.csv", 0.5 * (day % 2), verdict="healthy")) for day in range(1, 13)
    ]
    (unit,) = over_dates(found)
    first = several_page._of_unit(unit, [shown(one, str(path), path.stem) for path, one in found])
    assert (
        first.sentence == "Left: 12 results; the last that counts reads CSJ 0.0 % and BLK 0.0 %."
        and first.replies[3].short == "Not in sight"
    )
    assert first.replies[1].more == "a fault from +5 % on; no drift is told"


def test_many_results_are_counted_and_the_menu_stays_short() -> None:
    results = [parse_result(judged(JUDGED[place % 3]), f"{place}.json", str(place)) for place in range(20)]
    first = several_page._overview(results, ())
    assert first.sentence == "20 results: a fault in 7, 7 healthy and 6 undecided."
    assert len(first.replies) == 15 and first.replies[-1].short == "6 more" and first.replies[-1].link == "result-15"
    html = render(results, "ema report")
    menu = html.split("<nav")[1].split("</nav>")[0]
    assert menu.count("<a ") == 1 and html.count('<details class="whole">') == 20
    found = _structure(_without_scripts(html))
    assert found.problems == [] and len(found.identities) == len(set(found.identities)) and set(found.references) <= set(found.identities)


def test_names_cannot_break_the_pages() -> None:
    hostile = "</script><script>alert(1)</script>\"'&"
    for data in (
        [mapped(name=hostile, sentence=hostile, left_out={hostile: hostile}, provenance={hostile: hostile})],
        [
            compared(
                name=hostile,
                sentence=hostile,
                where=[{"name": hostile, "share_percent": 60.0, "time_share": 0.1, "by": hostile, "part": hostile}],
            )
        ],
        [identified(name=hostile), mapped(name=hostile), compared(name=hostile)],
    ):
        html = render([parse_result(one, "x", "x") for one in data], hostile)
        assert "alert(1)</script>" not in html
        assert _structure(_without_scripts(html)).problems == []


def test_a_comparison_from_a_file_of_before_is_shown() -> None:
    """Without noise levels nothing is said of noise."""
    found = said(compared())
    assert shorts(found)[0] == "Not told" and found.replies[1].short == "Mechanics"


def test_compare_writes_its_page(tmp_path: Path) -> None:
    page = tmp_path / "c.html"
    ran = run_ema("compare", REFERENCE, RECORDINGS / "story" / "today.csv", "--report", page, "--json", tmp_path / "c.json")
    assert ran.code == 0 and f"{page} written" in ran.out
    html = page.read_text(encoding="utf-8")
    assert "unexplained in the mechanics" in html.split("</h1>")[0] and '<section id="workbench"' in html and len(html.encode()) < 1_500_000
    again = run_ema("compare", REFERENCE, RECORDINGS / "story" / "today.csv", "--report", page)
    assert complaint(again) and "--force" in again.err


@pytest.mark.parametrize("kind", JUDGED[:2])
def test_a_result_that_was_not_kept_is_kept_by_the_next_command(kind: str) -> None:
    data = judged(kind)
    data["provenance"]["command"] = "ema identify mine.toml runs/today.csv --healthy 'runs/healthy *.csv'"
    assert said(data).replies[-1].command == "ema identify mine.toml runs/today.csv --healthy 'runs/healthy *.csv' --json today.json"
