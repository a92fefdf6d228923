"""Lines and branches of src that the unit tests reach, read from what gcovr writes. Python's standard library alone.

The same file is compiled into several libraries: both precisions, and builds without some effects. gcovr counts branches of a line by their order, which is the same
only where the line has as many, so its own union of them would credit one branch with another's run: here libraries are joined line by line.
"""

from __future__ import annotations

import json
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

Place = tuple[str, int]


@dataclass
class Line:
    """One line of code: whether it ran, and which of its branches were taken."""

    ran: bool
    taken: list[bool]

    def join(self, other: Line) -> None:
        """What another library ran of it."""
        self.ran = self.ran or other.ran
        if len(self.taken) == len(other.taken):
            self.taken = [mine or others for mine, others in zip(self.taken, other.taken, strict=True)]


def read(written: dict[str, Any]) -> dict[Place, Line]:
    """The lines of one library by file and number."""
    result: dict[Place, Line] = {}
    for file in written["files"]:
        for line in file["lines"]:
            if not line.get("gcovr/noncode", False):
                taken = [branch["count"] > 0 for branch in line["branches"]]
                result[(file["file"], line["line_number"])] = Line(line["count"] > 0, taken)
    return result


def join(libraries: list[dict[Place, Line]]) -> dict[Place, Line]:
    """All libraries; the first says which lines and branches there are."""
    result = libraries[0]
    for library in libraries[1:]:
        for place, line in library.items():
            if place in result:
                result[place].join(line)
            else:
                result[place] = line
    return result


def measure(gcovr: str, root: Path, build: Path, library: Path) -> dict[Place, Line]:
    """What ran of one library's objects."""
    written = build / "coverage-lines.json"
    command = [
        gcovr,
        "--root",
        str(root),
        "--filter",
        "src/",
        "--object-directory",
        str(build),
        str(build / library),
        "--exclude-unreachable-branches",
        "--json",
        str(written),
    ]
    subprocess.run(command, check=True, cwd=root, stdout=subprocess.DEVNULL)
    return read(json.loads(written.read_text(encoding="utf-8")))
