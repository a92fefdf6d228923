"""The page of the paper's cases: what is simulated for it, what stands on it beside the paper's numbers, and that it is drawn."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ema_tools.data.actuator import reference_actuator
from ema_tools.data.cases import CASES
from ema_tools.results.paper import PaperResponses
from ema_tools.tasks.paper import paper_responses
from ema_tools.words.page.paper_page import CITED, paper_page
from ema_tools.words.page.results import ShownIdentification, parse_result
from report_results import identified
from support import run_ema
from test_report_in_browser import browser  # noqa: F401 - a fixture
from test_report_page import _structure, _without_scripts


@cache
def responses() -> PaperResponses:
    return paper_responses(reference_actuator())


def cases() -> list[ShownIdentification]:
    shown = [parse_result(identified(case=case.letter), f"{case.letter}.json", case.letter) for case in CASES]
    return [one for one in shown if isinstance(one, ShownIdentification)]


def change(found: PaperResponses, runs: tuple[Any, ...]) -> list[float]:
    return [float(np.sqrt(np.mean((one.position_mm - found.healthy.position_mm) ** 2))) for one in runs]


def test_what_is_simulated_is_what_the_cases_say() -> None:
    found = responses()
    assert [(one.csj_Nm, one.blk_mm) for one in found.cases] == [(case.csj_Nm, case.blk_mm) for case in CASES]
    assert found.command_mm.size == found.healthy.position_mm.size == 10_000 and found.period_s == 1e-3
    # the paper prints 0.655 mm2 s for case A before its search
    before = found.period_s * float(np.sum((found.cases[0].position_mm - found.healthy.position_mm) ** 2))
    assert before == pytest.approx(0.655, rel=0.05)
    # each alone changes more as it grows; play leaves the current of a motor that closes its own loop as it was
    for runs in (found.csj, found.blk):
        assert change(found, runs) == sorted(change(found, runs))
    assert all(np.array_equal(one.current_A, found.healthy.current_A) for one in found.blk)
    assert all(float(np.std(one.current_A)) > float(np.std(found.healthy.current_A)) for one in found.csj)


def test_the_objective_is_least_at_the_truth() -> None:
    box = responses().box
    row, column = np.unravel_index(int(np.argmin(box.objective_mm2s)), box.objective_mm2s.shape)
    assert abs(box.csj_Nm[column] - CASES[0].csj_Nm) <= np.max(np.diff(box.csj_Nm))
    # along BLK it is a valley: what moves it most is CSJ
    assert np.ptp(box.objective_mm2s[:, column]) < 0.05 * np.ptp(box.objective_mm2s[row])
    assert box.csj_Nm[0] == pytest.approx(0.01) and box.blk_mm[-1] == pytest.approx(0.1)


def test_the_page_cites_the_paper_and_puts_its_numbers_beside_those_reached_here() -> None:
    page = paper_page(responses(), cases(), "ema demo --paper")
    found = _structure(_without_scripts(page))
    assert found.problems == [] and found.open == [] and len(found.identities) == len(set(found.identities))
    text = " ".join("".join(found.texts).split())
    assert CITED in text
    for title in (
        "Command and response",
        "What static dry friction does",
        "What backlash does",
        "how the annealer converges",
        "Beside the paper",
    ):
        assert title in text
    for case in CASES:
        assert f"{case.paper_csj_Nm:g}" in text and f"{case.paper_blk_mm:g}" in text and str(case.paper_iterations) in text
    assert len(page.encode()) < 2_500_000


@pytest.mark.parametrize("width", [1366, 390])
def test_the_page_is_drawn(width: int, browser: Any, tmp_path: Path) -> None:  # noqa: F811
    (tmp_path / "paper.html").write_text(paper_page(responses(), cases(), "ema demo --paper"), encoding="utf-8")
    context = browser.new_context(offline=True, viewport={"width": width, "height": 800})
    page, complaints = context.new_page(), []
    page.on("console", lambda one: complaints.append(one.text))
    page.on("pageerror", lambda one: complaints.append(str(one)))
    page.goto((tmp_path / "paper.html").as_uri())
    for place in page.locator("[data-curves], .lines").all():
        place.scroll_into_view_if_needed()
    page.wait_for_function("() => document.querySelectorAll('[data-curves]:not([data-drawn]), .lines:not([data-drawn])').length === 0")
    assert page.locator(".lines").count() == 4 + 3 + 3
    assert page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth") == 0
    page.locator('[data-lines-of="responses"][data-view]').click()
    assert (
        page.locator("#response-position_mm").get_attribute("data-view")
        == "1.0000 1.6000"
        == page.locator("#response-current_A").get_attribute("data-view")
    )
    assert page.locator("#csj-position").get_attribute("data-view") is None
    # each curve has its key, which switches it in its own plot and in what the crosshair reads
    key = page.locator('input[data-of="response-position_mm"][data-show="command"]')
    key.focus()
    page.keyboard.press("Space")
    plot = page.locator("#response-position_mm .u-over")
    plot.hover()
    read = page.locator("#response-position_mm + .values")
    page.wait_for_timeout(100)
    assert "healthy" in read.inner_text() and "command" not in read.inner_text()
    key.check()
    plot.hover(position={"x": 40, "y": 40})
    page.wait_for_timeout(100)
    assert "command" in read.inner_text()
    assert complaints == []
    context.close()


@pytest.mark.slow
def test_the_command_writes_page_and_results(tmp_path: Path) -> None:
    ran = run_ema("demo", "--paper", "-o", tmp_path / "paper")
    assert ran.code == 0, ran
    assert {path.name for path in (tmp_path / "paper").iterdir()} == {"case_a.json", "case_b.json", "case_c.json", "paper.html"}
    assert "paper's" in ran.out and "+117.4 %" in ran.out
    assert "The paper’s 3 cases are found to" in (tmp_path / "paper" / "paper.html").read_text(encoding="utf-8")
