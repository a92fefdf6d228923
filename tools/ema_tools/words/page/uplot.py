"""The charting library of the diagnosis page, from the build folder: it comes as a package and is never part of the project's own files.

uPlot draws 10^5 points in some milliseconds and is 51 kB, where a general library is some megabytes. The build fetches it (cmake/make_page_library.py, versions in tools/page/package-lock.json).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ema_tools.library.definitions import library_folder

ABSENT = (
    "The curves are left out: the charting library was not there when this page was written. Install the packages nodejs and npm, "
    "run cmake --workflow --preset demo again, and write the page again."
)


@dataclass(frozen=True)
class ChartLibrary:
    """Script and style sheet of the library, as text; both empty where it is not there."""

    script: str = ""
    style: str = ""

    @property
    def there(self) -> bool:
        """Whether there is anything to draw with."""
        return bool(self.script)


def packages() -> Path:
    """Where the build puts the packages of the page."""
    return library_folder() / "page" / "node_modules"


def library() -> ChartLibrary:
    """The library, or an empty one."""
    folder = packages() / "uplot" / "dist"
    script, style = folder / "uPlot.iife.min.js", folder / "uPlot.min.css"
    if not (script.is_file() and style.is_file()):
        return ChartLibrary()
    return ChartLibrary(script.read_text(encoding="utf-8"), style.read_text(encoding="utf-8"))
