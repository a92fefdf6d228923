"""Compares the findings of cppcheck's MISRA addon with the deviations of docs/MISRA.md; cppcheck's own suppressions know no table of reasons.

Every finding against a required or mandatory rule must be marked at its line with a deviation of docs/MISRA.md; every mark needs its finding, every
deviation a mark. Advisory rules are counted. In each precision a file with known faults is looked at too: where they are not found, nothing else was
sought either. Without cppcheck the check is skipped (exit code 77).
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path
from typing import NamedTuple

from sources import c_files, fail, finish, without_comments

SKIP = 77
PRECISIONS = ("EMA_REAL64=0", "EMA_REAL64=1")
DOCUMENT = Path("docs/MISRA.md")

# All others are required.
ADVISORY = frozenset(
    "1.2 2.3 2.4 2.5 2.6 2.7 4.2 5.9 8.7 8.9 8.11 8.13 10.5 11.4 11.5 12.1 12.3 12.4 13.3 13.4 15.1 15.4 15.5 17.5 17.8 18.4 18.5 19.2 20.1"
    " 20.5 20.10 21.12".split()
)
MANDATORY = frozenset("9.1 12.5 13.6 17.3 17.4 17.6 19.1 21.13 21.17 21.18 21.19 21.20 22.2 22.4 22.5 22.6".split())

# Rules about tags; the addon makes up names for enumerations and structures without one.
TAG_RULES = {"2.4", "5.7"}
NO_TAG = re.compile(r"\b(enum|struct|union)\s*\{")

ID = re.compile(r"\bEMA-D\d+\b")
ROW = re.compile(r"^\| (EMA-D\d+) \| (\d+\.\d+) \| (addon|review) \| .+ \|$")
FINDING = re.compile(r"^(.+)\t(\d+)\t(?:misra-c2012-)?(\S+)\t(\w+)\t(.*)$")

# One fault per line: a mixture of types, two kinds of jump, and a copy between types.
SEEDED = """#include <stdint.h>
#include <string.h>
static float ema_seeded(uint16_t wide, float x);
static float ema_seeded(uint16_t wide, float x)
{
    float y = x;
    if (wide == 1) { goto end; }
    (void)memcpy(&y, &wide, sizeof wide);
end:
    return y;
}
"""
SEEDED_RULES = {"10.4", "15.1", "21.15"}


class Finding(NamedTuple):
    """A rule that a line does not keep; `file` is relative to the project."""

    file: str
    line: int
    rule: str


class Deviation(NamedTuple):
    """A row of the document."""

    rule: str
    by_addon: bool


class Line(NamedTuple):
    """A place in a file."""

    file: str
    line: int


def rule_texts() -> str:
    """Texts for the addon to print: it drops a second finding at a line whose text is the same, so each rule gets one of its own."""
    numbers = (f"{chapter}.{number}" for chapter in range(1, 23) for number in range(1, 23))
    return "Appendix A Summary of guidelines\n" + "".join(f"Rule {rule} {kind(rule).capitalize()}\nSee {rule}\n" for rule in numbers)


def kind(rule: str) -> str:
    """mandatory, required or advisory."""
    if rule in MANDATORY:
        return "mandatory"
    return "advisory" if rule in ADVISORY else "required"


def run_addon(cppcheck: str, root: Path, definition: str, jobs: int) -> tuple[set[Finding], set[str], list[str]]:
    """Findings of one precision, the files that were looked at, and what kept the tool from its work."""
    folders = [root / "include", root / "src"]
    with tempfile.TemporaryDirectory() as name:
        work = Path(name).resolve()
        (work / "texts.txt").write_text(rule_texts(), encoding="utf-8")
        (work / "misra.json").write_text(
            json.dumps({"script": "misra.py", "args": [f"--rule-texts={work / 'texts.txt'}"]}), encoding="utf-8"
        )
        seeded = work / "ema_seeded.c"
        seeded.write_text(SEEDED, encoding="utf-8")
        (work / "build").mkdir()
        command = [
            cppcheck,
            f"-j{jobs}",
            "--std=c11",
            "--language=c",
            "--platform=unix32",
            f"-D{definition}",
            *(f"-I{folder}" for folder in folders),
            f"--addon={work / 'misra.json'}",
            "--enable=style",
            f"--cppcheck-build-dir={work / 'build'}",
            "--suppress=missingIncludeSystem",
            "--template={file}\t{line}\t{id}\t{severity}\t{message}",
            str(root / "src"),
            str(seeded),
        ]
        run = subprocess.run(command, capture_output=True, text=True, check=False)
        looked_at = {Path(path).name for path in re.findall(r"^Checking (.*) \.\.\.$", run.stdout, re.MULTILINE)}
        found: set[Finding] = set()
        broken = [
            f"cppcheck: {line}"
            for line in run.stdout.splitlines()
            if line.startswith(("Did not find addon", "cppcheck: error", "Failed to"))
        ]
        in_seeded: set[str] = set()
        for text in run.stderr.splitlines():
            match = FINDING.match(text)
            if match is None:
                continue
            path, line, rule, severity, message = match.groups()
            if "misra-c2012-" in text:
                if Path(path).name == seeded.name:
                    in_seeded.add(rule)
                else:
                    found.add(Finding(Path(path).resolve().relative_to(root).as_posix(), int(line), rule))
            elif rule in ("internalError", "syntaxError", "preprocessorErrorDirective", "cppcheckError", "unknownMacro", "misra-config"):
                broken.append(f"cppcheck, {definition}: {path}:{line}: {rule} ({severity}): {message}")
        missed = SEEDED_RULES - in_seeded
        if missed and not broken:
            broken.append(
                f"cppcheck, {definition}: a file with known faults shows none against {', '.join(sorted(missed))}: is its addon misra installed? {run.stdout[-200:].strip()}"
            )
        return found, looked_at - {seeded.name}, broken


def read_deviations(document: Path) -> dict[str, Deviation]:
    """Deviations by id. Raises ValueError for a row that says less than it must."""
    deviations: dict[str, Deviation] = {}
    for number, line in enumerate(document.read_text(encoding="utf-8").splitlines(), start=1):
        if not line.startswith("| EMA-D"):
            continue
        match = ROW.match(line)
        if match is None:
            raise ValueError(f"{document}:{number}: write | id | one rule | addon or review | reason |")
        name, rule, found_by = match.groups()
        if name in deviations:
            raise ValueError(f"{document}:{number}: {name} stands there twice: give the second a number of its own")
        if kind(rule) != "required":
            raise ValueError(f"{document}:{number}: {rule} is {kind(rule)}: only a required rule can have a deviation")
        deviations[name] = Deviation(rule, found_by == "addon")
    return deviations


def read_marks(root: Path) -> dict[Line, set[str]]:
    """Ids by the line they are for: the line they stand on, or the next one where a comment has a line of its own."""
    marks: dict[Line, set[str]] = {}
    for path in c_files(root, "src", "include"):
        text = path.read_text(encoding="utf-8")
        file = path.relative_to(root).as_posix()
        for number, (line, code) in enumerate(zip(text.splitlines(), without_comments(text).splitlines(), strict=True), start=1):
            names = set(ID.findall(line))
            if names:
                marks.setdefault(Line(file, number if code.strip() else number + 1), set()).update(names)
    return marks


def judge(found: set[Finding], deviations: dict[str, Deviation], marks: dict[Line, set[str]]) -> list[str]:
    """What is wrong about findings, marks and deviations together."""
    problems: list[str] = []
    answered: set[tuple[Line, str]] = set()
    for finding in sorted(found):
        if kind(finding.rule) == "advisory":
            continue
        place = Line(finding.file, finding.line)
        names = [name for name in marks.get(place, ()) if name in deviations and deviations[name].rule == finding.rule]
        answered.update((place, name) for name in names)
        if not names:
            problems.append(
                f"{finding.file}:{finding.line}: against the {kind(finding.rule)} rule {finding.rule}: mend it, or mark it with a deviation of {DOCUMENT}"
            )
    used: set[str] = set()
    for place, marked in sorted(marks.items()):
        for name in sorted(marked):
            used.add(name)
            if name not in deviations:
                problems.append(f"{place.file}:{place.line}: {name} is no deviation of {DOCUMENT}: write its row there")
            elif deviations[name].by_addon and (place, name) not in answered:
                problems.append(
                    f"{place.file}:{place.line}: nothing is found against rule {deviations[name].rule} any more: take the mark {name} off"
                )
    problems += [f"{DOCUMENT}: {name} is used nowhere any more: take its row out" for name in sorted(set(deviations) - used)]
    return problems


def without_tagless(root: Path, found: set[Finding]) -> set[Finding]:
    """The findings without those about a tag on a line that has none."""

    def tagless(finding: Finding) -> bool:
        return (
            finding.rule in TAG_RULES
            and NO_TAG.search((root / finding.file).read_text(encoding="utf-8").splitlines()[finding.line - 1]) is not None
        )

    return {finding for finding in found if not tagless(finding)}


def check(root: Path, cppcheck: str, jobs: int) -> tuple[list[str], int, Counter[str]]:
    """Problems, the number of files looked at, and how often each rule was found."""
    files = {path.name for path in c_files(root, "src", suffixes=(".c",))}
    if not files:
        return [], 0, Counter()
    found: set[Finding] = set()
    problems: list[str] = []
    for definition in PRECISIONS:
        here, looked_at, broken = run_addon(cppcheck, root, definition, jobs)
        found |= here
        problems += broken
        problems += [f"src: {name} was not looked at, {definition}: see what cppcheck says of it" for name in sorted(files - looked_at)]
    found = without_tagless(root, found)
    if not problems:
        problems = judge(found, read_deviations(root / DOCUMENT), read_marks(root))
    return problems, len(files), Counter(finding.rule for finding in found)


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--root", type=Path, required=True)
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    arguments = parser.parse_args()
    cppcheck = shutil.which("cppcheck")
    if cppcheck is None:
        print("misra: no cppcheck on this machine, check skipped: install the package cppcheck to run it")
        return SKIP
    try:
        problems, checked, rules = check(arguments.root.resolve(), cppcheck, arguments.jobs)
    except (OSError, ValueError) as error:
        return fail(f"misra: {error}")
    for group in ("mandatory", "required", "advisory"):
        counts = sorted(
            ((rule, count) for rule, count in rules.items() if kind(rule) == group),
            key=lambda item: [int(part) for part in item[0].split(".")],
        )
        print(
            f"{group}: {sum(count for _, count in counts)} findings"
            + "".join(f"{', ' if at else ': '}{rule} {count}" for at, (rule, count) in enumerate(counts))
        )
    return finish("misra", problems, checked, "files")


if __name__ == "__main__":
    sys.exit(main())
