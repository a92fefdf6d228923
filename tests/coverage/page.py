"""Holds what the unit tests of C reach of src against its limits, against the table of explained gaps, and against docs/COVERAGE.md.

`lines` measures lines and branches after the tests of the preset `coverage`, `mcdc` the conditions of decisions after those of the preset `mcdc`. Every gap needs its
explanation in gaps.toml, and every explanation its gap. With another compiler than the page's the limits are held alone. Python's standard library alone.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tomllib
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path

import mcdc
import reached

# Least share in %, by what is counted.
LIMITS = {"lines": 99.0, "branches": 99.0, "conditions": 95.0}
SECTIONS = {"lines": "Lines and branches", "mcdc": "Conditions"}
COUNTED = {"lines": ("lines", "branches"), "mcdc": ("conditions",)}
# Libraries by their folder of objects, and the tests that run them by the end of their names: both precisions, and builds without some effects or without any
# or with one kind of actuator and record.
LIBRARIES = {
    "f32": "CMakeFiles/ema.dir",
    "f64": "CMakeFiles/ema64.dir",
    "some": "tests/CMakeFiles/ema_some.dir",
    "none": "tests/CMakeFiles/ema_none.dir",
    "fixed": "tests/CMakeFiles/ema_fixed.dir",
    "fixed_effects": "tests/CMakeFiles/ema_fixed_effects.dir",
}
# Problems that are printed; more of them have one cause.
SHOWN = 20
TABLE = "tests/coverage/gaps.toml"
PAGE = "docs/COVERAGE.md"

HEAD = f"""# Coverage

What the unit tests of C alone reach of `src`, without the Python tools and without fuzzing: in float32 and float64 together, and in the builds that leave effects out or fix what can be fixed.
Written by commands, which also hold every number here:

```
cmake --workflow --preset coverage    lines and branches; `cmake --build build-coverage --target coverage_write` writes them
cmake --workflow --preset mcdc        conditions; `cmake --build build-mcdc --target coverage_write` writes them
```

A gap without its explanation in `{TABLE}` fails them, and so does an explanation without its gap.
At least {LIMITS["lines"]:.0f} % of lines, {LIMITS["branches"]:.0f} % of branches and {LIMITS["conditions"]:.0f} % of conditions must be reached.
"""

ABOUT = {
    "lines": "A branch is one way out of a line as gcc compiles it without optimisation: each condition of a decision has two.",
    "mcdc": "A decision is a whole expression of conditions with `&&` and `||` between them. A condition counts as reached when tests have shown that it alone turns the decision\n"
    "(modified condition and decision coverage). Conditions that are known when compiling are not counted; decisions of a macro count wherever it is used.",
}


class PageError(Exception):
    """Why nothing can be said."""


@dataclass
class Count:
    """How many there are, and how many were reached."""

    total: int = 0
    hit: int = 0

    def add(self, total: int, hit: int) -> None:
        """More of them."""
        self.total += total
        self.hit += hit

    @property
    def percent(self) -> float:
        """Share that was reached."""
        return 100.0 * self.hit / self.total if self.total else 100.0


@dataclass
class Measured:
    """Counts by kind and file; gaps by kind, file and line of code; the conditions that gaps are about."""

    counts: dict[str, dict[str, Count]]
    gaps: dict[tuple[str, str, str], int] = field(default_factory=lambda: defaultdict(int))
    about: dict[tuple[str, str], list[str]] = field(default_factory=lambda: defaultdict(list))

    def total(self, kind: str) -> Count:
        """Over all files."""
        whole = Count()
        for count in self.counts[kind].values():
            whole.add(count.total, count.hit)
        return whole


@dataclass(frozen=True)
class Explained:
    """One row of the table: a part of a line of code, how many of each kind are not reached there, and why."""

    file: str
    code: str
    why: str
    missed: dict[str, int]


def read_table(path: Path) -> list[Explained]:
    """The explanations. Raises PageError that names the row."""
    rows: list[Explained] = []
    for number, row in enumerate(tomllib.loads(path.read_text(encoding="utf-8")).get("gap", []), start=1):
        missed = {kind: row[kind] for kind in LIMITS if kind in row}
        unknown = sorted(set(row) - {"file", "code", "why", *LIMITS})
        if unknown:
            raise PageError(
                f"{path.name}, gap {number}: `{unknown[0]}` is no key: give file, code, why and a number of {', '.join(LIMITS)}"
            )
        if not all(isinstance(row.get(key), str) and row[key].strip() for key in ("file", "code", "why")):
            raise PageError(f"{path.name}, gap {number}: give file, code and why")
        if not missed or not all(isinstance(count, int) and count > 0 for count in missed.values()):
            raise PageError(f"{path.name}, gap {number}: say how many {', '.join(LIMITS)} are not reached")
        rows.append(Explained(row["file"], row["code"], row["why"].strip(), missed))
    return rows


def line_of(root: Path, file: str, number: int) -> str:
    """A line of code as gaps are named: by its text, which stays when other lines come and go."""
    return (root / file).read_text(encoding="utf-8").splitlines()[number - 1].strip()


def measured_lines(root: Path, lines: dict[reached.Place, reached.Line]) -> Measured:
    """Lines and branches as counts and gaps."""
    found = Measured({"lines": defaultdict(Count), "branches": defaultdict(Count)})
    for (file, number), line in sorted(lines.items()):
        found.counts["lines"][file].add(1, int(line.ran))
        found.counts["branches"][file].add(len(line.taken), sum(line.taken))
        if not line.ran:
            found.gaps[("lines", file, line_of(root, file, number))] += 1
        if not all(line.taken):
            found.gaps[("branches", file, line_of(root, file, number))] += line.taken.count(False)
    return found


def measured_mcdc(root: Path, decisions: dict[mcdc.Key, mcdc.Decision]) -> Measured:
    """Conditions as counts and gaps."""
    found = Measured({"conditions": defaultdict(Count)})
    for (name, _, place, _), decision in sorted(decisions.items()):
        file = Path(name).relative_to(root).as_posix()
        found.counts["conditions"][file].add(decision.count, decision.count - decision.missed)
        if decision.missed:
            code = line_of(root, file, place[0])
            found.gaps[("conditions", file, code)] += decision.missed
            found.about[(file, code)] += decision.missing()
    return found


def problems_of(found: Measured, table: list[Explained]) -> list[str]:
    """What is below its limit, not explained, or explained and not there."""
    problems: list[str] = []
    for kind in found.counts:
        whole = found.total(kind)
        if not whole.total:
            problems.append(f"no {kind} were counted: run the tests of this build first")
        elif whole.percent < LIMITS[kind]:
            problems.append(f"{whole.percent:.2f} % of {kind} are reached, not {LIMITS[kind]:.0f} %")
    return problems + unexplained(found, table)


def unexplained(found: Measured, table: list[Explained]) -> list[str]:
    """Gaps and explanations that do not meet."""
    problems: list[str] = []
    met: dict[tuple[int, str], int] = defaultdict(int)
    for (kind, file, code), missed in found.gaps.items():
        rows = [number for number, row in enumerate(table) if row.file == file and row.code in code and kind in row.missed]
        if len(rows) > 1:
            problems.append(f"{TABLE}: `{table[rows[0]].code}` and `{table[rows[1]].code}` are both about `{code}`: write more of the line")
        elif not rows:
            problems.append(f"{file}: {missed} of the {kind} of `{code}` not reached: write a test in tests/unit, or explain it in {TABLE}")
        else:
            met[(rows[0], kind)] += missed
    for number, row in enumerate(table):
        for kind, missed in row.missed.items():
            if kind in found.counts and met[(number, kind)] != missed:
                problems.append(
                    f"{TABLE}: {missed} of the {kind} of `{row.code}` in {row.file} are explained, {met[(number, kind)]} are not reached: correct the row or take it out"
                )
    return problems


def section(what: str, found: Measured, table: list[Explained], compiler: str) -> str:
    """The page's section of one measurement."""
    kinds = COUNTED[what]
    lines = [f"## {SECTIONS[what]}", "", f"Measured with {compiler}. {ABOUT[what]}", ""]
    # no totals: a page that every new line of code made stale would be rewritten without being read
    lines += ["| file |" + "".join(f" {kind} not reached | % reached |" for kind in kinds), "|---|" + "---:|---:|" * len(kinds)]
    files = sorted({file for kind in kinds for file, count in found.counts[kind].items() if count.total})
    rows = [("all", [found.total(kind) for kind in kinds])] + [
        (f"`{file}`", [found.counts[kind].get(file, Count()) for kind in kinds]) for file in files
    ]
    for name, counts in rows:
        lines.append(
            f"| {name} |" + "".join(f" {count.total - count.hit} | {count.percent:.1f} |" if count.total else " | |" for count in counts)
        )
    explained = [row for row in table if any(kind in row.missed for kind in kinds)]
    lines += ["", f"### What is not reached of {' and '.join(kinds)}", ""]
    if explained:
        lines += ["| where | how many | why |", "|---|---|---|"]
    else:
        lines.append("Nothing.")
    for row in explained:
        missed = ", ".join(f"{row.missed[kind]} of the {kind}" for kind in kinds if kind in row.missed)
        asked = [text for (file, code), texts in found.about.items() if file == row.file and row.code in code for text in texts]
        missed += "".join(f", `{text}`" for text in asked)
        # a bar would end the cell
        lines.append(f"| `{row.file}`: `{row.code}` | {missed} | {row.why} |".replace("||", "\\|\\|"))
    return "\n".join(lines) + "\n"


def sections_of(page: str) -> dict[str, str]:
    """The sections of a page that was written."""
    result: dict[str, str] = {}
    for what, title in SECTIONS.items():
        match = re.search(rf"^## {re.escape(title)}\n.*?(?=^## |\Z)", page, re.MULTILINE | re.DOTALL)
        if match:
            result[what] = match.group(0).rstrip("\n") + "\n"
    return result


def with_section(page: str, what: str, text: str) -> str:
    """The page with that section in place of the old one."""
    sections = {**sections_of(page), what: text}
    return "\n".join([HEAD, *(sections[name] for name in SECTIONS if name in sections)])


def first_difference(was: str, now: str) -> str:
    """The first line that differs, in both."""
    old, new = was.splitlines(), now.splitlines()
    for number in range(max(len(old), len(new))):
        pair = (old[number] if number < len(old) else "", new[number] if number < len(new) else "")
        if pair[0] != pair[1]:
            return f"`{pair[0]}` is now `{pair[1]}`"
    return "the head is another"


def page_problems(page: str, what: str, text: str) -> list[str]:
    """Whether the page says what was measured."""
    if with_section(page, what, text) == page:
        return []
    return [f"{PAGE}: {first_difference(page, with_section(page, what, text))}: write it by this build's target `coverage_write`"]


def version_of(program: str) -> str:
    """The version that a program says first."""
    run = subprocess.run([program, "--version"], check=True, capture_output=True, text=True)
    match = re.search(r"\d+(\.\d+)+", run.stdout)
    if not match:
        raise PageError(f"{program} says no version")
    return match.group(0)


def measure(given: argparse.Namespace) -> tuple[Measured, str]:
    """What the tests of a build reached, and by which programs that was told."""
    root, build = given.root, given.build
    if given.what == "lines":
        libraries = [reached.measure(given.gcovr, root, build, Path(folder)) for folder in LIBRARIES.values()]
        return measured_lines(root, reached.join(libraries)), f"gcc {version_of(given.compiler)} and gcovr {version_of(given.gcovr)}"
    decisions: dict[mcdc.Key, mcdc.Decision] = {}
    for ending, folder in LIBRARIES.items():
        objects = sorted((build / folder).rglob("*.o"))
        profiles = sorted((build / "profiles").glob(f"test_*_{ending}.profraw"))
        if not objects or not profiles:
            raise PageError(
                f"no {'objects' if not objects else 'profiles'} of the tests that end in {ending}: build and run the tests of this build first"
            )
        mcdc.join(decisions, mcdc.read(mcdc.export(given.llvm_cov, given.llvm_profdata, objects, profiles, build)))
    return measured_mcdc(root, decisions), f"clang {version_of(given.compiler)}"


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=tuple(SECTIONS))
    parser.add_argument("--root", type=Path, required=True)
    parser.add_argument("--build", type=Path, required=True)
    parser.add_argument("--compiler", required=True)
    parser.add_argument("--gcovr", default="gcovr")
    parser.add_argument("--llvm-cov", default="llvm-cov")
    parser.add_argument("--llvm-profdata", default="llvm-profdata")
    parser.add_argument("--write", action="store_true", help="write the page's section instead of comparing it")
    given = parser.parse_args()
    given.root, given.build = given.root.resolve(), given.build.resolve()
    path = given.root / PAGE
    page = path.read_text(encoding="utf-8") if path.exists() else ""
    try:
        table = read_table(given.root / TABLE)
        found, compiler = measure(given)
    except (PageError, mcdc.ReadError, subprocess.CalledProcessError, OSError, tomllib.TOMLDecodeError) as error:
        print(f"coverage: {error}")
        return 1
    for kind in found.counts:
        whole = found.total(kind)
        print(f"{kind}: {whole.hit} of {whole.total} reached, {whole.percent:.2f} %; at least {LIMITS[kind]:.0f} %")
    text = section(given.what, found, table, compiler)
    if not given.write and given.what in sections_of(page) and f"Measured with {compiler}." not in page:
        # other programs see other branches, so neither the page nor the table is about theirs
        print(f"the page is not {compiler}'s: limits are held, gaps and digits are not compared")
        found.gaps.clear()
        problems = problems_of(found, [])
    else:
        problems = problems_of(found, table)
        if given.write and not problems:
            page = with_section(page, given.what, text)
            path.write_text(page, encoding="utf-8")
        problems += page_problems(page, given.what, text)
    for problem in problems[:SHOWN]:
        print(problem)
    if len(problems) > SHOWN:
        print(f"and {len(problems) - SHOWN} more")
    print(f"coverage: {len(problems)} problem{'s' if len(problems) != 1 else ''}")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
