"""Holds the layout of all C by .clang-format and of all Python by ruff's formatter; any file that a formatter would change fails.

A file with a known fault of either kind is looked at with the rest: where it is not found, nothing else was sought either. Headers that `ema export` wrote are
left as it writes them. Run by a Python that has both formatters: the preset analysis makes one.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from check_python import PACKAGES, SCRIPTS, TESTS, python_files
from sources import c_files, fail, finish

C_FOLDERS = ("examples", "include", "port", "src", "tests")
C_FINDING = re.compile(r"^(.+?):(\d+):\d+: (?:error|warning): code should be clang-formatted", re.MULTILINE)
PYTHON_FINDING = re.compile(r"^ *--> (.+?):\d+:\d+$", re.MULTILINE)
SEEDED_C = "int ema_seeded( void );\n"
SEEDED_PYTHON = "seeded = ( 1 )\n"


def clang_format() -> str | None:
    """The formatter of this Python's environment; another version would lay out otherwise."""
    beside = Path(sys.executable).parent / "clang-format"
    return str(beside) if beside.is_file() else None


def formatted_c(root: Path, program: str, files: list[Path], seeded: Path) -> list[str]:
    """Problems of the C files, one line each."""
    command = [program, f"--style=file:{root / '.clang-format'}", "--dry-run", "--Werror", *map(str, (*files, seeded))]
    ran = subprocess.run(command, capture_output=True, text=True, check=False)
    found: dict[Path, str] = {}
    for match in C_FINDING.finditer(ran.stderr):
        found.setdefault(Path(match[1]).resolve(), match[2])
    if found.pop(seeded, None) is None:
        return [f"clang-format: finds nothing in a file with a known fault: {(ran.stderr or 'it says nothing').strip().splitlines()[0]}"]
    return [f"{path.relative_to(root)}:{line}: not laid out: run clang-format -i on it" for path, line in found.items()]


def formatted_python(root: Path, files: list[Path], seeded: Path) -> list[str]:
    """Problems of the Python files, one line each."""
    command = [sys.executable, "-m", "ruff", "format", "--check", "--no-cache", "--config", "pyproject.toml", *map(str, (*files, seeded))]
    ran = subprocess.run(command, cwd=root / "tools", capture_output=True, text=True, check=False)
    found = {(root / "tools" / name).resolve() for name in PYTHON_FINDING.findall(ran.stdout)}
    if seeded not in found:
        return [f"ruff format: finds nothing in a file with a known fault: {(ran.stderr or 'it says nothing').strip().splitlines()[0]}"]
    return [f"{path.relative_to(root)}: not laid out: run ruff format on it" for path in sorted(found - {seeded})]


def check(root: Path, program: str) -> tuple[list[str], int]:
    """Problems, and the number of files looked at."""
    c = c_files(root, *C_FOLDERS, suffixes=(".c", ".h"))
    python = python_files(root, *PACKAGES, TESTS, *SCRIPTS)
    if not c or not python:
        return [], 0
    with tempfile.TemporaryDirectory() as folder:
        seeded_c, seeded_python = (Path(folder).resolve() / f"ema_seeded{suffix}" for suffix in (".c", ".py"))
        seeded_c.write_text(SEEDED_C, encoding="utf-8")
        seeded_python.write_text(SEEDED_PYTHON, encoding="utf-8")
        problems = [*formatted_c(root, program, c, seeded_c), *formatted_python(root, python, seeded_python)]
    return problems, len(c) + len(python)


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--root", type=Path, required=True)
    root = parser.parse_args().root.resolve()
    program = clang_format()
    if program is None or shutil.which(program) is None:
        return fail(f"format: {sys.executable} has no clang-format beside it: run cmake --workflow --preset analysis, which installs it")
    problems, checked = check(root, program)
    return finish("format", problems, checked, "files")


if __name__ == "__main__":
    sys.exit(main())
