"""The pages of several results and of a map in real Chromium, headless, with the network off: every curve is drawn without complaint and zooms with its neighbours, the first screen holds
what is to be known first, what stands behind it is opened by its link, and no reader is hindered."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from ema_tools.tasks.history import histories
from ema_tools.words.answers.fleet import fleet_result
from ema_tools.words.page import write_report
from ema_tools.words.page.fleet import fleet_page, unit_page
from in_browser import LAPTOP, PHONE, SMALL, at_rest, hindrances, launched, not_reached
from report_results import JUDGED, compared, identified, judged, mapped
from test_fleet import LIMITS, drifting
from test_report_diagnosis import made


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with launched() as opened:
        yield opened


@pytest.fixture
def opened(browser: Any, tmp_path: Path) -> Iterator[Any]:
    contexts = []

    def open_(*results: dict[str, Any], viewport: dict[str, int] = LAPTOP) -> tuple[Any, list[str]]:
        files = [tmp_path / f"result_{place}.json" for place in range(len(results))]
        for file, result in zip(files, results, strict=True):
            file.write_text(json.dumps(result), encoding="utf-8")
        write_report(files, tmp_path / "page.html", "ema report", force=True)
        contexts.append(browser.new_context(offline=True, viewport=viewport))
        page = contexts[-1].new_page()
        complaints: list[str] = []
        page.on("console", lambda one: complaints.append(one.text))
        page.on("pageerror", lambda one: complaints.append(str(one)))
        page.on("request", lambda one: complaints.append(one.url) if one.url.startswith("http") else None)
        page.goto((tmp_path / "page.html").as_uri())
        # what is not opened is not drawn
        for place in page.locator("[data-curves]:visible").all():
            place.scroll_into_view_if_needed()
        page.wait_for_function(
            "() => [...document.querySelectorAll('[data-curves]:not([data-drawn])')].every((one) => !one.checkVisibility())"
        )
        page.evaluate("scrollTo({ top: 0, behavior: 'instant' })")
        return page, complaints

    yield open_
    for context in contexts:
        context.close()


@pytest.mark.parametrize("viewport", [LAPTOP, pytest.param(PHONE, marks=pytest.mark.slow)])
def test_every_curve_is_drawn_without_complaint(viewport: dict[str, int], opened: Any) -> None:
    page, complaints = opened(identified(case="A"), identified(name="today"), compared(), viewport=viewport)
    assert complaints == []
    # two models of two identifications and one of a comparison: three channels each, with their residuals
    assert page.locator("[data-curves]").count() == 5 and page.locator(".uplot canvas").count() == 5 * 3 * 2
    # every canvas has ink on it
    inked = page.evaluate(
        "() => [...document.querySelectorAll('.uplot canvas')].map((one) => one.getContext('2d').getImageData(0, 0, one.width, one.height).data.some((value) => value > 0))"
    )
    assert all(inked)
    assert page.locator("svg.picture").count() == 2 + 1 + 1
    assert page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth") == 0


@pytest.mark.slow
def test_what_is_zoomed_in_one_is_zoomed_in_all_of_its_result(opened: Any) -> None:
    page, complaints = opened(identified(name="a"), identified(name="b"))
    views = lambda: [one.get_attribute("data-view") for one in page.locator("[data-curves]").all()]  # noqa: E731
    page.locator('[data-zoom-of="result-1"][data-zoom="in"]').click()
    first, second, *others = views()
    assert first == second and [float(end) for end in first.split()] == pytest.approx([0.29975, 0.89925], abs=2e-4) and others == [None] * 2
    page.locator('[data-zoom-of="result-1"][data-zoom="whole"]').click()
    assert views()[:2] == ["0.0000 1.1990"] * 2
    plot = page.locator('[data-curves="result-2"] .main .u-over').first
    plot.evaluate("(one) => one.scrollIntoView({ block: 'center', behavior: 'instant' })")
    box = plot.bounding_box()
    middle = box["y"] + 0.5 * box["height"]
    page.mouse.move(box["x"] + 0.25 * box["width"], middle)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.5 * box["width"], middle, steps=4)
    page.mouse.move(box["x"] + 0.75 * box["width"], middle, steps=4)
    page.mouse.up()
    first, last = map(float, views()[2].split())
    assert first == pytest.approx(0.3, abs=0.01) and last == pytest.approx(0.9, abs=0.01) and views()[3] == views()[2]
    # the crosshair reads every curve there
    page.mouse.move(box["x"] + 0.5 * box["width"], middle)
    at_rest(page)
    assert "measured" in page.locator('[data-curves="result-2"] .values').first.inner_text()
    assert complaints == []


# What is drawn of one result, plot by plot.
_DRAWN = """(of) => [...document.querySelectorAll(`[data-curves="${of}"] .main canvas, [data-curves="${of}"] .rest canvas`)].map((one) => one.toDataURL())"""


@pytest.mark.slow
def test_a_series_of_curves_is_switched_by_its_key_in_its_own_result_alone(opened: Any) -> None:
    page, complaints = opened(identified(name="a"), identified(name="b"))
    drawn = lambda of: page.evaluate(_DRAWN, of)  # noqa: E731
    first, other = drawn("result-1"), drawn("result-2")
    key = page.locator('input[data-of="result-1"][data-show="measured"]')
    # by the keyboard
    key.focus()
    page.keyboard.press("Space")
    at_rest(page)
    without = drawn("result-1")
    assert [now != before for now, before in zip(without, first, strict=True)] == [True, False] * 6 and drawn("result-2") == other
    # by a click on the key's words
    page.locator('label:has(input[data-of="result-1"][data-show="after"])').click()
    at_rest(page)
    assert [now != before for now, before in zip(drawn("result-1"), without, strict=True)] == [False] * 6 + [True] * 6
    for one in ("measured", "after"):
        page.locator(f'input[data-of="result-1"][data-show="{one}"]').check()
    at_rest(page)
    assert drawn("result-1") == first and complaints == []


@pytest.mark.slow
def test_a_series_of_a_picture_is_switched_by_its_key(opened: Any) -> None:
    page, complaints = opened(mapped())
    figures = page.locator("#law figure")
    key = figures.nth(0).locator('input[data-show="after"]')
    drawn = [figures.nth(place).locator(".picture .r-after").first for place in (0, 1)]
    assert drawn[0].is_visible() and drawn[1].is_visible()
    key.focus()
    page.keyboard.press("Space")
    assert not drawn[0].is_visible() and drawn[1].is_visible() and figures.nth(0).locator(".picture .r-before").first.is_visible()
    key.check()
    assert drawn[0].is_visible() and complaints == []


def _shown(page: Any, series: str) -> int:
    """Parts of a series that are not hidden; one of no height is no less there."""
    found: int = page.locator(f"svg .s-{series}").evaluate_all("(all) => all.filter((one) => one.getClientRects().length).length")
    return found


@pytest.mark.slow
def test_a_series_of_a_fleet_and_of_its_units_is_switched_without_a_script(browser: Any, tmp_path: Path) -> None:
    rows = [*drifting("wears", 1.2, 3), *drifting("still", 0.0, 2)]
    units = histories(rows, LIMITS)
    found = fleet_result(units, LIMITS, 0.01, len(rows), 2.0, {})
    (tmp_path / "fleet.html").write_text(fleet_page(found, {"wears": "w.html", "still": "s.html"}, "ema fleet"), encoding="utf-8")
    (tmp_path / "unit.html").write_text(unit_page(found.units[0], units[0].rows, "fleet.html", "ema fleet"), encoding="utf-8")
    context = browser.new_context(offline=True, viewport=PHONE)
    for name, charts in (("fleet", 4), ("unit", 2)):
        page = context.new_page()
        page.goto((tmp_path / f"{name}.html").as_uri())
        assert (
            page.locator("svg.chart").count() == charts
            and _shown(page, "reading") >= 3 * charts
            and _shown(page, "limit") == _shown(page, "life") == 1
        )
        # a key stands there for what is drawn, and for nothing else
        assert page.locator("input[data-show]").evaluate_all("(all) => all.map((one) => one.dataset.show)") == [
            "reading",
            "limit",
            "since",
            "life",
        ]
        page.locator('input[data-show="reading"]').focus()
        page.keyboard.press("Space")
        assert _shown(page, "reading") == 0 and _shown(page, "limit") == _shown(page, "life") == 1
        page.locator('label:has(input[data-show="life"])').click()
        assert _shown(page, "life") == 0 and _shown(page, "since") == 1
        page.locator('input[data-show="reading"]').check()
        assert _shown(page, "reading") >= 3 * charts
        assert page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth") == 0
        # on a phone each cell has its head beside it
        assert page.locator("tbody td[data-head]").count() == page.locator("tbody td").count() > 0
    assert all(hindrances(page) == [] for page in context.pages)
    context.close()


@pytest.mark.slow
def test_a_moment_of_a_diagnosis_zooms_its_curves(opened: Any) -> None:
    page, complaints = opened(made(), identified())
    picture = page.locator('[data-zooms="result-1"]')
    assert picture.count() == 1
    mark = picture.locator("[data-x]").nth(4)
    at, half = float(mark.get_attribute("data-x")), float(picture.get_attribute("data-half"))
    mark.dispatch_event("click")
    first, last = map(float, page.locator('[data-curves="result-1"]').first.get_attribute("data-view").split())
    assert first == pytest.approx(at - half, abs=1e-3) and last == pytest.approx(at + half, abs=1e-3)
    assert complaints == []


MANY = (judged(JUDGED[0]), judged(JUDGED[1]), judged(JUDGED[2]), made(), compared(name="today.csv"), mapped())


@pytest.mark.slow
@pytest.mark.parametrize("viewport", [SMALL, PHONE], ids=["laptop", "phone"])
def test_the_first_screen_says_what_each_result_concludes(viewport: dict[str, int], opened: Any) -> None:
    page, complaints = opened(*MANY, viewport=viewport)
    tiles = page.locator(".tiles .reply")
    assert [" ".join(one.split()) for one in page.locator(".tiles .reply b").all_inner_texts()] == [
        "Fault",
        "Healthy",
        "Undecided",
        "Jam spot",
        "Off by 4.08 %",
        "Friction map",
    ]
    for place in range(tiles.count()):
        box = tiles.nth(place).bounding_box()
        assert box["y"] + box["height"] <= viewport["height"], place
    assert page.locator("details.whole").count() == 6 and page.locator("details.whole[open]").count() == 0
    assert page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth") == 0
    assert page.evaluate("document.documentElement.scrollHeight") <= (4_500 if viewport is SMALL else 7_500)
    assert complaints == []


@pytest.mark.slow
def test_a_link_opens_what_it_leads_to_and_draws_it(opened: Any) -> None:
    page, complaints = opened(*MANY)
    page.click('.tiles a[href="#result-2"]')
    assert [one.evaluate("(one) => one.parentElement.id") for one in page.locator("details.whole[open]").all()] == ["result-2"]
    page.wait_for_function("() => document.querySelectorAll('[data-curves=\"result-2\"][data-drawn]').length === 2")
    assert page.locator('[data-curves="result-2"] canvas').count() == 2 * 3 * 2
    # each result has a command of its own to copy
    beside = page.evaluate(
        "[...document.querySelectorAll('[data-copy]')].map((one) => document.getElementById(one.dataset.copy) === one.previousElementSibling)"
    )
    assert beside == [True] * 6
    assert complaints == []


@pytest.mark.slow
@pytest.mark.parametrize("look", [LAPTOP, PHONE], ids=["laptop", "phone"])
@pytest.mark.parametrize("results", [MANY, (mapped(),)], ids=["several", "map"])
def test_no_reader_is_hindered(results: tuple[dict[str, Any], ...], look: dict[str, int], opened: Any) -> None:
    page, complaints = opened(*results, viewport=look)
    assert hindrances(page) == [] and complaints == []
    if look is LAPTOP:
        assert not_reached(page) == []


@pytest.mark.slow
def test_a_map_answers_on_its_first_screen(opened: Any) -> None:
    page, complaints = opened(mapped(), viewport=SMALL)
    assert (
        " ".join(page.inner_text("h1").split())
        == "Friction is 0.175 Nm at 95.5 rpm and 0.155 Nm at 382 rpm; the model is off by up to 0.0300 Nm."
    )
    box = page.locator("#law svg.picture").first.bounding_box()
    assert box["y"] + box["height"] <= SMALL["height"]
    assert page.locator("#law svg.picture").count() == 2 and complaints == []
