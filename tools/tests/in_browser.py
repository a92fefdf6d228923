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
