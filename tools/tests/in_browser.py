"""Real Chromium, headless, for tests that look at pages; skipped with a clear message where there is none."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from ema_tools.words.page import uplot

_BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
LAPTOP, PHONE = {"width": 1366, "height": 768}, {"width": 390, "height": 844}
SMALL = {"width": 1280, "height": 720}


@contextmanager
def launched() -> Iterator[Any]:
    """A browser, and the charting library that its pages need."""
    playwright = pytest.importorskip("playwright.sync_api", reason="the tests in the browser need the Python package playwright")
    found = next((path for name in _BROWSERS if (path := shutil.which(name))), None)
    if found is None:
        pytest.skip(f"no browser to look at the page: install one of {', '.join(_BROWSERS)}")
    if not uplot.library().there:
        pytest.skip("the charting library is not in the build folder: install nodejs and npm, then build again")
    with playwright.sync_playwright() as driver:
        opened = driver.chromium.launch(executable_path=found, args=["--no-sandbox", "--disable-gpu"])
        yield opened
        opened.close()


def first_paint_ms(page: Any, loads: int = 3) -> float:
    """When something was first seen, ms after the page was asked for: the least of a few loads, since a busy machine only adds. A page is complete before it is painted, hence the wait."""
    waits = """new Promise((resolve) => new PerformanceObserver((list, one) => {
      const seen = list.getEntriesByName("first-contentful-paint");
      if (seen.length) { one.disconnect(); resolve(seen[0].startTime); }
    }).observe({ type: "paint", buffered: true }))"""
    least: float = page.evaluate(waits)
    for _ in range(loads - 1):
        page.reload()
        least = min(least, page.evaluate(waits))
    return least


def at_rest(page: Any) -> None:
    """Waits until what was asked for is drawn: pages draw in the next frame, and may ask for one more in it."""
    page.evaluate(
        "new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(resolve)))))"
    )


def hindrances(page: Any) -> list[Any]:
    """What axe-core finds serious or critical on a page as it stands, with every part that can be opened open."""
    script = uplot.packages() / "axe-core" / "axe.min.js"
    if not script.is_file():
        pytest.skip("axe-core is not in the build folder: build with tests, nodejs and npm")
    page.evaluate("for (const one of document.querySelectorAll('details')) one.open = true")
    page.evaluate(script.read_text(encoding="utf-8"))
    found = page.evaluate("axe.run().then((one) => one.violations.map((v) => [v.impact, v.id, v.nodes.length, v.nodes[0].html]))")
    return [one for one in found if one[0] in ("serious", "critical")]


def not_reached(page: Any) -> list[str]:
    """What can be used with a mouse and is not reached by the tab key, or is reached and does not show it."""
    page.evaluate(
        """() => {
          const all = [...document.querySelectorAll("a[href], button, input, select, summary, [tabindex]")].filter((one) => one.tabIndex >= 0 && !one.disabled && one.getClientRects().length);
          all.forEach((one, place) => { one.dataset.stop = place; });
          document.activeElement.blur();
        }"""
    )
    waiting = dict(
        page.evaluate("[...document.querySelectorAll('[data-stop]')].map((one) => [one.dataset.stop, one.outerHTML.slice(0, 120)])")
    )
    for _ in range(len(waiting) + 2):
        page.keyboard.press("Tab")
        place, seen = page.evaluate(
            """() => {
              const one = document.activeElement, look = getComputedStyle(one);
              return [one.dataset.stop ?? "", look.outlineStyle !== "none" && parseFloat(look.outlineWidth) > 0];
            }"""
        )
        if seen:
            waiting.pop(place, None)
    return list(waiting.values())
