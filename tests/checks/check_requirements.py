"""Compares docs/REQUIREMENTS.md with code and tests; no library serves: programs for traceability want requirements in a format of their own.

Every requirement names functions of the module and tests that are run; every public function and every unit test program belongs to a requirement.
"""

from __future__ import annotations

import re
import sys
from fnmatch import fnmatch
from pathlib import Path

from sources import c_files, run, without_comments

PAGE = Path("docs") / "REQUIREMENTS.md"
ROW = re.compile(r"^\| (EMA-\d+) \| (.+?) \| (.*?) \| (.*?) \|$", re.MULTILINE)
NAMED = re.compile(r"`([^`]+)`")
PUBLIC = re.compile(r"^[a-z][\w ]*?\*? ?\b(ema_\w+)\(", re.MULTILINE)
RUN_TEST = re.compile(r"\bRUN_TEST\((\w+)\)")
CTEST = re.compile(r"\bNAME\s+(\w+)")


def public_functions(root: Path) -> set[str]:
    """Functions that the public headers declare."""
    found: set[str] = set()
    for path in c_files(root, "include", suffixes=(".h",)):
        text = without_comments(path.read_text(encoding="utf-8"))
        found |= {match[1] for match in PUBLIC.finditer(text) if not match[0].lstrip().startswith(("static", "typedef", "define"))}
    return found


def unit_tests(root: Path) -> dict[str, set[str]]:
    """Tests that each program runs, by the program's name without `test_`; a test's name is also known without its `test_`."""
    found: dict[str, set[str]] = {}
    for path in sorted((root / "tests" / "unit").glob("test_*.c")):
        names = set(RUN_TEST.findall(path.read_text(encoding="utf-8")))
        found[path.stem.removeprefix("test_")] = names | {name.removeprefix("test_") for name in names}
    return found


def other_tests(root: Path) -> set[str]:
    """Names of the tests that CMake adds besides."""
    found: set[str] = set()
    for path in [*(root / "tests").rglob("CMakeLists.txt"), *(root / "tests").rglob("*.cmake")]:
        found |= set(CTEST.findall(path.read_text(encoding="utf-8")))
    return found


def check(root: Path) -> tuple[list[str], int]:
    """Gaps between the page, the headers and the tests, and the number of requirements."""
    page = root / PAGE
    rows = ROW.findall(page.read_text(encoding="utf-8")) if page.is_file() else []
    functions, programs, others = public_functions(root), unit_tests(root), other_tests(root)
    problems: list[str] = []
    traced: set[str] = set()
    behind: set[str] = set()
    for number, (identity, _, code, tests) in enumerate(rows, start=1):
        if identity != f"EMA-{number:03}":
            problems.append(
                f"{PAGE}: {identity} stands where EMA-{number:03} is next: requirements are numbered without gaps, and a number is never used again"
            )
        named = NAMED.findall(code)
        for name in named:
            if name not in functions:
                problems.append(f"{PAGE}: {identity}: {name} is no function of include/ema: correct the name")
        traced |= set(named)
        cited = NAMED.findall(tests)
        if not cited:
            problems.append(f"{PAGE}: {identity}: no test stands behind it: write one and name it")
        for name in cited:
            program, colon, test = name.partition(":")
            matching = [known for known in programs if fnmatch(known, program)]
            if not colon:
                if name not in others:
                    problems.append(f"{PAGE}: {identity}: {name} is no test that CMake adds: correct the name")
            elif not matching:
                problems.append(f"{PAGE}: {identity}: tests/unit/test_{program}.c is not there: correct the name")
            elif test != "*" and not any(test in programs[known] for known in matching):
                problems.append(f"{PAGE}: {identity}: test_{program}.c runs no test {test}: correct the name, or write it")
            behind |= set(matching)
    if rows:
        problems += [f"{PAGE}: {name} has no requirement: state what it must do" for name in sorted(functions - traced)]
        problems += [
            f"{PAGE}: test_{name}.c stands behind no requirement: name it, or leave it out" for name in sorted(set(programs) - behind)
        ]
    return problems, len(rows)


if __name__ == "__main__":
    sys.exit(run("requirements", "requirements", check, __doc__))
