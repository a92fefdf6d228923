"""Pictures of a page for the documents: on a laptop, in the dark and on a phone, by the machine's own Chromium.

build/venv/bin/python -m benchmarks.page_looks PAGE.html docs walk_page
"""

from __future__ import annotations

import argparse
import shutil
import sys
from pathlib import Path
from typing import Any

_BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
_LAPTOP, _PHONE = {"width": 1366, "height": 768}, {"width": 390, "height": 844}
LOOKS: dict[str, dict[str, Any]] = {
    "laptop": {"viewport": _LAPTOP},
    "dark": {"viewport": _LAPTOP, "color_scheme": "dark"},
    "phone": {"viewport": _PHONE, "device_scale_factor": 2, "is_mobile": True},
}


def write_looks(page: Path, folder: Path, name: str, browser: str) -> list[Path]:
    """Writes `<name>_<look>.png` of the first screen for every look; returns their paths."""
    from playwright.sync_api import sync_playwright

    written = []
    with sync_playwright() as driver:
        opened = driver.chromium.launch(executable_path=browser, args=["--no-sandbox"])
        for look, options in LOOKS.items():
            context = opened.new_context(offline=True, **options)
            shown = context.new_page()
            shown.goto(page.resolve().as_uri())
            shown.wait_for_timeout(300)
            written.append(folder / f"{name}_{look}.png")
            shown.screenshot(path=written[-1])
            context.close()
        opened.close()
    return written


def main() -> int:
    """Entry point; 0 when the pictures are written."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("page", type=Path, metavar="PAGE.html")
    parser.add_argument("folder", type=Path, metavar="OUTDIR")
    parser.add_argument("name", metavar="NAME")
    given = parser.parse_args()
    browser = next((path for one in _BROWSERS if (path := shutil.which(one))), None)
    if browser is None:
        print(f"no browser to look at the page: install one of {', '.join(_BROWSERS)}", file=sys.stderr)
        return 1
    if not given.page.is_file() or not given.folder.is_dir():
        print(f"{given.page}: no such page, or {given.folder}: no such folder", file=sys.stderr)
        return 1
    for written in write_looks(given.page, given.folder, given.name, browser):
        print(written)
    return 0


if __name__ == "__main__":
    sys.exit(main())
