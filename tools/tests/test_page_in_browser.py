"""The pages of a diagnosis, of an identification and of a comparison in real Chromium, headless, with the network off: they draw without complaint, zoom and come back, say what the result says,
and can be used without a mouse."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from diagnosis_results import BINS, KINDS, diagnosis, diagnosis_page
from ema_tools.words.page.results import parse_result
from ema_tools.words.page.several_page import own_answers
from ema_tools.words.page.sheet import FirstScreen
from in_browser import LAPTOP, PHONE, SMALL, at_rest, first_paint_ms, hindrances, launched, not_reached
from report_results import JUDGED, compared_whole, judged
from support import ROOT

# Whole record of the made-up results, s.
_END = 9.999
COMPARED = "compared"


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with launched() as opened:
        yield opened


class Opened:
    """A page that was opened from disk; whatever it complains of."""

    def __init__(self, browser: Any, path: Path, **options: Any) -> None:
        self.context = browser.new_context(offline=True, viewport=options.pop("viewport", LAPTOP), **options)
        self.page = self.context.new_page()
        self.complaints: list[str] = []
        self.page.on("console", lambda one: self.complaints.append(one.text))
        self.page.on("pageerror", lambda one: self.complaints.append(str(one)))
        self.page.on("request", lambda one: self.complaints.append(one.url) if one.url.startswith("http") else None)
        self.page.goto(path.as_uri())
        self.page.wait_for_function("() => document.documentElement.dataset.drawnMs !== undefined")

    def text(self, selector: str) -> str:
        return " ".join(self.page.inner_text(selector).split())

    def rms(self, channel: str, model: str) -> float:
        return float(self.page.inner_text(f'[data-channel="{channel}"] [data-rms="{model}"]'))

    @property
    def view(self) -> tuple[float, float]:
        """Ends of what is in view, s."""
        first, last = self.page.get_attribute("#plots", "data-view").split()
        return float(first), float(last)

    @property
    def zoomed(self) -> bool:
        return bool(self.page.evaluate("document.body.classList.contains('zoomed')"))

    def read(self, channel: str) -> str:
        """What the crosshair reads of a channel, once it has come to rest."""
        at_rest(self.page)
        return self.text(f'[data-channel="{channel}"] [data-values]')

    def drag(self, channel: str, first: float, last: float) -> None:
        """Across the plot of a channel, from one share of its width to another."""
        # in the middle of the window: the menu covers its upper edge
        plot = self.page.locator(f'[data-channel="{channel}"] .plot.main .u-over')
        plot.evaluate("(one) => one.scrollIntoView({ block: 'center', behavior: 'instant' })")
        box = plot.bounding_box()
        mouse, middle = self.page.mouse, box["y"] + 0.5 * box["height"]
        mouse.move(box["x"] + first * box["width"], middle)
        self.read(channel)
        mouse.down()
        mouse.move(box["x"] + 0.5 * (first + last) * box["width"], middle, steps=3)
        mouse.move(box["x"] + last * box["width"], middle, steps=3)
        mouse.up()


def made(kind: str) -> dict[str, Any]:
    """A result of KINDS or JUDGED, or a comparison."""
    if kind == COMPARED:
        return compared_whole()
    return judged(kind) if kind in JUDGED else diagnosis(kind)


def said(data: dict[str, Any]) -> FirstScreen:
    """What the first screen of a result says."""
    return own_answers(parse_result(data, "x", "x"))


@pytest.fixture
def opened(browser: Any, tmp_path: Path) -> Iterator[Any]:
    contexts = []

    def open_(kind: str, **options: Any) -> Opened:
        found = Opened(browser, diagnosis_page(tmp_path, made(kind)), **options)
        contexts.append(found.context)
        return found

    yield open_
    for context in contexts:
        context.close()


def residual_rms(data: dict[str, Any], channel: str, model: str, scale: float, first: int = 0, last: int | None = None) -> float:
    here, simulated = (np.array(data["curves"][key][channel]) for key in ("measured", model))
    return scale * float(np.sqrt(np.mean((here - simulated)[first:last] ** 2)))


@pytest.mark.parametrize("kind", [KINDS[0], *(pytest.param(kind, marks=pytest.mark.slow) for kind in (*KINDS[1:], *JUDGED, COMPARED))])
def test_opens_without_network_or_complaint_and_says_what_the_result_says(kind: str, opened: Any) -> None:
    page, data = opened(kind), made(kind)
    assert page.complaints == []
    expected = said(data)
    assert page.text("h1") == expected.sentence
    assert [" ".join(text.split()) for text in page.page.locator(".reply b").all_inner_texts()] == [one.short for one in expected.replies]
    models = [key for key in ("before", "after", "model") if key in data["curves"]]
    for channel, scale in (("position_mm", 1000.0), ("current_A", 1.0), ("voltage_V", 1.0)):
        for model in models:
            assert page.rms(channel, model) == pytest.approx(residual_rms(data, channel, model, scale), rel=6e-3)
    assert page.page.locator(".plot .u-over").count() == 2 * 5
    inked = page.page.evaluate(
        "[...document.querySelectorAll('.plot canvas')].map((c) => c.getContext('2d').getImageData(0, 0, c.width, c.height).data.some((v, i) => i % 4 === 3 && v > 0))"
    )
    assert len(inked) == 10 and all(inked)


@pytest.mark.slow
@pytest.mark.parametrize("viewport", [SMALL, PHONE], ids=["laptop", "phone"])
@pytest.mark.parametrize("kind", [*KINDS, *JUDGED, COMPARED])
def test_ten_seconds_are_enough(kind: str, viewport: dict[str, int], opened: Any) -> None:
    """What a technician sees before anything is touched: the sentence, the five answers, the command, the sizes, and one whole curve, nothing of them cut."""
    touched = {"is_mobile": True, "has_touch": True} if viewport is PHONE else {}
    page, expected = opened(kind, viewport=viewport, **touched), said(made(kind))
    seen = page.page.evaluate(
        """(selectors) => Object.fromEntries(selectors.map((selector) => [selector, [...document.querySelectorAll(selector)].filter((one) => {
          const box = one.getBoundingClientRect();
          const inside = box.width > 0 && box.left >= 0 && box.top >= 0 && box.right <= innerWidth && box.bottom <= innerHeight;
          const above = document.elementFromPoint((box.left + box.right) / 2, (box.top + box.bottom) / 2);
          return inside && one.scrollWidth <= one.clientWidth + 1 && (one.contains(above) || above.contains(one));
        }).length]))""",
        ["h1", ".reply dt", ".reply b", ".reply code", ".reply button", ".gauge b", ".gauge .line", ".gauge .scale", ".plot.main"],
    )
    commands = sum(bool(one.command) for one in expected.replies)
    sizes = 2 if kind in JUDGED else 0
    assert page.text("h1") == expected.sentence and seen["h1"] == 1
    assert seen[".reply dt"] == seen[".reply b"] == 5 and seen[".reply code"] == seen[".reply button"] == commands
    assert seen[".gauge b"] == seen[".gauge .line"] == seen[".gauge .scale"] == sizes
    assert seen[".plot.main"] >= 1, seen
    assert page.page.evaluate("document.documentElement.scrollWidth") <= viewport["width"]


@pytest.mark.slow
def test_first_screen_is_there_within_a_second(opened: Any) -> None:
    page = opened("missing")
    for selector in ("h1", ".reply:last-child", '[data-channel="position_mm"] .plot.residual', '[data-channel="current_A"] .plot.residual'):
        box = page.page.locator(selector).bounding_box()
        assert box["y"] + box["height"] <= LAPTOP["height"], selector
    assert first_paint_ms(page.page) < 1000.0


@pytest.mark.slow
def test_zoom_is_undone_after_any_number_of_drags(opened: Any) -> None:
    page, data = opened("missing"), diagnosis("missing")
    whole = page.view
    assert whole == (0.0, _END)
    for undo in ("whole", "double click", "out", "key"):
        page.drag("position_mm", 0.2, 0.7)
        once = page.view
        assert once == pytest.approx((0.2 * _END, 0.7 * _END), abs=0.05)
        page.drag("current_A", 0.1, 0.5)
        page.drag("voltage_V", 0.3, 0.6)
        assert page.zoomed and once[0] < page.view[0] < page.view[1] < once[1]
        if undo == "whole":
            page.page.click('[data-zoom="whole"]')
        elif undo == "double click":
            page.page.locator('[data-channel="motor_position_mm"] .plot.residual .u-over').dblclick()
        elif undo == "key":
            page.page.focus("#plots")
            page.page.keyboard.press("Home")
        else:
            for _ in range(6):
                page.page.click('[data-zoom="out"]')
        assert not page.zoomed and page.view == whole, undo
    # half of the record: 5 s about the middle
    page.page.click('[data-zoom="in"]')
    expected = residual_rms(data, "current_A", "before", 1.0, 2500, 7500)
    assert page.rms("current_A", "before") == pytest.approx(expected, rel=1e-2)
    assert page.complaints == []


@pytest.mark.slow
def test_crosshair_reads_every_channel(opened: Any) -> None:
    page, data = opened("missing"), diagnosis("missing")
    box = page.page.locator('[data-channel="position_mm"] .plot.main .u-over').bounding_box()
    page.page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 20.0)
    said = page.read("current_A")
    time = float(said.split(" s:")[0])
    row = round(time * 1000.0)
    # the time is told to three digits, and so is the value
    near = [data["curves"]["measured"]["current_A"][place] for place in range(row - 6, row + 7)]
    value = float(said.split("measured ")[1].split(" ")[0].replace("−", "-"))
    assert min(abs(value - one) for one in near) <= 0.006 and "model" in said and "residual" in said
    assert "measured" in page.text('[data-channel="voltage_V"] [data-values]')


@pytest.mark.slow
def test_series_are_switched_and_a_rung_shows_its_model(opened: Any) -> None:
    page = opened("missing")
    shown = "[...document.querySelectorAll('[data-series]')].filter((box) => box.checked).map((box) => box.dataset.series)"
    ink = "document.querySelector('[data-channel=\"current_A\"] .plot.residual canvas').toDataURL()"
    before = page.page.evaluate(ink)
    page.page.uncheck('[data-series="before"]')
    assert page.page.evaluate(shown) == ["measured", "after"] and page.page.evaluate(ink) != before
    page.page.click('#ladder [data-model="before"]')
    assert page.page.evaluate(shown) == ["measured", "before"]


@pytest.mark.slow
def test_a_cell_lights_its_moments_and_a_zoom_lights_cells(opened: Any) -> None:
    page = opened("missing")
    ink = "document.querySelector('[data-channel=\"current_A\"] .plot.main canvas').toDataURL()"
    before = page.page.evaluate(ink)
    cell = page.page.locator('button.cell[data-by="time"]').nth(3)
    cell.click()
    assert cell.get_attribute("aria-pressed") == "true" and page.page.evaluate(ink) != before
    assert "time" in page.text("#cell") and "× noise" in page.text("#cell")
    cell.click()
    assert page.page.evaluate(ink) == before
    page.page.click('[data-zoom="in"]')
    lit = page.page.evaluate(
        "[...document.querySelectorAll('tbody tr:first-child button.cell[data-by=\"time\"]')].map((one) => one.classList.contains('lit'))"
    )
    assert lit == [BINS // 4 <= place < 3 * BINS // 4 for place in range(BINS)] or sum(lit) == BINS // 2 + 1


@pytest.mark.slow
def test_maps_and_plots_answer_to_keys(opened: Any) -> None:
    page = opened("missing")
    page.page.locator('button.cell[data-by="time"]').first.focus()
    page.page.keyboard.press("ArrowRight")
    page.page.keyboard.press("Enter")
    assert page.page.evaluate("document.activeElement.dataset.bin") == "1"
    assert page.page.evaluate("document.activeElement.getAttribute('aria-pressed')") == "true"
    page.page.focus("#plots")
    page.page.keyboard.press("ArrowRight")
    assert page.text("#reading").startswith("0 s:")
    page.page.keyboard.press("+")
    assert page.zoomed


@pytest.mark.slow
@pytest.mark.parametrize("look", ["laptop", "dark", "phone"])
@pytest.mark.parametrize("kind", ["missing", JUDGED[0], JUDGED[2], COMPARED])
def test_nothing_serious_stands_in_the_way_of_any_reader(kind: str, look: str, opened: Any) -> None:
    page = opened(kind, viewport=PHONE if look == "phone" else LAPTOP, color_scheme="dark" if look == "dark" else "light")
    assert hindrances(page.page) == []


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["missing", JUDGED[2]])
def test_everything_is_reached_without_a_mouse(kind: str, opened: Any) -> None:
    assert not_reached(opened(kind).page) == []


@pytest.mark.slow
def test_signals_of_an_identification_zoom_as_those_of_a_diagnosis(opened: Any) -> None:
    page = opened(JUDGED[0])
    whole = page.view
    page.drag("position_mm", 0.2, 0.7)
    once = page.view
    assert page.zoomed and whole[0] < once[0] < once[1] < whole[1]
    assert "measured" in page.read("position_mm") and "measured" in page.text('[data-channel="voltage_V"] [data-values]')
    page.page.focus("#plots")
    page.page.keyboard.press("Home")
    assert not page.zoomed and page.view == whole


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "longest"), [("missing", 13_000), *((kind, 6_500) for kind in JUDGED)])
def test_phone_has_no_sideways_scroll_and_no_more_length_than_needed(kind: str, longest: int, opened: Any) -> None:
    page = opened(kind, viewport=PHONE, is_mobile=True, has_touch=True)
    assert page.page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]
    assert page.page.evaluate("document.documentElement.scrollHeight") <= longest
    # what an answer leaves out there is shown at a touch
    more = page.page.locator(".reply small").first
    assert not more.is_visible()
    page.page.locator(".reply").first.tap()
    assert more.is_visible()


@pytest.mark.slow
def test_command_is_copied(opened: Any) -> None:
    page = opened("missing", permissions=["clipboard-read", "clipboard-write"])
    page.page.click("[data-copy]")
    page.page.wait_for_function("() => document.querySelector('[data-copy]').textContent === 'copied'")
    assert page.page.evaluate("navigator.clipboard.readText()").startswith("ema add mine.toml stribeck_friction --fit today.csv")


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["missing", JUDGED[2]])
def test_it_prints_on_few_sheets(kind: str, opened: Any) -> None:
    page = opened(kind, color_scheme="dark")
    printed = page.page.pdf(format="A4", print_background=True)
    assert printed.startswith(b"%PDF") and 2 <= printed.count(b"/Type /Page\n") + printed.count(b"/Type /Page ") <= 6
    # afterwards the screen is dark again
    assert page.page.evaluate("document.documentElement.dataset.light") is None


@pytest.mark.slow
def test_looks_for_the_documents_are_drawn(browser: Any, tmp_path: Path) -> None:
    # a driver of its own: two cannot run in one thread
    path = diagnosis_page(tmp_path, diagnosis("healthy"))
    ran = subprocess.run(
        [sys.executable, "-m", "benchmarks.page_looks", path, tmp_path, "x"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert ran.returncode == 0, ran.stderr
    for look, width in (("laptop", 1366), ("dark", 1366), ("phone", 780)):
        picture = (tmp_path / f"x_{look}.png").read_bytes()
        assert picture[:4] == b"\x89PNG" and int.from_bytes(picture[16:20], "big") == width
    assert (tmp_path / "x_dark.png").read_bytes() != (tmp_path / "x_laptop.png").read_bytes()
