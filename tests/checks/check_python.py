"""Holds the Python against mypy's strict rules and against ruff's, by the settings in tools/pyproject.toml; any finding fails.

mypy looks at the packages and at the scripts, ruff at the tests too. A file with a known fault of either kind is looked at with the rest:
where it is not found, nothing else was sought either. Run by a Python that has both, and the types of what the tools use: the preset analysis makes one.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from sources import fail, finish

PACKAGES = ("tools/ema_tools", "tools/reference_model", "benchmarks")
TESTS = "tools/tests"
SCRIPTS = ("cmake", "examples", "tests")
FINDING = re.compile(r"^(.+?\.pyi?):(\d+):(?:\d+:)? (?:error: )?(.*)$")
LOOKED_AT = re.compile(r"\b(?:in|checked) (\d+) source files?\b")

# An import that nothing uses, and a number that is no text.
SEEDED = "import os\n\n\ndef ema_seeded(count: int) -> str:\n    return count\n"


def python_files(root: Path, *folders: str) -> list[Path]:
    """All Python files below the given folders of the project, sorted by path."""
    return sorted(path for folder in folders for path in (root / folder).rglob("*.py") if path.is_file())


def missing(*tools: str) -> list[str]:
    """Those that this Python does not have."""
    return [tool for tool in tools if importlib.util.find_spec(tool) is None]


def run(tool: str, root: Path, arguments: list[str]) -> tuple[list[str], str]:
    """Findings of one run, one line each, paths from the root; and what it printed. A run that fails without one says so."""
    folder = root / "tools"
    ran = subprocess.run([sys.executable, "-m", tool, *arguments], cwd=folder, capture_output=True, text=True, check=False)
    found: list[str] = []
    for line in ran.stdout.splitlines():
        match = FINDING.match(line)
        if match is not None and not match.group(3).startswith("note: "):
            path = Path(os.path.abspath(folder / match.group(1)))
            found.append(f"{path.relative_to(root) if path.is_relative_to(root) else path.name}:{match.group(2)}: {match.group(3)}")
    if ran.returncode != 0 and not found:
        found.append(f"{tool} failed: {(ran.stderr or ran.stdout).strip().splitlines()[-1:]}: see the settings in tools/pyproject.toml")
    return found, ran.stdout


def rest(tool: str, found: list[str], seeded: str) -> list[str]:
    """The findings without the known one `seeded`, or that it was not found."""
    if not any(one.startswith("ema_seeded.py:") and seeded in one for one in found):
        return [*found, f"{tool}: finds nothing in a file with a known fault: see the settings in tools/pyproject.toml"]
    return [one for one in found if not one.startswith("ema_seeded.py:")]


def check(root: Path, cache: Path) -> tuple[list[str], int]:
    """Problems, and the number of files looked at. `cache`: folder in which mypy keeps what it knows of unchanged files."""
    package, scripts, tests = python_files(root, *PACKAGES), python_files(root, *SCRIPTS), python_files(root, TESTS)
    files = [*package, *scripts, *tests]
    if not package:
        return [], 0
    with tempfile.TemporaryDirectory() as folder:
        seeded = Path(folder).resolve() / "ema_seeded.py"
        seeded.write_text(SEEDED, encoding="utf-8")
        # ruff is given every file by name: of a folder it leaves out what version control ignores, in silence.
        ruff, _ = run(
            "ruff", root, ["check", "--no-cache", "--output-format", "concise", "--config", "pyproject.toml", *map(str, (*files, seeded))]
        )
        mypy, said = run(
            "mypy", root, ["--config-file", "pyproject.toml", "--cache-dir", str(cache), *map(str, (*package, *scripts, seeded))]
        )
    problems = [*rest("ruff", ruff, "F401"), *rest("mypy", mypy, "[return-value]")]
    looked_at = LOOKED_AT.search(said)
    wanted = len(package) + len(scripts) + 1
    if looked_at is None or int(looked_at.group(1)) != wanted:
        problems.append(
            f"mypy: looked at {looked_at.group(1) if looked_at else 0} of {wanted} files: see the settings in tools/pyproject.toml"
        )
    return problems, len(files)


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--root", type=Path, required=True)
    parser.add_argument("--build", type=Path, required=True)
    arguments = parser.parse_args()
    absent = missing("mypy", "ruff")
    if absent:
        return fail(
            f"python: {sys.executable} has no {' and no '.join(absent)}: run cmake --workflow --preset analysis, which installs them into its build folder"
        )
    problems, checked = check(arguments.root.resolve(), arguments.build.resolve() / "mypy")
    return finish("python", problems, checked, "files")


if __name__ == "__main__":
    sys.exit(main())
